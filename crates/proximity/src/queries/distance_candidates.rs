//! Candidates for the nearest elements of two bodies, bounded in single precision. The caller measures those that may
//! be the nearest of all pairs exactly.

use clearance_geometry::math::Extremes;

use crate::body::{BodyPair, Piece};
use crate::elements::{ElementId, ElementPair};
use crate::narrow_phase::Separation;
use crate::search::{
    Goal, Scratch, SearchResult, SearchedPieces, TriangleCandidate, search_pieces, separation_of_triangles,
};

/// A candidate for the nearest elements of two bodies.
#[derive(Clone, Copy, Debug)]
pub struct DistanceCandidate {
    /// Lower bound (m) on its distance.
    pub lower: f64,
    elements: Elements,
}

/// A candidate that is measured already, or two triangles that are not.
#[derive(Clone, Copy, Debug)]
enum Elements {
    Measured(Separation, Option<ElementPair>),
    Triangles { a: u32, b: u32 },
}

/// Searches a and some pieces of b, or all of b, and passes all candidates not farther apart than `limit` (m) to
/// `collect`. Returns an upper bound (m) on the distance; infinity, if there is none.
pub fn distance_candidates(
    bodies: BodyPair,
    pieces: Option<&[Piece]>,
    limit: f64,
    scratch: &mut Scratch,
    mut collect: impl FnMut(DistanceCandidate),
) -> f64 {
    let SearchResult { best, elements, .. } = search_postponed(bodies, pieces, limit, scratch);
    let mut upper = f64::from(scratch.candidates().upper());
    if let Some(best) = best {
        upper = upper.lesser(best.distance);
        collect(DistanceCandidate { lower: best.distance, elements: Elements::Measured(best, elements) });
    }
    for TriangleCandidate { lower, a, b } in scratch.candidates().drain() {
        let lower = f64::from(lower);
        if lower <= upper.lesser(limit) {
            collect(DistanceCandidate { lower, elements: Elements::Triangles { a, b } });
        }
    }
    upper
}

/// Searches without measuring triangles: those that may be nearest are left among the candidates.
fn search_postponed(
    bodies: BodyPair,
    pieces: Option<&[Piece]>,
    limit: f64,
    scratch: &mut Scratch,
) -> SearchResult {
    let pieces = pieces.map_or(SearchedPieces::All, SearchedPieces::new);
    search_pieces::<false>(bodies, pieces, Goal { limit, postpones: true, ..Goal::EXACT }, scratch)
}

impl DistanceCandidate {
    /// The exact distance of the candidate and its elements, for the bodies that it belongs to.
    #[inline]
    pub fn measured(&self, bodies: BodyPair, scratch: &mut Scratch) -> (Separation, Option<ElementPair>) {
        match self.elements {
            Elements::Measured(found, elements) => (found, elements),
            Elements::Triangles { a: i, b: j } => {
                scratch.work.primitive_tests += 1;
                let BodyPair { a, b, pose_ab } = bodies;
                let (a, b) = a.surface().zip(b.surface()).expect("triangles are of surfaces");
                let elements = ElementPair { a: ElementId::of_triangle(i), b: ElementId::of_triangle(j) };
                (separation_of_triangles(&a.triangle(i), &b.triangle(j), pose_ab), Some(elements))
            }
        }
    }
}
