//! A solid or a surface that can collide.

use std::sync::Arc;

use super::{Primitive, TriangleMesh};

/// What a link or an obstacle is made of, in its own frame. Primitives are solid; a mesh is a surface.
#[derive(Clone, Debug)]
pub enum Shape {
    Primitive(Primitive),
    Mesh(Arc<TriangleMesh>),
}

impl Shape {
    /// The field's word for the kind of shape.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Primitive(Primitive::Box { .. }) => "box",
            Self::Primitive(Primitive::Sphere { .. }) => "sphere",
            Self::Primitive(Primitive::Cylinder { .. }) => "cylinder",
            Self::Primitive(Primitive::Capsule { .. }) => "capsule",
            Self::Mesh(_) => "mesh",
        }
    }
}
