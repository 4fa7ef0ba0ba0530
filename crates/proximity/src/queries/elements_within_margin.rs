//! Margin query that also returns the two elements found, and the test of these elements alone at a later pose. Bodies
//! that touch usually still do a moment later, at the same place.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;

use crate::body::BodyPair;
use crate::elements::ElementPair;
use crate::narrow_phase::{Separation, separation_within};
use crate::search::{Goal, Scratch, search, separation_of_triangles};

/// The distance of two bodies that come within a margin (m) of each other, and the elements that it is measured between; `None` where it
/// belongs to no elements that [`elements_within_margin`] can test, or if the bodies are proven farther apart.
#[must_use]
pub fn elements_found_within_margin(
    bodies: BodyPair,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<(Separation, Option<ElementPair>)> {
    let found = search::<false>(bodies, Goal { limit: margin, ..Goal::EXACT }, scratch);
    let elements = found.elements.filter(|elements| !elements.a.is_plane() && !elements.b.is_plane());
    Some((found.best?, elements))
}

/// The distance of two elements if they come within a margin (m) of each other. They are of the same bodies, at any pose.
#[must_use]
#[inline]
pub fn elements_within_margin(
    bodies: BodyPair,
    elements: ElementPair,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<Separation> {
    let BodyPair { a, b, pose_ab } = bodies;
    let margin = margin.greater(CONTACT_DISTANCE);
    scratch.work.primitive_tests += 1;
    let surfaces = a.surface().zip(b.surface());
    let found = match surfaces.filter(|_| elements.a.is_triangle() && elements.b.is_triangle()) {
        Some((a, b)) => {
            let (a, b) = (a.triangle(elements.a.index()), b.triangle(elements.b.index()));
            Some(separation_of_triangles(&a, &b, pose_ab))
        }
        None => separation_within(&a.element(elements.a), &b.element(elements.b), pose_ab, margin),
    };
    found.filter(|found| found.distance <= margin)
}
