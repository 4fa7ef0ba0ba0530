//! Where bodies can ever be: known before any position is.

use super::{Chain, Step};
use crate::math::Vector;

/// Rounding that is granted to sums of lengths.
const GRANTED: f64 = 1e-9;

/// A ball (root frame) that something never leaves, whatever the positions are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Territory {
    pub centre: Vector,
    /// Infinite where joints slide or float (m).
    pub radius: f64,
}

impl Chain {
    /// The territories of the origins of all bodies, by body. Joints turn as far as they like.
    #[must_use]
    pub fn territories(&self) -> Vec<Territory> {
        let mut all = vec![Territory { centre: Vector::zeros(), radius: 0.0 }];
        for body in &self.bodies {
            let Territory { centre, radius } = all[body.parent];
            let offset = Vector::from(body.origin);
            all.push(match body.step {
                Step::Turn(..) if body.parent == Self::ROOT => Territory { centre: offset, radius: 0.0 },
                Step::Turn(..) => {
                    Territory { centre, radius: (radius + offset.norm()) * (1.0 + GRANTED) + GRANTED }
                }
                Step::Shift(..) | Step::Float(..) => Territory { centre, radius: f64::INFINITY },
            });
        }
        all
    }
}
