//! Upper bound on the decrease of a pair's distance within an interval: `docs/derivations/motion-bound.md`.

use clearance_geometry::math::{Extremes, Point, Vector};

use super::body::Body;
use super::interval_midpoint::{Line, Placed};
use super::segment_kinematics::Rate;

/// Steps between the lowest common ancestor of a pair and one of the two, the ancestor's first, and the body's largest distance from the
/// line of each; for an infinite body, the other body's distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<'m> {
    pub path: &'m [usize],
    pub reach: &'m [f64],
}

/// Larger numbers (m, rad, per unit of t) prove nothing: products of several might overflow.
const LARGEST: f64 = 1e12;

/// Motion of one side's body by its steps, relative to the ancestor.
#[derive(Clone, Copy, Debug)]
struct Shift {
    /// Maximum motion of any point (m).
    most: f64,
    /// Maximum deviation (m) of any point from the motion at the velocities of the middle.
    beyond: f64,
    twist: Twist,
}

/// Velocities of a rigid motion, per unit of t: `angular × p + linear` at p.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twist {
    angular: Vector,
    linear: Vector,
}

impl Twist {
    fn speed(&self, p: &Point) -> f64 {
        (self.angular.cross(&p.coords) + self.linear).norm()
    }

    /// Maximum speed of a body that moves with it; `exact` uses the body, otherwise its box is used.
    fn most(&self, body: &Body, placed: &Placed, exact: bool) -> f64 {
        if !body.planes().is_empty() {
            return f64::INFINITY;
        }
        if !exact {
            return placed.corners.iter().map(|p| self.speed(p)).fold(0.0, f64::greater);
        }
        // seen in the body's frame
        let pose = &placed.pose_rb;
        let centre = Point::from(pose.translation);
        let linear = pose.rotation.tr_mul(&(self.angular.cross(&centre.coords) + self.linear));
        let seen = Self { angular: pose.rotation.tr_mul(&self.angular), linear };
        body.greatest(self.angular.norm(), |p| seen.speed(p))
    }
}

impl Side<'_> {
    /// True if all numbers are so small that their sums and products do not overflow.
    fn is_sound(&self, lines: &[Line], rates: &[Rate]) -> bool {
        self.path.iter().all(|step| {
            let (line, rate) = (&lines[*step], &rates[*step]);
            let coordinates = line.origin.iter().chain(line.axis.iter()).copied();
            let mut numbers = coordinates.chain([rate.velocity, rate.most, rate.bent]);
            numbers.all(|x| x.abs() <= LARGEST)
        })
    }

    fn shift(&self, lines: &[Line], rates: &[Rate]) -> Shift {
        let mut twist = Twist { angular: Vector::zeros(), linear: Vector::zeros() };
        for step in self.path {
            let (line, velocity) = (&lines[*step], rates[*step].velocity);
            if line.turns {
                let angular = line.axis * velocity;
                twist.angular += angular;
                twist.linear -= angular.cross(&line.origin.coords);
            } else {
                twist.linear += line.axis * velocity;
            }
        }
        // how far a point ever is from each line: steps beyond it take it no farther than they move it
        let mut most = 0.0;
        let mut far = vec![0.0; self.path.len()];
        for (i, step) in self.path.iter().enumerate().rev() {
            far[i] = if lines[*step].turns { self.reach[i] + most } else { 1.0 };
            most += rates[*step].most * far[i];
        }
        // what the second derivatives make, and what bends in the steps themselves
        let (mut beyond, mut turned) = (0.0, 0.0);
        for (far, step) in far.iter().zip(self.path) {
            let rate = &rates[*step];
            let turns = lines[*step].turns;
            let own = if turns { 0.5 * rate.most } else { 0.0 };
            beyond += far * (rate.most * (turned + own) + rate.bent);
            turned += if turns { rate.most } else { 0.0 };
        }
        Shift { most, beyond, twist }
    }
}

/// The motion of a pair of bodies within an interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairMotion<'m> {
    pub bodies: [&'m Body; 2],
    pub placed: [&'m Placed; 2],
    pub sides: [Side<'m>; 2],
}

impl PairMotion<'_> {
    /// Maximum decrease (m) of the distance within `half_width` of the middle; `exact` uses the bodies, otherwise their boxes are used.
    pub fn bound(&self, lines: &[Line], rates: &[Rate], half_width: f64, exact: bool) -> f64 {
        if !self.sides.iter().all(|side| side.is_sound(lines, rates)) {
            return f64::INFINITY;
        }
        // nothing is claimed for two infinite bodies
        if self.bodies.iter().all(|body| !body.planes().is_empty()) {
            return f64::INFINITY;
        }
        let [a, b] = self.sides.map(|side| side.shift(lines, rates));
        let relative =
            Twist { angular: b.twist.angular - a.twist.angular, linear: b.twist.linear - a.twist.linear };
        let speed = |i: usize| relative.most(self.bodies[i], self.placed[i], exact);
        let first = half_width * speed(0).lesser(speed(1)) + a.beyond + b.beyond;
        (a.most + b.most).lesser(first)
    }
}
