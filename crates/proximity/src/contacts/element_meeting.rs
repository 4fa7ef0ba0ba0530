//! Meeting of two elements of two bodies: its points and normals, the intersection of the elements, and names of corners.

use std::collections::HashMap;

use clearance_geometry::math::{Extremes, Point, Vector};

/// Where an element of one body meets an element of the other, in the frame of the first body.
#[derive(Clone, Debug)]
pub(super) struct Meeting {
    /// Names of the elements' corners, by body: elements with a common corner are neighbours.
    pub corners: [[u32; 3]; 2],
    pub points: Vec<MeetingPoint>,
    /// Outward normals of the surfaces of both bodies; for a solid, opposite to that of the other body.
    pub normals: [Vector; 2],
    /// True if it is known which side of the surfaces is outside.
    pub has_outside: bool,
    /// Intersection of the surfaces.
    pub common: Common,
}

/// Intersection of two elements.
#[derive(Clone, Copy, Debug)]
pub(super) enum Common {
    /// Nothing, or a point: they are apart, or touch without crossing.
    Point,
    /// Surfaces cross: the segment from the first to the second point, along the cross product of the normals.
    Segment([Point; 2]),
    /// Area (m²) of a surface inside a solid.
    Area(f64),
}

/// A point of a contact and, where it is known, the depth there (m, margin included) and the normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeetingPoint {
    pub position: Point,
    pub normal: Option<Vector>,
    pub depth: Option<f64>,
}

/// Names for the positions of corners: corners at one position have one name.
#[derive(Debug, Default)]
pub(super) struct CornerNames(HashMap<[u64; 3], u32>);

impl CornerNames {
    pub fn of(&mut self, corners: [Point; 3]) -> [u32; 3] {
        corners.map(|p| {
            let next = u32::try_from(self.0.len()).expect("few elements meet");
            *self.0.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert(next)
        })
    }
}

/// Largest distance (m) of the points of some meetings from each other, along the axes.
pub(super) fn extent(meetings: &[Meeting]) -> f64 {
    let mut points = meetings.iter().flat_map(|meeting| &meeting.points).map(|point| point.position);
    let Some(first) = points.next() else { return 0.0 };
    let (low, high) = points.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
    (high - low).amax().greater(0.0)
}
