//! The boxes of a body's hierarchies at one level, for visualisation only.

use clearance_geometry::math::{Pose, Rotation, RotationMatrix, Vector};

use super::CollisionBody;
use crate::bounding_volume::{Axes, Obb};
use crate::bvh::Tree;

/// A box of a hierarchy, in the frame of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyVolume {
    pub pose_bv: Pose,
    pub half_extents: Vector,
}

impl CollisionBody {
    /// The boxes at a given depth below the roots of the hierarchies, and the boxes of leaves nearer to the root: together they contain
    /// the body except its planes.
    #[must_use]
    #[inline]
    pub fn volumes(&self, level: usize) -> Vec<BodyVolume> {
        let surface = self.surface.iter().flat_map(|surface| of_tree(&surface.tree, level));
        let solids = self.solids.iter().flat_map(|tree| of_tree(tree, level));
        let grains = self.grains.iter().flat_map(|grains| {
            let pose_bg = Pose::from(&grains.pose_bg);
            of_tree(&grains.tree, level).into_iter().map(move |volume| BodyVolume {
                pose_bv: pose_bg * volume.pose_bv,
                half_extents: volume.half_extents.add_scalar(grains.radius),
            })
        });
        surface.chain(solids).chain(grains).collect()
    }
}

fn of_tree<L>(tree: &Tree<Obb, L>, level: usize) -> Vec<BodyVolume> {
    let placed = |(volume, axes): (&Obb, &Axes)| {
        let turn = RotationMatrix::from_fn(|i, k| f64::from(axes.0[k][i]));
        let centre = tree.anchor() + turn * Vector::from(volume.centre.map(f64::from));
        BodyVolume {
            pose_bv: Pose::from_parts(centre.coords.into(), Rotation::from_matrix(&turn)),
            half_extents: Vector::from(volume.half_extents.map(f64::from)),
        }
    };
    tree.at_level(level).into_iter().map(|node| placed(tree.volume(node))).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use clearance_geometry::math::Point;
    use clearance_geometry::testing::Random;
    use clearance_geometry::{PointCloud, Primitive, Shape, TriangleMesh};

    fn is_held(point: &Point, volumes: &[BodyVolume]) -> bool {
        volumes.iter().any(|volume| {
            let own = volume.pose_bv.inverse_transform_point(point).coords.abs();
            (own - volume.half_extents).max() <= 1e-5
        })
    }

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "a cloud's points are short")]
    fn every_level_holds_the_body_and_its_largest_box_is_no_larger_than_that_above() {
        let mut random = Random::new(3);
        let vertices: Vec<Point> = (0..600).map(|_| random.vector(0.5).into()).collect();
        let triangles = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Shape::Mesh(Arc::new(TriangleMesh::new(vertices.clone(), triangles).unwrap()));
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.3 });
        let cloud: Vec<[f32; 3]> = vertices.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect();
        let cloud = Shape::Points(Arc::new(PointCloud::new(cloud, 0.05).unwrap()));
        let [here, there] = [random.pose(2.0), random.pose(2.0)];
        let body = CollisionBody::new([(&here, &mesh), (&there, &ball), (&there, &cloud)]).unwrap();
        let mut before = f64::INFINITY;
        for level in 0..5 {
            let volumes = body.volumes(level);
            assert!(level > 0 || volumes.len() == 3);
            for vertex in &vertices {
                assert!(is_held(&(here * vertex), &volumes), "level {level}");
                let outermost = Point::from(vertex.coords + random.direction().scale(0.0499));
                assert!(is_held(&(there * outermost), &volumes), "level {level}");
            }
            assert!(is_held(&(there * Point::new(0.2999, 0.0, 0.0)), &volumes));
            let size = volumes.iter().map(|v| v.half_extents.product()).fold(0.0, f64::max);
            assert!(size <= before);
            before = size;
        }
        assert_eq!(body.volumes(20), body.volumes(30));
    }
}
