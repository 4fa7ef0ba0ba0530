//! Sample vertices spread over a surface, and the search for the one deepest in the box around a convex solid. Testing
//! whether one of them is in a convex solid is cheap, and often one is where the two touch.

use clearance_geometry::math::{Extremes, Point};
use clearance_geometry::simd::{LANES, Simd, Vectors};

use super::solid_leaf::SolidLeaf;
use crate::bounding_volume::{Axes, Relative};

/// Maximum number of samples.
const MOST: usize = 64;

/// Sample vertices of a surface.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceSamples {
    /// Groups of eight, relative to the anchor of the surface's tree; unused lanes repeat the last vertex.
    eights: Vec<[[f32; LANES]; 3]>,
    /// Vertex indices.
    vertices: Vec<u32>,
}

impl SurfaceSamples {
    /// SurfaceSamples of the vertices that belong to faces.
    #[inline]
    pub fn new(anchor: &Point, vertices: &[Point], faces: &[[u32; 3]]) -> Self {
        let spread = spread(vertices, &corners_of(vertices.len(), faces));
        let points: Vec<Point> = spread.iter().map(|vertex| vertices[*vertex as usize]).collect();
        Self { eights: in_eights(anchor, &points), vertices: spread }
    }

    /// Memory in bytes.
    #[inline]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.eights[..]) + size_of_val(&self.vertices[..])
    }

    /// The sample deepest in the box around a solid, up to rounding, if one is in it; `relative` places the solid's tree in the
    /// surface's.
    #[inline(always)]
    pub fn innermost<S: Simd>(&self, simd: S, solid: &SolidLeaf, relative: &Relative) -> Option<u32> {
        // the vertices in the frame of the solid
        let own = relative.of_nodes(&solid.axes, &Axes::IDENTITY);
        let centre = Vectors::splat(simd, &relative.point(&solid.centre));
        let half_extents = Vectors::splat(simd, &solid.hull.half_extents_around());
        let mut outside = [[f32::INFINITY; LANES]; MOST / LANES];
        for (eight, outside) in self.eights.iter().zip(&mut outside) {
            let p = Vectors::load(simd, eight).minus(centre).turned_back(&own.r);
            *outside = p.abs().minus(half_extents).largest().into();
        }
        let known = self.vertices.iter().zip(outside.as_flattened());
        let (vertex, least) = known.reduce(|best, next| if next.1 < best.1 { next } else { best })?;
        (*least <= 0.0).then_some(*vertex)
    }
}

/// The indices of the vertices that belong to faces, each once.
fn corners_of(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<u32> {
    let mut is_corner = vec![false; vertex_count];
    for &corner in faces.as_flattened() {
        is_corner[corner as usize] = true;
    }
    (0..).zip(is_corner).filter_map(|(vertex, is_corner)| is_corner.then_some(vertex)).collect()
}

/// Farthest-point sampling: each vertex is the farthest from those before it (Gonzalez 1985, *Clustering to minimize the maximum
/// intercluster distance*).
fn spread(vertices: &[Point], corners: &[u32]) -> Vec<u32> {
    let mut gaps = vec![f64::INFINITY; corners.len()];
    let mut chosen = Vec::with_capacity(MOST.min(corners.len()));
    while chosen.len() < MOST {
        let widest = gaps.iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((next, _)) = widest.filter(|(_, gap)| **gap > 0.0) else { break };
        chosen.push(corners[next]);
        let p = vertices[corners[next] as usize];
        for (gap, &corner) in gaps.iter_mut().zip(corners) {
            *gap = gap.lesser((vertices[corner as usize] - p).norm_squared());
        }
    }
    chosen
}

#[allow(clippy::cast_possible_truncation)] // rounding is meant
fn in_eights(anchor: &Point, points: &[Point]) -> Vec<[[f32; LANES]; 3]> {
    let number =
        |eight: &[Point], i: usize, lane: usize| (eight[lane.min(eight.len() - 1)][i] - anchor[i]) as f32;
    let eights = points.chunks(LANES);
    eights.map(|eight| std::array::from_fn(|i| std::array::from_fn(|lane| number(eight, i, lane)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::solid_leaf::Solid;
    use crate::body::surface::Surface;
    use crate::bounding_volume::Obb;
    use crate::bvh::Tree;
    use clearance_geometry::Primitive;
    use clearance_geometry::math::{MatrixPose, Pose, Vector};
    use clearance_geometry::simd::dispatch;
    use clearance_geometry::testing::{Random, levels};

    /// Points on a ball of 1 m, and some more at one place; the last of these belongs to no face.
    fn ball(random: &mut Random, count: u32) -> (Vec<Point>, Vec<[u32; 3]>) {
        let mut vertices: Vec<Point> =
            (0..3 * count).map(|_| Point::from(random.direction().into_inner())).collect();
        vertices.extend([Point::from([0.0, 0.0, 1.0]); 50]);
        let corners = 3 * count + 49;
        let faces = (0..corners).map(|i| [i, (i + 1) % corners, (i + 2) % corners]).collect();
        vertices[corners as usize] = Point::from([9.0; 3]);
        (vertices, faces)
    }

    #[test]
    fn samples_are_spread_corners_each_once() {
        let mut random = Random::new(11);
        let (vertices, faces) = ball(&mut random, 1000);
        let samples = SurfaceSamples::new(&Point::origin(), &vertices, &faces);
        assert_eq!(samples.vertices.len(), MOST);
        let at = |vertex: &u32| vertices[*vertex as usize];
        for (k, one) in samples.vertices.iter().enumerate() {
            assert!(at(one).coords.norm() < 2.0);
            assert!(samples.vertices[..k].iter().all(|other| nalgebra::distance(&at(one), &at(other)) > 0.2));
        }
        for _ in 0..200 {
            let p = Point::from(random.direction().into_inner());
            assert!(samples.vertices.iter().any(|sample| nalgebra::distance(&at(sample), &p) < 0.5));
        }
        let few = SurfaceSamples::new(&Point::origin(), &vertices, &[[0, 1, 1]]);
        assert_eq!((few.vertices.len(), few.eights.len()), (2, 1));
    }

    #[test]
    fn the_innermost_is_in_the_box_around_a_solid_and_none_is_passed_over() {
        let mut random = Random::new(12);
        let (vertices, faces) = ball(&mut random, 20);
        let surface = Surface::new(vertices.clone(), &faces).unwrap();
        let samples = surface.samples();
        let (mut inside, mut outside) = (0, 0);
        for _ in 0..500 {
            let half_extents = [(); 3].map(|()| 0.02 + random.within(0.4).abs());
            let pose = random.pose(0.5);
            let solid = Solid { primitive: Primitive::Box { half_extents }, pose };
            let solids: Tree<Obb, SolidLeaf> = Tree::build(&[solid]).0;
            let pose_ab = Pose::from_parts((random.direction().into_inner() * 1.2).into(), random.rotation());
            let relative = solids.relative(surface.tree(), &MatrixPose::from(&pose_ab).inverse());
            let depth = |vertex: &u32| {
                let own = (pose_ab * pose).inverse_transform_point(&vertices[*vertex as usize]);
                (own.coords.abs() - Vector::from(half_extents)).max()
            };
            let least = samples.vertices.iter().map(depth).fold(f64::INFINITY, f64::min);
            for level in levels() {
                let content = &solids.leaves()[0].content;
                let found = dispatch!(level, simd => samples.innermost(simd, content, &relative));
                match found {
                    Some(vertex) => assert!((depth(&vertex) - least).abs() < 1e-5),
                    None => assert!(least > -1e-5),
                }
                *(if found.is_some() { &mut inside } else { &mut outside }) += 1;
            }
        }
        assert!(inside > 100 && outside > 100, "{inside} {outside}");
    }
}
