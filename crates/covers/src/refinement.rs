//! Refinement of a cover: moves centres so that the largest excess shrinks, while every sample point stays covered.
//!
//! Alternates between two steps, as variational set approximation does (Wang et al. 2006, *Variational sphere set approximation for solid
//! objects*): points are assigned to balls, then each ball is fitted to its points. Points go to the ball that can take them with the least
//! excess, so balls with little excess take over points of those with much.

use clearance_geometry::math::{Extremes, Point, Vector};

use crate::ball::Ball;
use crate::distance_grid::DistanceGrid;
use crate::samples::directions;
use crate::search_limit::SearchLimit;

/// Number of sampled directions of an excess, and a bound on the part of the radius by which the largest of them falls short.
const DIRECTIONS: u32 = 200;
const SHORTFALL: f64 = 0.012;

/// Number of trials to move a centre in one fit.
const TRIALS: usize = 120;

/// Approximate excess of balls, and their refinement.
pub struct Refinement<'g> {
    grid: &'g DistanceGrid,
    directions: Vec<Vector>,
    /// Distance (m) by which every point lies inside of its ball.
    margin: f64,
    random: fastrand::Rng,
    limit: &'g SearchLimit,
}

/// Balls and their approximate largest excess (m).
#[derive(Clone, Debug)]
pub struct Refined {
    pub balls: Vec<Ball>,
    pub excess: f64,
}

impl<'g> Refinement<'g> {
    pub fn new(grid: &'g DistanceGrid, margin: f64, limit: &'g SearchLimit) -> Self {
        let random = fastrand::Rng::with_seed(5);
        Self { grid, directions: directions(DIRECTIONS), margin, random, limit }
    }

    /// Approximate largest distance (m) of a point of the ball from the solid.
    pub fn excess(&self, ball: &Ball, enough: f64) -> f64 {
        // a ball of radius e around a point at depth e is inside
        let simple = ball.radius + self.grid.value(&ball.centre);
        if simple <= 0.0 {
            return simple;
        }
        let floor = SHORTFALL * ball.radius;
        // an open surface has points far from it in the middle of a ball, too
        let mut most = self.grid.value(&ball.centre).greater(0.0);
        for direction in &self.directions {
            let value = self.grid.value(&(ball.centre + direction * ball.radius));
            most = most.greater(value);
            if most + floor >= simple || most > enough {
                break;
            }
        }
        simple.lesser(most + floor)
    }

    /// Approximate largest distance (m) of a point of the balls from the solid.
    pub fn largest_excess(&self, balls: &[Ball]) -> f64 {
        balls.iter().map(|ball| self.excess(ball, f64::INFINITY)).fold(0.0, Extremes::greater)
    }

    /// Smallest radius (m) around a centre that contains all points.
    fn radius(&self, centre: &Point, points: &[Point]) -> f64 {
        let squared = points.iter().map(|p| (p - centre).norm_squared()).fold(0.0, Extremes::greater);
        squared.sqrt() + self.margin
    }

    /// Moves the centre of a ball such that the ball contains all points with little excess.
    fn fit(&mut self, ball: &Ball, points: &[Point]) -> (Ball, f64) {
        let mut best = Ball { centre: ball.centre, radius: self.radius(&ball.centre, points) };
        let mut least = self.excess(&best, f64::INFINITY);
        let mut step = 0.25 * best.radius + 0.5 * self.grid.step;
        for _ in 0..TRIALS {
            if self.limit.is_over() {
                break;
            }
            let direction = Vector::from_fn(|_, _| 2.0 * self.random.f64() - 1.0);
            let centre = best.centre + direction * step;
            let trial = Ball { centre, radius: self.radius(&centre, points) };
            let excess = self.excess(&trial, least);
            if excess < least {
                (best, least) = (trial, excess);
                step *= 1.6;
            } else {
                step *= 0.88;
            }
        }
        (best, least)
    }

    /// Assigns points to balls whose radii may grow or shrink to an excess of `target`, and fits the balls.
    fn round(
        &mut self,
        balls: &[Ball],
        excesses: &[f64],
        points: &[Point],
        target: f64,
    ) -> (Vec<Ball>, Vec<f64>) {
        let radii: Vec<f64> = balls.iter().zip(excesses).map(|(b, e)| b.radius + target - e).collect();
        let mut assigned = vec![vec![]; balls.len()];
        for p in points {
            let slack = |i: usize| radii[i] - (p - balls[i].centre).norm();
            let best = (1..balls.len()).fold(0, |best, i| if slack(i) > slack(best) { i } else { best });
            assigned[best].push(*p);
        }
        let fits = balls.iter().zip(assigned).filter(|(_, points)| !points.is_empty());
        let fits: Vec<(Ball, f64)> = fits.map(|(ball, points)| self.fit(ball, &points)).collect();
        fits.into_iter().unzip()
    }

    /// Balls with a smaller largest excess that contain all points.
    pub fn refine(&mut self, balls: &[Ball], points: &[Point], rounds: usize) -> Refined {
        let largest = |excesses: &[f64]| excesses.iter().copied().fold(0.0, Extremes::greater);
        let excesses: Vec<f64> = balls.iter().map(|ball| self.excess(ball, f64::INFINITY)).collect();
        let target = largest(&excesses);
        let (mut now, mut now_excesses) = self.round(balls, &excesses, points, target);
        let mut best = Refined { excess: largest(&now_excesses), balls: now.clone() };
        let mut gain = 0.05;
        for _ in 0..rounds {
            if self.limit.is_over() {
                break;
            }
            let target = best.excess * (1.0 - gain);
            (now, now_excesses) = self.round(&now, &now_excesses, points, target);
            let excess = largest(&now_excesses);
            if excess < best.excess {
                best = Refined { excess, balls: now.clone() };
            } else {
                gain *= 0.8;
            }
        }
        best
    }
}
