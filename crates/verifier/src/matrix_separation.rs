//! Separation test of two links within a box of joint positions: distance at its centre against motion in it.

use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use super::body::Body;
use super::matrix_motion::{MatrixMotion, MotionAlong};
use super::matrix_path::{MatrixPath, MatrixState};
use super::separation_test::SeparationTest;

/// The state at the centre of a box of joint positions, and half widths that reach both ends.
pub(super) struct BoxCentre {
    pub state: MatrixState,
    pub half_widths: Vec<f64>,
}

impl BoxCentre {
    pub fn new(path: &MatrixPath, ranges: &[[f64; 2]]) -> Self {
        let values: Vec<f64> = ranges.iter().map(|[low, high]| low.midpoint(*high)).collect();
        let half = |([low, high], middle): (&[f64; 2], &f64)| (middle - low).greater(high - middle).next_up();
        let half_widths = ranges.iter().zip(&values).map(half).collect();
        Self { state: path.state(&values), half_widths }
    }

    /// A direction in the frame of the first link, in that of the ancestor.
    pub fn direction(&self, direction: &Vector) -> Vector {
        MatrixPose::from(&self.state.poses[0]).rotation * direction
    }

    /// A point in the frame of a link, in that of the ancestor.
    pub fn point(&self, side: usize, p: &Point) -> Point {
        &MatrixPose::from(&self.state.poses[side]) * *p
    }

    /// The motion of bodies of the two links in the box.
    pub fn motion<'m>(&'m self, bodies: [&'m Body; 2]) -> MatrixMotion<'m> {
        MatrixMotion { bodies, state: &self.state, half_widths: &self.half_widths }
    }
}

/// Bodies of two links that may be apart in a box.
pub(super) struct ApartTest<'p> {
    pub bodies: [&'p Body; 2],
    /// Distance (m) that they must exceed.
    pub threshold: f64,
}

impl ApartTest<'_> {
    /// True if the distance at the centre exceeds the motion in the box.
    pub fn are_apart(&self, centre: &BoxCentre) -> bool {
        let target = centre.motion(self.bodies).bound(MotionAlong::Any) + self.threshold;
        let [a, b] = self.bodies;
        // no bound holds for the motion of a plane
        let is_bounded =
            centre.half_widths.is_empty() || self.bodies.iter().all(|body| body.planes().is_empty());
        is_bounded && target.is_finite() && SeparationTest::new(a, b, centre.state.pose_ab(), target).prove()
    }

    /// True if the gap along a joint axis exceeds the motion along it.
    pub fn have_gap_along_an_axis(&self, centre: &BoxCentre) -> bool {
        let both = centre.state.axes.iter().flat_map(|axis| [axis.direction, -axis.direction]);
        both.into_iter().any(|along| self.have_gap(centre, &along))
    }

    /// True if the gap along a unit vector, in the frame of the ancestor, exceeds the motion along it.
    pub fn have_gap(&self, centre: &BoxCentre, along: &Vector) -> bool {
        if self.bodies.iter().any(|body| body.root().is_none() || !body.planes().is_empty()) {
            return false;
        }
        let farthest = |side: usize, n: Vector| {
            let pose = MatrixPose::from(&centre.state.poses[side]);
            n.dot(&pose.translation) + self.bodies[side].support(0, &pose.rotation.tr_mul(&n)).0
        };
        let gap = -farthest(1, -along) - farthest(0, *along) - self.threshold;
        gap > 0.0 && gap > centre.motion(self.bodies).bound(MotionAlong::Direction(along))
    }
}
