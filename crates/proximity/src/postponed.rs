//! The least distance over several pairs of bodies: all are bounded in single precision first; only candidates that may still be the
//! nearest of all are then measured exactly.

use clearance_geometry::math::{Extremes, MatrixPose};

use super::body::CollisionBody;
use super::element::ElementNumber;
use super::element_pair::Separation;
use super::piece::Piece;
use super::scratch::Scratch;
use super::search::{Goal, Pieces, search_pieces};
use super::surface_surface::separation_of_triangles;
use crate::bounding_volume::Obb;

/// A candidate for the nearest elements of two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Postponed {
    /// Lower bound (m) on its distance.
    pub lower: f64,
    what: What,
}

#[derive(Clone, Copy, Debug)]
enum What {
    Found(Separation, Option<ElementPair>),
    Triangles(u32, u32),
}

/// The indices of two measured elements; they decide which of equally near pairs is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ElementPair(ElementNumber, ElementNumber);

/// Searches a and some pieces of b, or all of b, and passes all candidates not farther apart than `limit` (m) to `postpone`. Returns an
/// upper bound (m) on the distance; infinity, if there is none.
#[inline]
pub fn nearest_in_doubt(
    a: &CollisionBody,
    (b, pieces): (&CollisionBody, Option<&[Piece]>),
    pose_ab: &MatrixPose,
    limit: f64,
    scratch: &mut Scratch,
    mut postpone: impl FnMut(Postponed),
) -> f64 {
    let goal = Goal { limit, postpones: true, ..Goal::EXACT };
    let found =
        search_pieces::<Obb, false>((a, b), pieces.map_or(Pieces::All, Pieces::Some), pose_ab, goal, scratch);
    let mut upper = scratch.candidates.upper();
    if let Some(best) = found.best {
        upper = upper.lesser(best.distance);
        let numbers = found.numbers.map(|(a, b)| ElementPair(a, b));
        postpone(Postponed { lower: best.distance, what: What::Found(best, numbers) });
    }
    for (lower, i, j) in scratch.candidates.drain() {
        if lower <= upper.lesser(limit) {
            postpone(Postponed { lower, what: What::Triangles(i, j) });
        }
    }
    upper
}

impl Postponed {
    /// The exact distance of the candidate and its elements, for the bodies that it belongs to.
    #[inline]
    pub fn measured(
        &self,
        (a, b): (&CollisionBody, &CollisionBody),
        pose_ab: &MatrixPose,
        scratch: &mut Scratch,
    ) -> (Separation, Option<ElementPair>) {
        match self.what {
            What::Found(found, numbers) => (found, numbers),
            What::Triangles(i, j) => {
                scratch.work.primitive_tests += 1;
                let surfaces = a.surface.as_ref().zip(b.surface.as_ref());
                let (a, b) = surfaces.expect("triangles are of surfaces");
                let numbers = ElementPair(ElementNumber::of_triangle(i), ElementNumber::of_triangle(j));
                (separation_of_triangles((a, i), (b, j), pose_ab), Some(numbers))
            }
        }
    }
}
