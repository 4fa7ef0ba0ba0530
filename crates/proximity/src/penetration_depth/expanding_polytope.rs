//! Penetration depth of two convex solids by the expanding polytope algorithm (van den Bergen 2001, *Proximity queries and penetration
//! depth computation on 3D game objects*).
//!
//! The Minkowski difference of two solids A and B is the set of all translations of B after which it overlaps A; the depth is the
//! distance from the origin to its boundary. A polytope of support points lies inside, so the least distance of its faces is a lower
//! bound; the support plane in any direction is an upper bound. Both are proven up to rounding, for which they are widened.

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use super::convex_solid::SupportMap;

/// Gap between the bounds, relative to the upper one, at which the search ends.
const RELATIVE_ACCURACY: f64 = 1e-9;

/// Rounding error of the bounds, relative to the coordinates of support points.
const ROUNDING: f64 = 1e-13;

/// Largest number of support points. Flat solids need a few dozen; curved ones come within 1e-6 of the depth by then.
const MOST_POINTS: usize = 400;

/// Most likely normals that are tested where the search ends early.
const MOST_NORMALS: usize = 64;

/// Two convex solids, the second posed in the frame of the first. `rounded` solids include their radius in support points.
pub(super) struct ConvexPair<'s, A, B> {
    pub a: &'s A,
    pub b: &'s B,
    pub pose_ab: &'s MatrixPose,
    pub rounded: bool,
}

/// Bounds on the penetration depth (m) of two overlapping convex solids.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConvexDepth {
    pub lower: f64,
    pub upper: f64,
    /// Translation of the second solid by `upper` along this unit vector separates them.
    pub direction: Vector,
    /// The point of the first solid that is deepest in the second one, and the reverse; in the frame of the first.
    pub witness_points: [Point; 2],
}

impl ConvexDepth {
    /// The same as seen from the other solid, which is posed in the frame of the first.
    pub fn swapped(self, pose_ab: &MatrixPose) -> Self {
        let [on_b, on_a] = self.witness_points.map(|p| pose_ab * p);
        Self { direction: -(pose_ab.rotation * self.direction), witness_points: [on_a, on_b], ..self }
    }
}

/// A support point of the Minkowski difference.
#[derive(Clone, Copy, Debug)]
struct Support {
    on_a: Vector,
    difference: Vector,
}

/// Triangle of the polytope, with its outward unit normal and its distance from the origin.
#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [usize; 3],
    normal: Vector,
    offset: f64,
    /// True if the support point along the normal is known.
    is_probed: bool,
}

/// A direction in which two overlapping solids separate by a translation that is as short as the shortest, within a tolerance.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeparatingDirection {
    pub normal: Vector,
    /// Length (m) of the translation.
    height: f64,
    /// The points of the cores that come apart last, in the frame of the first solid.
    pub core_points: [Point; 2],
}

/// Closed convex polyhedron of support points.
struct Polytope {
    supports: Vec<Support>,
    faces: Vec<Face>,
    /// Length (m) below which two points count as equal.
    resolution: f64,
}

impl<A: SupportMap, B: SupportMap> ConvexPair<'_, A, B> {
    /// The depth; `None` if a direction separates the solids, or if their Minkowski difference is flat.
    pub fn depth(&self) -> Option<ConvexDepth> {
        let mut polytope = self.first_tetrahedron()?;
        let mut upper = (f64::INFINITY, Vector::x());
        loop {
            let face = *polytope.nearest_face();
            let support = self.support(&face.normal);
            let height = face.normal.dot(&support.difference);
            if height <= 0.0 {
                return None;
            }
            if height < upper.0 {
                upper = (height, face.normal);
            }
            let is_accurate = upper.0 - face.offset <= RELATIVE_ACCURACY * upper.0 + polytope.resolution;
            if is_accurate {
                return Some(self.result(&polytope, &face, upper));
            }
            if polytope.supports.len() >= MOST_POINTS || !polytope.expand(&face, support) {
                let upper = self.least_of_normals(&face.normal, upper)?;
                return Some(self.result(&polytope, &face, upper));
            }
        }
    }

    /// The shortest of a translation (m, with its direction) and those along likely normals of the solids: a search that rounding ends
    /// early misses exact ones. Tests those nearest to an `expected` direction. `None` if a direction separates the solids.
    fn least_of_normals(&self, expected: &Vector, found: (f64, Vector)) -> Option<(f64, Vector)> {
        let rotation = self.pose_ab.rotation;
        let of_b = self.b.likely_normals().into_iter().map(|n| -(rotation * n));
        let mut normals: Vec<Vector> = self.a.likely_normals().into_iter().chain(of_b).collect();
        normals.sort_by(|m, n| n.dot(expected).total_cmp(&m.dot(expected)));
        normals.truncate(MOST_NORMALS);
        let mut least = found;
        for normal in normals {
            let height = normal.dot(&self.support(&normal).difference);
            if height <= 0.0 {
                return None;
            }
            if height < least.0 {
                least = (height, normal);
            }
        }
        Some(least)
    }

    /// The directions in which the cores separate by a translation that is longer than the shortest by at most `tolerance` (m), as many
    /// as the polytope shows; none if a direction separates them already, or if their Minkowski difference is flat.
    pub fn directions_within(&self, tolerance: f64) -> Vec<SeparatingDirection> {
        let mut directions: Vec<SeparatingDirection> = Vec::new();
        let Some(mut polytope) = self.first_tetrahedron() else { return directions };
        let mut least = f64::INFINITY;
        while let Some(face) = polytope.next_unprobed(least + tolerance) {
            let support = self.support(&face.normal);
            let height = face.normal.dot(&support.difference);
            if height <= 0.0 {
                return Vec::new();
            }
            least = least.lesser(height);
            if height <= least + tolerance {
                let core_points = [Point::origin(); 2];
                directions.push(SeparatingDirection { normal: face.normal, height, core_points });
            }
            let is_accurate = height - face.offset <= RELATIVE_ACCURACY * height + polytope.resolution;
            if !is_accurate && polytope.supports.len() < MOST_POINTS {
                polytope.expand(&face, support);
            }
        }
        directions.retain(|direction| direction.height <= least + tolerance);
        directions.sort_by(|a, b| a.height.total_cmp(&b.height));
        for direction in &mut directions {
            let gap = tolerance + 1e-6 * direction.height + polytope.resolution;
            direction.core_points = polytope.witness_points(&(direction.normal * direction.height), gap);
        }
        directions
    }

    fn result(&self, polytope: &Polytope, face: &Face, (height, direction): (f64, Vector)) -> ConvexDepth {
        let radii = if self.rounded { 0.0 } else { self.a.radius() + self.b.radius() };
        // solids with symmetries have many nearest faces: the points belong to the direction of the result
        let gap = height - face.offset + 1e-6 * height + polytope.resolution;
        let [p, q] = polytope.witness_points(&(direction * height), gap);
        let swept = if self.rounded { 0.0 } else { 1.0 };
        ConvexDepth {
            lower: (face.offset + radii - polytope.resolution).greater(0.0),
            upper: height + radii + polytope.resolution,
            direction,
            witness_points: [
                p + direction * (swept * self.a.radius()),
                q - direction * (swept * self.b.radius()),
            ],
        }
    }

    fn support(&self, n: &Vector) -> Support {
        let mut on_a = self.a.support(n).coords;
        let MatrixPose { rotation, translation } = self.pose_ab;
        let mut on_b = rotation * self.b.support(&-rotation.tr_mul(n)).coords + translation;
        if self.rounded {
            on_a += n * self.a.radius();
            on_b -= n * self.b.radius();
        }
        Support { on_a, difference: on_a - on_b }
    }

    /// A tetrahedron of support points, as large as a few directions find it; `None` if all lie in a plane.
    fn first_tetrahedron(&self) -> Option<Polytope> {
        let farthest = |along: [Vector; 2], measure: &dyn Fn(&Vector) -> f64| {
            let found = along.map(|n| self.support(&n));
            let of = found.map(|s| measure(&s.difference));
            if of[0] >= of[1] { (of[0], found[0]) } else { (of[1], found[1]) }
        };
        let axes = [Vector::x(), Vector::y(), Vector::z()];
        let extents = axes.map(|n| [self.support(&n), self.support(&-n)]);
        let [p, q] = *extents.iter().max_by(|e, f| spread(e).total_cmp(&spread(f)))?;
        let size = extents.iter().flatten().map(|s| s.difference.amax().greater(s.on_a.amax()));
        let size = size.fold(0.0, f64::greater);
        let resolution = ROUNDING * size;
        let along = (q.difference - p.difference).try_normalize(resolution)?;
        let aside = |v: &Vector| ((v - p.difference) - along * (v - p.difference).dot(&along)).norm();
        let across = along.cross(&axes[along.iamin()]).normalize();
        let (wide, r) = [[across, -across], [along.cross(&across), -along.cross(&across)]]
            .map(|n| farthest(n, &aside))
            .into_iter()
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        if wide <= 1e3 * resolution {
            return None;
        }
        let normal = along.cross(&(r.difference - p.difference)).normalize();
        let (high, s) = farthest([normal, -normal], &|v| normal.dot(&(v - p.difference)).abs());
        (high > 1e3 * resolution).then(|| Polytope::tetrahedron([p, q, r, s], resolution))
    }
}

fn spread([p, q]: &[Support; 2]) -> f64 {
    (p.difference - q.difference).norm_squared()
}

impl Polytope {
    fn tetrahedron(supports: [Support; 4], resolution: f64) -> Self {
        let mut polytope = Self { supports: supports.to_vec(), faces: Vec::new(), resolution };
        let centre = supports.iter().map(|s| s.difference).sum::<Vector>() / 4.0;
        for corners in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] {
            let mut corners = corners;
            let [a, b, c] = corners.map(|i| supports[i].difference);
            if (b - a).cross(&(c - a)).dot(&(centre - a)) > 0.0 {
                corners.swap(1, 2);
            }
            polytope.faces.extend(polytope.face(corners));
        }
        polytope
    }

    fn face(&self, corners: [usize; 3]) -> Option<Face> {
        let [a, b, c] = corners.map(|i| self.supports[i].difference);
        let normal = (b - a).cross(&(c - a)).try_normalize(self.resolution * self.resolution)?;
        let offset = [a, b, c].iter().map(|p| normal.dot(p)).fold(f64::INFINITY, f64::lesser);
        Some(Face { corners, normal, offset, is_probed: false })
    }

    fn nearest_face(&self) -> &Face {
        let nearest = self.faces.iter().min_by(|a, b| a.offset.total_cmp(&b.offset));
        nearest.expect("a polytope has faces")
    }

    /// Marks the nearest face that is not probed yet as probed, if it is not farther from the origin than `limit` (m).
    fn next_unprobed(&mut self, limit: f64) -> Option<Face> {
        let open = self.faces.iter_mut().filter(|face| !face.is_probed && face.offset <= limit);
        let face = open.min_by(|a, b| a.offset.total_cmp(&b.offset))?;
        face.is_probed = true;
        Some(*face)
    }

    /// Adds a support point above `nearest`: the faces around it that the point lies above, or in whose plane it lies, are replaced by the
    /// cone over their outline. False, and unchanged, if rounding makes the outline or the cone degenerate.
    fn expand(&mut self, nearest: &Face, support: Support) -> bool {
        let is_below = |face: &&Face| {
            face.normal.dot(&support.difference) > face.offset - self.resolution
                || face.corners == nearest.corners
        };
        let hidden = connected(self.faces.iter().filter(is_below).copied().collect(), nearest);
        let Some(outline) = outline(&hidden) else { return false };
        self.supports.push(support);
        let top = self.supports.len() - 1;
        let cone: Option<Vec<Face>> = outline.iter().map(|&(a, b)| self.face([a, b, top])).collect();
        let Some(cone) = cone else {
            self.supports.pop();
            return false;
        };
        self.faces.retain(|face| !hidden.iter().any(|hidden| hidden.corners == face.corners));
        self.faces.extend(cone);
        debug_assert!(self.faces.len() <= 2 * self.supports.len(), "Euler's formula of a closed surface");
        true
    }

    /// The point of the polytope's surface nearest to a point, which is near the surface, as points of both solids.
    fn witness_points(&self, target: &Vector, tolerance: f64) -> [Point; 2] {
        let target = Point::from(*target);
        let (mut best, mut found) = (f64::INFINITY, [Point::origin(); 2]);
        for face in self.faces.iter().filter(|face| face.height(&target).abs() <= tolerance) {
            let supports = face.corners.map(|i| self.supports[i]);
            let [a, b, c] = supports.map(|s| Point::from(s.difference));
            let point = Triangle { a, b, c }.nearest_point(&target);
            let distance = nalgebra::distance(&point, &target);
            if distance < best {
                best = distance;
                let weights = face.weights(&[a, b, c], &point);
                let on_a: Vector = supports.iter().zip(weights).map(|(s, w)| s.on_a * w).sum();
                found = [Point::from(on_a), Point::from(on_a) - point.coords];
            }
        }
        found
    }
}

/// The faces that are connected to one of them across edges.
fn connected(mut faces: Vec<Face>, start: &Face) -> Vec<Face> {
    let mut found: Vec<Face> = Vec::with_capacity(faces.len());
    let mut next = faces.iter().position(|face| face.corners == start.corners);
    while let Some(index) = next {
        found.push(faces.swap_remove(index));
        next = faces.iter().position(|face| {
            found.iter().any(|other| face.edges().iter().any(|(a, b)| other.edges().contains(&(*b, *a))))
        });
    }
    found
}

/// The edges around connected faces, if they form one closed line that passes no point twice.
fn outline(faces: &[Face]) -> Option<Vec<(usize, usize)>> {
    let edges: Vec<(usize, usize)> = faces.iter().flat_map(Face::edges).collect();
    let outer: Vec<(usize, usize)> =
        edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))).copied().collect();
    let next = |(_, end): (usize, usize)| {
        let mut leaving = outer.iter().filter(|(start, _)| *start == end);
        leaving.next().copied().filter(|_| leaving.next().is_none())
    };
    let first = *outer.first()?;
    let (mut edge, mut length) = (next(first)?, 1);
    while edge != first {
        (edge, length) = (next(edge)?, length + 1);
        if length > outer.len() {
            return None;
        }
    }
    (length == outer.len() && length >= 3).then_some(outer)
}

impl Face {
    fn edges(&self) -> [(usize, usize); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }

    /// Signed distance (m) of a point from the plane of the face.
    fn height(&self, point: &Point) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }

    /// Weights of the corners at a point of the face.
    fn weights(&self, corners: &[Point; 3], point: &Point) -> [f64; 3] {
        let [a, b, c] = corners.map(|corner| corner - point);
        let areas = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|area| self.normal.dot(&area).greater(0.0));
        let total: f64 = areas.iter().sum();
        areas.map(|area| area / total)
    }
}
