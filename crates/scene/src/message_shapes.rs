//! Conversion of shapes and poses from the numbers of `shape_msgs` and `geometry_msgs`.

use std::sync::Arc;

use clearance_geometry::math::{Point, Pose, pose_from_xyz_quaternion};
use clearance_geometry::{Plane, Primitive, Shape, TriangleMesh};

use super::ObstacleShape;

/// The constants of `shape_msgs/SolidPrimitive`, with the meaning of their dimensions.
const SOLIDS: [(u8, &str, &str); 4] = [
    (1, "box", "three (x, y, z)"),
    (2, "sphere", "one (radius)"),
    (3, "cylinder", "two (height, radius)"),
    (4, "cone", "two (height, radius)"),
];

/// The constant of `shape_msgs/SolidPrimitive` for a shape's name, case-insensitive.
#[must_use]
pub fn solid_type(name: &str) -> Option<u8> {
    SOLIDS.iter().find(|(_, known, _)| name.eq_ignore_ascii_case(known)).map(|(number, ..)| *number)
}

/// A `shape_msgs/SolidPrimitive`: `BOX` 1, `SPHERE` 2, `CYLINDER` 3, `CONE` 4.
pub fn solid(number: u8, dimensions: &[f64]) -> Result<Shape, String> {
    let Some((_, name, wanted)) = SOLIDS.iter().find(|(known, ..)| number == *known) else {
        return Err(format!("type '{number}' is not supported: {}", supported_solids()));
    };
    let made = match (number, dimensions) {
        (1, &[x, y, z]) => Primitive::cuboid([x, y, z]),
        (2, &[radius]) => Primitive::sphere(radius),
        (3, &[height, radius]) => Primitive::cylinder(radius, height),
        (4, &[height, radius]) => Primitive::cone(radius, height),
        (_, given) => {
            return Err(format!("dimensions: {name} takes {wanted}, but {} numbers are given", given.len()));
        }
    };
    made.map(Shape::Primitive).map_err(|e| format!("dimensions: {e}"))
}

/// For use in other error messages.
pub(super) fn supported_solids() -> &'static str {
    "box, sphere, cylinder and cone are"
}

/// A `shape_msgs/Plane`: ax + by + cz + d = 0.
pub fn plane(coefficients: [f64; 4]) -> Result<Shape, String> {
    Plane::from_coefficients(coefficients).map(Shape::Plane).map_err(|e| format!("coef: {e}"))
}

/// A `shape_msgs/Mesh`.
pub fn mesh(vertices: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Shape, String> {
    let vertices = vertices.into_iter().map(Point::from).collect();
    TriangleMesh::new(vertices, triangles).map(|m| Shape::Mesh(Arc::new(m))).map_err(|e| e.to_string())
}

/// A `geometry_msgs/Pose`. A quaternion of zeros is the identity, as in messages that leave it out.
pub fn message_pose(position: [f64; 3], orientation_xyzw: [f64; 4]) -> Result<Pose, String> {
    let orientation = match orientation_xyzw {
        [0.0, 0.0, 0.0, 0.0] => [0.0, 0.0, 0.0, 1.0],
        given => given,
    };
    pose_from_xyz_quaternion(position, orientation).ok_or_else(|| {
        "position and orientation must be finite, the position near and the quaternion not zero".to_owned()
    })
}

/// Shapes with their poses in the object; shapes beyond the last pose get the object's own pose. `field` is the name of the field of
/// poses.
///
/// # Errors
/// If there are more poses than shapes.
pub fn placed_shapes(
    shapes: Vec<Shape>,
    poses: &[Pose],
    field: &str,
    remarks: &mut Vec<String>,
) -> Result<Vec<ObstacleShape>, String> {
    if poses.len() > shapes.len() {
        return Err(format!("{field}: {} poses for {} shapes", poses.len(), shapes.len()));
    }
    if !poses.is_empty() && poses.len() < shapes.len() {
        remarks.push(format!(
            "{field}: {} poses for {} shapes: the others have the object's own",
            poses.len(),
            shapes.len()
        ));
    }
    let poses = poses.iter().copied().chain(std::iter::repeat(Pose::identity()));
    Ok(shapes.into_iter().zip(poses).map(|(shape, pose_os)| ObstacleShape { pose_os, shape }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cones_and_cylinders_take_their_height_first() {
        for (name, made) in
            [("cone", Primitive::cone(0.25, 2.0)), ("Cylinder", Primitive::cylinder(0.25, 2.0))]
        {
            let Shape::Primitive(solid) = solid(solid_type(name).unwrap(), &[2.0, 0.25]).unwrap() else {
                panic!("{name} is no primitive");
            };
            assert_eq!(solid, made.unwrap());
        }
    }

    #[test]
    fn faults_name_the_field() {
        for (fault, word) in [
            (solid(5, &[1.0]).unwrap_err(), "'5'"),
            (solid(1, &[1.0]).unwrap_err(), "box takes three"),
            (solid(2, &[-1.0]).unwrap_err(), "radius"),
            (plane([0.0, 0.0, 0.0, 1.0]).unwrap_err(), "coef"),
            (mesh(vec![], vec![]).unwrap_err(), "no triangles"),
            (message_pose([f64::NAN; 3], [0.0; 4]).unwrap_err(), "finite"),
            (
                placed_shapes(vec![], &[Pose::identity()], "mesh_poses", &mut vec![]).unwrap_err(),
                "mesh_poses",
            ),
        ] {
            assert!(fault.contains(word), "{fault}");
        }
    }
}
