//! Test helper: body under test, in two representations: the engine's and the oracle's.

use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Shape, Triangle, TriangleMesh};
use clearance::proximity::CollisionBody;

use super::solid_oracle::Solid;

#[derive(Debug)]
pub struct Subject {
    pub body: CollisionBody,
    pub solid: Solid,
    pub shapes: Vec<(Pose, Shape)>,
}

impl Subject {
    pub fn new(shapes: Vec<(Pose, Shape)>) -> Self {
        let posed = || shapes.iter().map(|(pose, shape)| (pose, shape));
        let body = CollisionBody::new(posed()).expect("a subject has shapes");
        Self { body, solid: Solid::new(posed()), shapes }
    }

    pub fn of(shape: Shape) -> Self {
        Self::new(vec![(Pose::identity(), shape)])
    }

    pub fn mesh(mesh: TriangleMesh) -> Self {
        Self::of(Shape::Mesh(mesh.into()))
    }

    /// One triangle, degenerate or not.
    pub fn triangle(corners: [Point; 3]) -> Self {
        Self::mesh(TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]).expect("finite corners"))
    }

    /// Whether it has no primitives.
    pub fn is_mesh(&self) -> bool {
        self.shapes.iter().all(|(_, shape)| matches!(shape, Shape::Mesh(_)))
    }

    /// The same body in a frame that is moved by `pose`.
    pub fn moved(&self, pose: &Pose) -> CollisionBody {
        let shapes: Vec<_> = self.shapes.iter().map(|(p, shape)| (pose * p, shape)).collect();
        CollisionBody::new(shapes.iter().map(|(p, shape)| (p, *shape))).expect("a subject has shapes")
    }

    /// The corners or the formula, for a report that reproduces a disagreement.
    pub fn description(&self) -> String {
        let describe = |(pose, shape): &(Pose, Shape)| match shape {
            Shape::Primitive(p) => format!("{p:?} at {}", pose_text(pose)),
            Shape::Mesh(mesh) if mesh.triangles().len() == 1 => {
                let Triangle { a, b, c } = mesh.triangle(0);
                format!("triangle {:?} {:?} {:?}", a.coords.data.0, b.coords.data.0, c.coords.data.0)
            }
            Shape::Mesh(mesh) => format!("mesh of {} triangles", mesh.triangles().len()),
            other => format!("{other:?} at {}", pose_text(pose)),
        };
        self.shapes.iter().map(describe).take(4).collect::<Vec<_>>().join(", ")
    }
}

pub fn pose_text(pose: &Pose) -> String {
    let (t, q) = (&pose.translation.vector, &pose.rotation.coords);
    format!("({:?}, {:?}, {:?}) turned ({:?}, {:?}, {:?}, {:?})", t.x, t.y, t.z, q.x, q.y, q.z, q.w)
}
