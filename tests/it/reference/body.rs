//! Test oracle: a body of the reference engine, with its OBB tree and RSS tree.

use clearance::geometry::Shape;
use clearance::geometry::math::Pose;
use clearance::proximity::Element;

use super::obb::Obb;
use super::rss::Rss;
use super::tree::Tree;

/// One body in its own frame: triangles and primitives, an OBB tree for booleans and an RSS tree for distances.
pub struct ReferenceBody {
    pub(super) elements: Vec<Element>,
    pub(super) obb: Tree<Obb>,
    pub(super) rss: Tree<Rss>,
}

impl ReferenceBody {
    /// A body of shapes, each at its pose in the body's frame. Meshes are surfaces.
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Self {
        let mut elements = Vec::new();
        for (pose, shape) in shapes {
            match shape {
                Shape::Primitive(primitive) => {
                    elements.push(Element::Primitive { primitive: *primitive, pose: *pose });
                }
                Shape::Mesh(mesh) => elements.extend(
                    (0..mesh.triangles().len())
                        .map(|i| Element::Triangle(mesh.triangle(i).transformed(pose))),
                ),
                other => panic!("the reference knows no {}", other.kind()),
            }
        }
        Self { obb: Tree::build(&elements), rss: Tree::build(&elements), elements }
    }
}
