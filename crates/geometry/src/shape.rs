//! Shape type: primitive, mesh, plane, point cloud or voxels, with its kind and scaling.

use std::sync::Arc;

use super::{MeshError, Plane, PointCloud, Primitive, PrimitiveError, TriangleMesh, Voxels};

/// A shape of a link or an obstacle, in its own frame. Primitives, the balls of a cloud and voxels are solid; a mesh and a plane are
/// surfaces.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Solid primitive.
    Primitive(Primitive),
    /// Surface of triangles.
    Mesh(Arc<TriangleMesh>),
    /// Infinite surface.
    Plane(Plane),
    /// Solid balls around points.
    Points(Arc<PointCloud>),
    /// Solid cubes.
    Voxels(Arc<Voxels>),
}

/// Reason why a shape cannot be scaled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// The factor is not a finite number above zero.
    #[error("the scale is {0}, but must be a finite number above zero")]
    BadFactor(f64),
    /// A dimension of the scaled primitive is invalid.
    #[error(transparent)]
    Primitive(#[from] PrimitiveError),
    /// A vertex of the scaled mesh is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl Shape {
    /// The usual name of the kind of shape.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Primitive(Primitive::Box { .. }) => "box",
            Self::Primitive(Primitive::Sphere { .. }) => "sphere",
            Self::Primitive(Primitive::Cylinder { .. }) => "cylinder",
            Self::Primitive(Primitive::Cone { .. }) => "cone",
            Self::Primitive(Primitive::Capsule { .. }) => "capsule",
            Self::Mesh(_) => "mesh",
            Self::Plane(_) => "plane",
            Self::Points(_) => "points",
            Self::Voxels(_) => "voxels",
        }
    }

    /// The shape scaled by a factor, as `MoveIt` scales links: a primitive about its centre, a mesh about the mean of its vertices.
    /// Planes, clouds and voxels, which are not manufactured parts, are unchanged.
    pub fn scaled(&self, factor: f64) -> Result<Self, ScaleError> {
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(ScaleError::BadFactor(factor));
        }
        Ok(match self {
            Self::Primitive(primitive) => Self::Primitive(primitive.scaled(factor)?),
            Self::Mesh(mesh) => Self::Mesh(Arc::new(mesh.scaled_about_mean(factor)?)),
            Self::Plane(_) | Self::Points(_) | Self::Voxels(_) => self.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Point;

    #[test]
    fn solids_grow_about_their_centre_and_meshes_about_their_mean() {
        let cone = Shape::Primitive(Primitive::cone(0.5, 2.0).unwrap()).scaled(3.0).unwrap();
        assert!(matches!(cone, Shape::Primitive(p) if p == Primitive::cone(1.5, 6.0).unwrap()));
        let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]].map(Point::from);
        let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let Shape::Mesh(grown) = Shape::Mesh(Arc::new(mesh)).scaled(2.0).unwrap() else { panic!("a mesh") };
        let wanted = [[-1.0, -1.0, 0.0], [5.0, -1.0, 0.0], [-1.0, 5.0, 0.0]].map(Point::from);
        assert_eq!(grown.vertices(), wanted);
    }

    #[test]
    fn a_scale_is_a_positive_number() {
        let ball = Shape::Primitive(Primitive::sphere(1.0).unwrap());
        for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(ball.scaled(factor), Err(ScaleError::BadFactor(_))), "{factor}");
        }
        assert!(matches!(ball.scaled(1e300), Err(ScaleError::Primitive(_))));
    }
}
