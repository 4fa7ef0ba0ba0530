//! Test oracle: distance of convex polytopes by V-Clip, a walk between features (vertices, edges, faces).
//! Mirtich 1998, *V-Clip: fast and robust polyhedral collision detection*. Two features are nearest if each is in
//! the Voronoi region of the other. While one is not, it is replaced by a neighbour, and the distance of the
//! features decreases.

use clearance::geometry::math::{Point, Vector};

use super::polytope::Polytope;
use super::separating_plane::gap_along;
use super::voronoi_region::{Clipped, Feature, clip, neighbour_nearer_to};
use crate::random::Random;

/// Number of walks from different features. Rounding may let a walk between nearly parallel features run in circles.
const MOST_WALKS: u32 = 20;

/// Error (m) of a result, relative to the coordinates.
const ROUNDING: f64 = 1e-12;

/// Two convex polytopes have a common point, or a distance.
#[derive(Clone, Copy, Debug)]
pub enum Proximity {
    Overlap(Point),
    Apart { distance: f64, nearest: [Point; 2] },
}

impl Proximity {
    pub fn distance(&self) -> f64 {
        match self {
            Self::Overlap(_) => 0.0,
            Self::Apart { distance, .. } => *distance,
        }
    }
}

/// Distance and nearest points of two polytopes in one frame. The result is checked: it is right up to rounding, or this function panics.
pub fn nearest_features(a: &Polytope, b: &Polytope, random: &mut Random) -> Proximity {
    let mut start = |of: &Polytope| {
        Feature::Vertex(random.below(u32::try_from(of.vertices.len()).expect("few vertices")) as usize)
    };
    for _ in 0..MOST_WALKS {
        let mut walk = Walk { polytopes: [a, b], features: [start(a), start(b)] };
        if let Some(result) = walk.run().filter(|result| walk.is_proven(result)) {
            return result;
        }
    }
    panic!("no walk from {MOST_WALKS} pairs of features ends with a proof:\n{a:?}\n{b:?}")
}

/// The next step of the walk.
enum Step {
    /// A feature has been replaced.
    Continue,
    Nearest,
    Overlap(Point),
}

/// The present features of two polytopes.
struct Walk<'p> {
    polytopes: [&'p Polytope; 2],
    features: [Feature; 2],
}

impl Walk<'_> {
    fn run(&mut self) -> Option<Proximity> {
        let count = |of: &Polytope| of.vertices.len() + of.edges.len() + of.faces.len();
        let most = 20 + 4 * (count(self.polytopes[0]) + count(self.polytopes[1]));
        for number in 0..2 * most {
            match self.step() {
                Step::Overlap(point) => return Some(Proximity::Overlap(point)),
                Step::Nearest => return self.present(),
                // in a circle all pairs are equally far up to rounding; one of them can be proven
                Step::Continue if number > most => {
                    let proven = self.present().filter(|result| self.is_proven(result));
                    if proven.is_some() {
                        return proven;
                    }
                }
                Step::Continue => {}
            }
        }
        None
    }

    /// The result if the present features are the nearest; `None` for a face and an edge, which never are.
    fn present(&self) -> Option<Proximity> {
        if let [Feature::Face(_), Feature::Edge(_)] | [Feature::Edge(_), Feature::Face(_)] = self.features {
            return None;
        }
        let nearest = self.nearest_points();
        let distance = nalgebra::distance(&nearest[0], &nearest[1]);
        let touches = distance <= ROUNDING * self.reach();
        let apart = Proximity::Apart { distance, nearest };
        Some(if touches { Proximity::Overlap(nearest[0]) } else { apart })
    }

    fn step(&mut self) -> Step {
        use Feature::{Edge, Face, Vertex};
        match self.features {
            [Vertex(_), Vertex(_)] => self.vertex_vertex(),
            [Vertex(v), Edge(e)] => self.vertex_edge(0, v, e),
            [Edge(e), Vertex(v)] => self.vertex_edge(1, v, e),
            [Vertex(v), Face(f)] => self.vertex_face(0, v, f),
            [Face(f), Vertex(v)] => self.vertex_face(1, v, f),
            [Edge(e), Edge(f)] => self.edge_edge(e, f),
            [Edge(e), Face(f)] => self.edge_face(0, e, f),
            [Face(f), Edge(e)] => self.edge_face(1, e, f),
            [Face(_), Face(_)] => unreachable!("no step leads to two faces"),
        }
    }

    fn vertex(&self, side: usize, vertex: usize) -> Point {
        self.polytopes[side].vertices[vertex]
    }

    fn ends(&self, side: usize, edge: usize) -> [Point; 2] {
        self.polytopes[side].edges[edge].ends.map(|v| self.vertex(side, v))
    }

    fn replace(&mut self, side: usize, by: Feature) -> Step {
        self.features[side] = by;
        Step::Continue
    }

    fn vertex_vertex(&mut self) -> Step {
        for side in 0..2 {
            let Feature::Vertex(other) = self.features[1 - side] else { unreachable!() };
            let point = self.vertex(1 - side, other);
            if let Some(nearer) = neighbour_nearer_to(&point, self.polytopes[side], self.features[side]) {
                return self.replace(side, nearer);
            }
        }
        Step::Nearest
    }

    /// The vertex is of the polytope `side`, the edge of the other.
    fn vertex_edge(&mut self, side: usize, vertex: usize, edge: usize) -> Step {
        let point = self.vertex(side, vertex);
        if let Some(nearer) = neighbour_nearer_to(&point, self.polytopes[1 - side], Feature::Edge(edge)) {
            return self.replace(1 - side, nearer);
        }
        let ends = self.ends(1 - side, edge);
        self.nearer_where_clipped(side, ends).unwrap_or(Step::Nearest)
    }

    fn edge_edge(&mut self, edge_a: usize, edge_b: usize) -> Step {
        for (side, other) in [(0, edge_b), (1, edge_a)] {
            let ends = self.ends(1 - side, other);
            if let Some(step) = self.nearer_where_clipped(side, ends) {
                return step;
            }
        }
        Step::Nearest
    }

    /// Replaces a vertex or edge by a neighbour that is nearer to another edge: where the distance along that edge still decreases when it
    /// leaves the region.
    fn nearer_where_clipped(&mut self, side: usize, ends: [Point; 2]) -> Option<Step> {
        let (of, feature) = (self.polytopes[side], self.features[side]);
        let (shares, neighbours) = match clip(ends, of, feature) {
            Clipped::Excluded(neighbour) => return Some(self.replace(side, neighbour)),
            Clipped::Range { shares, neighbours } => (shares, neighbours),
        };
        let along = ends[1] - ends[0];
        for (share, neighbour, outward) in [(shares[0], neighbours[0], -1.0), (shares[1], neighbours[1], 1.0)]
        {
            let Some(neighbour) = neighbour else { continue };
            let at = ends[0] + along * share;
            // at the plane between them, both are equally far: the simpler one is used
            let away = match (feature, neighbour) {
                (Feature::Vertex(vertex), _) | (_, Feature::Vertex(vertex)) => at - of.vertices[vertex],
                (_, Feature::Face(face)) => of.faces[face].normal * of.height_over(face, &at).signum(),
                (_, Feature::Edge(_)) => unreachable!("no edge is a neighbour of an edge"),
            };
            if outward * along.dot(&away) < 0.0 {
                return Some(self.replace(side, neighbour));
            }
        }
        None
    }

    /// The vertex is of the polytope `side`, the face of the other.
    fn vertex_face(&mut self, side: usize, vertex: usize, face: usize) -> Step {
        let (point, other) = (self.vertex(side, vertex), self.polytopes[1 - side]);
        if let Some(nearer) = neighbour_nearer_to(&point, other, Feature::Face(face)) {
            return self.replace(1 - side, nearer);
        }
        let height = other.height_over(face, &point);
        for edge in self.polytopes[side].edges_of[vertex].clone() {
            let [p, q] = self.polytopes[side].edges[edge].ends;
            let end = self.vertex(side, if p == vertex { q } else { p });
            let of_end = other.height_over(face, &end);
            if height > 0.0 && of_end < height || height < 0.0 && of_end > height {
                return self.replace(side, Feature::Edge(edge));
            }
        }
        if height > 0.0 { Step::Nearest } else { self.behind_face(side, &point) }
    }

    /// A vertex within the prism behind a face: it is inside, or nearer to the face that it is farthest in front of.
    fn behind_face(&mut self, side: usize, point: &Point) -> Step {
        let other = self.polytopes[1 - side];
        let heights = (0..other.faces.len()).map(|face| (other.height_over(face, point), face));
        let (height, face) = heights.max_by(|p, q| p.0.total_cmp(&q.0)).expect("it has faces");
        if height <= 0.0 { Step::Overlap(*point) } else { self.replace(1 - side, Feature::Face(face)) }
    }

    /// The edge is of the polytope `side`, the face of the other.
    fn edge_face(&mut self, side: usize, edge: usize, face: usize) -> Step {
        let (ends, other) = (self.ends(side, edge), self.polytopes[1 - side]);
        let (shares, neighbours) = match clip(ends, other, Feature::Face(face)) {
            Clipped::Range { shares, neighbours } if shares[0] <= shares[1] => (shares, neighbours),
            _ => return self.nearest_side_of_face(side, &ends, face),
        };
        let at = shares.map(|share| ends[0] + (ends[1] - ends[0]) * share);
        let heights = at.map(|point| other.height_over(face, &point));
        if heights[0] * heights[1] <= 0.0 {
            let share = if heights[0] == heights[1] { 0.0 } else { heights[0] / (heights[0] - heights[1]) };
            return Step::Overlap(at[0] + (at[1] - at[0]) * share);
        }
        let [of_tail, of_head] = ends.map(|end| other.height_over(face, &end));
        let rises = (of_head - of_tail) * heights[0] >= 0.0;
        let nearest = usize::from(!rises);
        match neighbours[nearest] {
            Some(neighbour) => self.replace(1 - side, neighbour),
            None => self.replace(side, Feature::Vertex(self.polytopes[side].edges[edge].ends[nearest])),
        }
    }

    /// An edge outside of the prism over a face is nearest to one of its edges.
    fn nearest_side_of_face(&mut self, side: usize, ends: &[Point; 2], face: usize) -> Step {
        let edges = &self.polytopes[1 - side].faces[face].edges;
        let distance = |edge: usize| {
            let [p, q] = nearest_on_segments(ends, &self.ends(1 - side, edge));
            nalgebra::distance(&p, &q)
        };
        let distances = edges.iter().map(|edge| (distance(*edge), *edge));
        let (_, nearest) = distances.min_by(|p, q| p.0.total_cmp(&q.0)).expect("a face has edges");
        self.replace(1 - side, Feature::Edge(nearest))
    }

    fn nearest_points(&self) -> [Point; 2] {
        use Feature::{Edge, Face, Vertex};
        match self.features {
            [Face(face), Vertex(vertex)] => {
                let point = self.vertex(1, vertex);
                [self.polytopes[0].foot(face, &point), point]
            }
            [Vertex(vertex), Face(face)] => {
                let point = self.vertex(0, vertex);
                [point, self.polytopes[1].foot(face, &point)]
            }
            [Face(_), _] | [_, Face(_)] => unreachable!("a nearest face has a nearest vertex"),
            features => {
                let ends = |side: usize| match features[side] {
                    Edge(edge) => self.ends(side, edge),
                    Vertex(vertex) => [self.vertex(side, vertex); 2],
                    Face(_) => unreachable!(),
                };
                nearest_on_segments(&ends(0), &ends(1))
            }
        }
    }

    fn reach(&self) -> f64 {
        self.polytopes[0].reach().max(self.polytopes[1].reach())
    }

    /// Nearest points are proven by parallel planes through them that have the polytopes on either side, a common point by both polytopes.
    fn is_proven(&self, result: &Proximity) -> bool {
        let [a, b] = self.polytopes;
        match result {
            Proximity::Overlap(point) => a.holds(point) && b.holds(point),
            Proximity::Apart { distance, nearest } => {
                let gaps =
                    self.directions(nearest).into_iter().map(|n| gap_along(&a.vertices, &b.vertices, &n));
                let gap = gaps.fold(f64::NEG_INFINITY, f64::max);
                let are_inside = a.holds(&nearest[0]) && b.holds(&nearest[1]);
                are_inside && distance - gap <= ROUNDING * self.reach()
            }
        }
    }

    /// Unit vectors of which one is at right angles to the widest gap's planes. The gap along any of them proves a distance. Between points
    /// that are near to each other the direction is inaccurate; the normals of faces and edges are not.
    fn directions(&self, nearest: &[Point; 2]) -> Vec<Vector> {
        let between = (nearest[1] - nearest[0]).normalize();
        let [of_a, of_b] = self.polytopes.map(|of| of.faces.iter().map(|face| face.normal));
        let mut all: Vec<Vector> = of_a.chain(of_b.map(|normal| -normal)).collect();
        if let [Feature::Edge(e), Feature::Edge(f)] = self.features {
            let [along_e, along_f] = [self.ends(0, e), self.ends(1, f)].map(|[p, q]| (q - p).normalize());
            let across = along_e.cross(&along_f);
            all.extend(across.try_normalize(1e-6).map(|n| n * n.dot(&between).signum()));
        }
        all.push(between);
        all
    }
}

impl Polytope {
    /// The point of a face's plane below a point.
    fn foot(&self, face: usize, point: &Point) -> Point {
        point - self.faces[face].normal * self.height_over(face, point)
    }
}

/// Nearest points of two segments, which may be points: the best of the common perpendicular and of all ends.
fn nearest_on_segments(a: &[Point; 2], b: &[Point; 2]) -> [Point; 2] {
    let on = |[p, q]: &[Point; 2], point: &Point| {
        let along = q - p;
        let share = along.dot(&(point - p)) / along.norm_squared().max(f64::MIN_POSITIVE);
        p + along * share.clamp(0.0, 1.0)
    };
    let mut candidates: Vec<[Point; 2]> = a.iter().map(|p| [*p, on(b, p)]).collect();
    candidates.extend(b.iter().map(|q| [on(a, q), *q]));
    let (along_a, along_b) = (a[1] - a[0], b[1] - b[0]);
    let across = along_a.cross(&along_b);
    if across.norm_squared() > 0.0 {
        let share = (b[0] - a[0]).cross(&along_b).dot(&across) / across.norm_squared();
        let p = a[0] + along_a * share.clamp(0.0, 1.0);
        let q = on(b, &p);
        candidates.push([on(a, &q), q]);
    }
    let distance = |[p, q]: &[Point; 2]| nalgebra::distance(p, q);
    candidates.into_iter().min_by(|p, q| distance(p).total_cmp(&distance(q))).expect("not empty")
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance::geometry::math::{Pose, Rotation};
    use std::f64::consts::FRAC_PI_4;

    fn shifted(polytope: &Polytope, by: Vector) -> Polytope {
        polytope.placed(&Pose::from_parts(by.into(), Rotation::identity()))
    }

    #[test]
    fn two_cubes_are_apart_by_a_known_distance() {
        let mut random = Random::new(1);
        let cube = Polytope::cuboid([0.5; 3]);
        for (by, truth) in [
            (Vector::new(1.5, 0.0, 0.0), 0.5),
            (Vector::new(1.3, 1.4, 0.0), 0.5),
            (Vector::new(-2.0, 3.0, 3.0), 3.0),
            (Vector::new(1.0, 0.3, 0.2), 0.0),
            (Vector::new(1.0, 1.0, 0.0), 0.0),
            (Vector::new(1.0, -1.0, 1.0), 0.0),
            (Vector::new(0.9, 0.2, 0.1), 0.0),
            (Vector::zeros(), 0.0),
        ] {
            for _ in 0..30 {
                let found = nearest_features(&cube, &shifted(&cube, by), &mut random);
                assert!((found.distance() - truth).abs() < 1e-14, "{by:?} {found:?}");
            }
        }
    }

    #[test]
    fn the_edge_of_a_turned_cube_is_over_a_face_or_an_edge() {
        let mut random = Random::new(2);
        let cube = Polytope::cuboid([0.5; 3]);
        let turned = |axis: usize| {
            let turn = Rotation::from_scaled_axis(Vector::ith(axis, FRAC_PI_4));
            cube.placed(&Pose::from_parts(nalgebra::one(), turn))
        };
        let diagonal = 0.5_f64.sqrt();
        for x in [0.0, 0.2, 0.4] {
            // the lower edge of the turned cube is parallel to the face below
            let above = shifted(&turned(0), Vector::new(x, 0.0, 0.5 + diagonal + 0.25));
            assert!((nearest_features(&cube, &above, &mut random).distance() - 0.25).abs() < 1e-14);
        }
        // two edges that cross at right angles, the one above the other
        let below = turned(1);
        let above = shifted(&turned(0), Vector::new(0.0, 0.0, 2.0 * diagonal + 0.125));
        assert!((nearest_features(&below, &above, &mut random).distance() - 0.125).abs() < 1e-14);
    }

    #[test]
    fn points_segments_and_triangles_are_polytopes_too() {
        let mut random = Random::new(3);
        let cube = Polytope::cuboid([0.5; 3]);
        let [p, q] = [Point::new(1.0, -2.0, 0.0), Point::new(1.0, 2.0, 0.0)];
        for (flat, truth) in [
            (Polytope::point(p), 0.5_f64.hypot(1.5)),
            (Polytope::point(Point::new(0.1, 0.2, 0.5)), 0.0),
            (Polytope::segment([p, q]), 0.5),
            (Polytope::segment([Point::new(-1.0, -1.0, -1.0), Point::new(2.0, 2.0, 2.0)]), 0.0),
            (Polytope::triangle([p, q, Point::new(3.0, 0.0, 1.0)]), 0.5),
            (Polytope::triangle([p, q, Point::new(-3.0, 0.0, 0.0)]), 0.0),
        ] {
            for _ in 0..10 {
                let found = nearest_features(&cube, &flat, &mut random).distance();
                let swapped = nearest_features(&flat, &cube, &mut random).distance();
                assert!((found - truth).abs() < 1e-14 && (swapped - truth).abs() < 1e-14, "{found} {truth}");
            }
        }
    }

    #[test]
    fn planted_results_are_not_proven() {
        let cube = Polytope::cuboid([0.5; 3]);
        let other = shifted(&cube, Vector::new(2.0, 0.0, 0.0));
        let walk = Walk { polytopes: [&cube, &other], features: [Feature::Vertex(0), Feature::Vertex(0)] };
        let apart =
            |p: Point, q: Point| Proximity::Apart { distance: nalgebra::distance(&p, &q), nearest: [p, q] };
        let [p, q] = [Point::new(0.5, 0.1, 0.0), Point::new(1.5, 0.1, 0.0)];
        assert!(walk.is_proven(&apart(p, q)));
        assert!(!walk.is_proven(&apart(p, Point::new(1.5, 0.2, 0.0)))); // not the nearest
        assert!(!walk.is_proven(&apart(p, Point::new(1.4, 0.1, 0.0)))); // not on the second cube
        assert!(!walk.is_proven(&Proximity::Overlap(p)));
    }
}
