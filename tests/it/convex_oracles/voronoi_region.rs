//! Test helper: Voronoi regions of the features of a polytope, and the clipping of edges to them.
//! Planes between a feature and its neighbours bound them.

use clearance::geometry::math::{Point, Vector};

use super::polytope::Polytope;

/// A vertex, edge or face, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    Vertex(usize),
    Edge(usize),
    Face(usize),
}

/// A plane between the regions of a feature and of one of its neighbours.
pub struct RegionPlane {
    point: Point,
    /// Unit normal towards the region of the feature.
    inward: Vector,
    pub neighbour: Feature,
}

/// The part of an edge in a region.
#[derive(Debug)]
pub enum Clipped {
    /// All of the edge is beyond the plane to this neighbour.
    Excluded(Feature),
    /// Where the edge enters and leaves, as shares of its length, and the neighbours there. Empty where it enters after it leaves.
    Range { shares: [f64; 2], neighbours: [Option<Feature>; 2] },
}

impl RegionPlane {
    pub fn height(&self, point: &Point) -> f64 {
        self.inward.dot(&(point - self.point))
    }
}

/// The planes around the region of a feature. The region of a face is the prism over it: on which side of the face a point is, is
/// not looked at.
pub fn region(of: &Polytope, feature: Feature) -> Vec<RegionPlane> {
    let away = |from: usize, to: usize| (of.vertices[from] - of.vertices[to]).normalize();
    match feature {
        Feature::Vertex(vertex) => {
            let plane = |edge: &usize| {
                let [p, q] = of.edges[*edge].ends;
                let other = if p == vertex { q } else { p };
                let (point, inward) = (of.vertices[vertex], away(vertex, other));
                RegionPlane { point, inward, neighbour: Feature::Edge(*edge) }
            };
            of.edges_of[vertex].iter().map(plane).collect()
        }
        Feature::Edge(edge) => {
            let [p, q] = of.edges[edge].ends;
            let end = |at: usize, other: usize| {
                let (point, inward) = (of.vertices[at], away(other, at));
                RegionPlane { point, inward, neighbour: Feature::Vertex(at) }
            };
            let side = |face: &usize| {
                let (point, inward) = (of.vertices[p], of.away_from_face(edge, *face));
                RegionPlane { point, inward, neighbour: Feature::Face(*face) }
            };
            let sides = of.edges[edge].faces.iter().map(side);
            [end(p, q), end(q, p)].into_iter().chain(sides).collect()
        }
        Feature::Face(face) => {
            let plane = |edge: &usize| {
                let point = of.vertices[of.edges[*edge].ends[0]];
                RegionPlane {
                    point,
                    inward: -of.away_from_face(*edge, face),
                    neighbour: Feature::Edge(*edge),
                }
            };
            of.faces[face].edges.iter().map(plane).collect()
        }
    }
}

/// The neighbour behind the plane that a point is farthest beyond; `None` if it is in the region.
pub fn neighbour_nearer_to(point: &Point, of: &Polytope, feature: Feature) -> Option<Feature> {
    let heights = region(of, feature).into_iter().map(|plane| (plane.height(point), plane.neighbour));
    let lowest = heights.min_by(|p, q| p.0.total_cmp(&q.0));
    lowest.filter(|(height, _)| *height < 0.0).map(|(_, neighbour)| neighbour)
}

/// Clips an edge against the region of a feature.
pub fn clip([tail, head]: [Point; 2], of: &Polytope, feature: Feature) -> Clipped {
    let (mut shares, mut neighbours) = ([0.0, 1.0], [None; 2]);
    for plane in region(of, feature) {
        let (at_tail, at_head) = (plane.height(&tail), plane.height(&head));
        let share = at_tail / (at_tail - at_head);
        if at_tail < 0.0 && at_head < 0.0 {
            return Clipped::Excluded(plane.neighbour);
        } else if at_tail < 0.0 && share > shares[0] {
            (shares[0], neighbours[0]) = (share, Some(plane.neighbour));
        } else if at_head < 0.0 && share < shares[1] {
            (shares[1], neighbours[1]) = (share, Some(plane.neighbour));
        }
    }
    Clipped::Range { shares, neighbours }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn a_point_is_in_the_region_of_the_nearest_feature() {
        let cuboid = Polytope::cuboid([1.0, 2.0, 3.0]);
        for (point, is_of) in [
            (Point::new(5.0, 0.5, 0.5), "face"),
            (Point::new(2.0, 4.0, 0.5), "edge"),
            (Point::new(2.0, 4.0, -4.0), "vertex"),
        ] {
            let mut all: Vec<Feature> = (0..8).map(Feature::Vertex).collect();
            all.extend((0..12).map(Feature::Edge));
            all.extend((0..6).map(Feature::Face).filter(|f| {
                let Feature::Face(face) = f else { return false };
                cuboid.height_over(*face, &point) > 0.0
            }));
            let held: Vec<Feature> =
                all.into_iter().filter(|f| neighbour_nearer_to(&point, &cuboid, *f).is_none()).collect();
            let [found] = held[..] else { panic!("{held:?}") };
            let name = match found {
                Feature::Vertex(_) => "vertex",
                Feature::Edge(_) => "edge",
                Feature::Face(_) => "face",
            };
            assert_eq!(name, is_of);
        }
    }

    #[test]
    fn the_clipped_part_of_an_edge_is_in_the_region_and_the_rest_is_not() {
        let (mut random, cuboid) = (Random::new(4), Polytope::cuboid([0.3, 0.4, 0.5]));
        let mut clipped = 0;
        for _ in 0..2000 {
            let ends = [random.point(1.0), random.point(1.0)];
            let feature = [Feature::Vertex(3), Feature::Edge(5), Feature::Face(2)][random.below(3) as usize];
            let share = random.within(0.0, 1.0);
            let point = ends[0] + (ends[1] - ends[0]) * share;
            let is_in = neighbour_nearer_to(&point, &cuboid, feature).is_none();
            let is_kept = match clip(ends, &cuboid, feature) {
                Clipped::Excluded(_) => false,
                Clipped::Range { shares: [enters, leaves], .. } => enters <= share && share <= leaves,
            };
            assert_eq!(is_in, is_kept);
            clipped += u32::from(is_in);
        }
        assert!(clipped > 100, "{clipped}");
    }
}
