//! Chords of closed surfaces: the parts of a line inside.

use clearance_geometry::math::MatrixPose;

use super::chord::{Chord, Line};
use super::surface_pair::PlacedSurface;
use super::touching_elements::for_touching;
use crate::body::Surface;
use crate::bvh::TreePair;
use crate::search::Scratch;

/// Distance (m) below which a line passes an edge of two faces, and not two faces.
const ONE_PLACE: f64 = 1e-9;

/// A point of a line in a surface.
#[derive(Clone, Copy, Debug)]
struct Hit {
    /// Parameter (m) of the line.
    at: f64,
    /// Whether the line enters the solid there, or leaves it.
    enters: bool,
}

/// The part of a line around its origin inside the closed surfaces of a body; the origin may be up to `slack` (m) outside.
pub(super) fn chord_at(
    placed: &PlacedSurface,
    line: &Line,
    slack: f64,
    scratch: &mut Scratch,
) -> Option<Chord> {
    let chords = chords(placed, line, scratch).into_iter();
    chords.filter(|chord| chord.from <= slack && chord.to >= -slack).reduce(Chord::longer)
}

/// The parts of a line inside the closed surfaces of a body: where the winding number is positive. The line is in the frame of the first
/// body.
fn chords(placed: &PlacedSurface, line: &Line, scratch: &mut Scratch) -> Vec<Chord> {
    let mut hits = hits(placed, line, scratch);
    hits.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.enters.cmp(&b.enters)));
    hits.dedup_by(|b, a| a.enters == b.enters && b.at - a.at <= ONE_PLACE);
    let (mut chords, mut winding, mut start) = (Vec::new(), 0, 0.0);
    for hit in hits {
        let before = winding;
        winding += if hit.enters { 1 } else { -1 };
        if before <= 0 && winding > 0 {
            start = hit.at;
        } else if before > 0 && winding <= 0 {
            chords.push(Chord { from: start, to: hit.at });
        }
    }
    chords
}

/// Everywhere that a line passes through a face of a closed surface; a face that contains the line is not hit.
fn hits(placed: &PlacedSurface, line: &Line, scratch: &mut Scratch) -> Vec<Hit> {
    let PlacedSurface { surface, winding, pose } = placed;
    let own = line.seen_from(pose);
    let length = surface.tree().reach() + nalgebra::distance(surface.tree().anchor(), &own.origin);
    let ends = [own.at(-length), own.at(length)];
    let Some(segment) = Surface::new(ends.to_vec(), &[[0, 1, 1]]) else { return Vec::new() };
    let relative = &segment.tree().relative(surface.tree(), &MatrixPose::identity());
    let trees = TreePair { a: segment.tree(), b: surface.tree(), relative };
    let mut found = Vec::new();
    for_touching(trees, 0.0, 0.0, scratch, &mut |_, index| {
        let triangle = surface.triangle(index);
        let sign = winding.sign(surface.corners(index));
        let Some((sign, point)) = sign.zip(triangle.pierced_by(&ends)) else { return false };
        let at = (point - own.origin).dot(&own.direction);
        found.push(Hit { at, enters: sign * triangle.normal().dot(&own.direction) < 0.0 });
        true
    });
    found
}
