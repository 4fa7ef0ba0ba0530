//! Immutable robot model: links, joints, and the order in which poses are computed.

use clearance_geometry::Shape;
use clearance_geometry::math::{Pose, Vector};

use super::joint::{Joint, Mimic};
use super::srdf::Srdf;
use super::{JointId, LinkId, Warning};

/// A robot as URDF (and SRDF) describe it. Immutable once built; share it behind an `Arc`.
#[derive(Clone, Debug)]
pub struct RobotModel {
    pub(super) name: String,
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
    pub(super) root: LinkId,
    /// Joints in topological order: the pose of a parent link is computed before the poses of its children.
    pub(super) topological_order: Vec<JointId>,
    /// First position of each joint in a configuration, by joint; `None` for fixed and mimicking joints.
    pub(super) first_position: Vec<Option<usize>>,
    pub(super) position_names: Vec<String>,
    pub(super) srdf: Option<Srdf>,
    /// Prefix of link names, which is not part of their names in URDF and SRDF.
    pub(super) link_prefix: String,
    pub(super) warnings: Vec<Warning>,
}

/// A rigid part of the robot.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name in the URDF, with the link prefix.
    pub name: String,
    /// The joint that moves the link; `None` for the root.
    pub parent_joint: Option<JointId>,
    /// Collision geometry; may be empty.
    pub collisions: Vec<Collision>,
    /// The topmost link that this link is connected to by fixed joints; identifies the rigid body.
    pub rigid_body: LinkId,
}

/// One collision geometry of a link.
#[derive(Clone, Debug)]
pub struct Collision {
    /// Name in the URDF, if it has one.
    pub name: Option<String>,
    /// Pose of the shape in the link frame.
    pub pose_ls: Pose,
    /// The geometry, in its own frame.
    pub shape: Shape,
    /// Source of a mesh.
    pub mesh_source: Option<MeshSource>,
}

/// The name of a mesh in the URDF, and its scale factors.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSource {
    /// The mesh name, such as `package://NAME/path`.
    pub uri: String,
    /// Scale factors along x, y and z.
    pub scale: Vector,
}

impl RobotModel {
    /// Name of the robot in the URDF.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All links, in the URDF's order.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// All joints, in the URDF's order.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// A link by its id.
    #[must_use]
    pub fn link(&self, id: LinkId) -> &Link {
        &self.links[id.index()]
    }

    /// A joint by its id.
    #[must_use]
    pub fn joint(&self, id: JointId) -> &Joint {
        &self.joints[id.index()]
    }

    /// The name of a link in URDF and SRDF, without a prefix that was added later.
    #[must_use]
    pub fn described_name(&self, id: LinkId) -> &str {
        let name = &self.link(id).name;
        name.strip_prefix(&self.link_prefix).unwrap_or(name)
    }

    /// The link that no joint has as its child; all poses are in its frame.
    #[must_use]
    pub fn root(&self) -> LinkId {
        self.root
    }

    /// The link with this name, prefix included.
    #[must_use]
    pub fn link_by_name(&self, name: &str) -> Option<LinkId> {
        (self.links.iter().zip(0..)).find_map(|(l, i)| (l.name == name).then_some(LinkId(i)))
    }

    /// The joint with this name.
    #[must_use]
    pub fn joint_by_name(&self, name: &str) -> Option<JointId> {
        (self.joints.iter().zip(0..)).find_map(|(j, i)| (j.name == name).then_some(JointId(i)))
    }

    /// The ids of all links, ascending.
    pub fn link_ids(&self) -> impl Iterator<Item = LinkId> + use<> {
        (0..u32::try_from(self.links.len()).unwrap_or(u32::MAX)).map(LinkId)
    }

    /// The ids of all joints, ascending.
    pub fn joint_ids(&self) -> impl Iterator<Item = JointId> + use<> {
        (0..u32::try_from(self.joints.len()).unwrap_or(u32::MAX)).map(JointId)
    }

    /// Joints in topological order: the pose of a parent link is computed before the poses of its children.
    #[must_use]
    pub fn topological_order(&self) -> &[JointId] {
        &self.topological_order
    }

    /// Names of the positions of a configuration, in order, for all joints that are neither fixed nor mimic joints.
    #[must_use]
    pub fn position_names(&self) -> &[String] {
        &self.position_names
    }

    /// Number of degrees of freedom; mimic joints do not count, a floating joint counts six.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        (self.joints.iter()).filter(|j| j.mimic.is_none()).map(|j| j.kind.degrees_of_freedom()).sum()
    }

    /// Index of a joint's first position in a configuration; `None` for fixed and mimic joints.
    #[must_use]
    pub fn first_position(&self, joint: JointId) -> Option<usize> {
        self.first_position[joint.index()]
    }

    /// Names of mimic joints; their values in a joint state are not needed.
    pub fn mimicking_joints(&self) -> impl Iterator<Item = (&Joint, Mimic)> {
        self.joints.iter().filter_map(|j| Some((j, j.mimic?)))
    }

    /// The SRDF, if the robot was read with one.
    #[must_use]
    pub fn srdf(&self) -> Option<&Srdf> {
        self.srdf.as_ref()
    }

    /// Warnings about unusual content that was accepted while loading.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// True if two links are joined by fixed joints only, and so never move relative to each other.
    #[must_use]
    pub fn same_rigid_body(&self, a: LinkId, b: LinkId) -> bool {
        self.link(a).rigid_body == self.link(b).rigid_body
    }

    /// True if the rigid bodies of two links are joined by one moving joint.
    #[must_use]
    pub fn adjacent_rigid_bodies(&self, a: LinkId, b: LinkId) -> bool {
        let is_parent = |parent: LinkId, child: LinkId| {
            let top = self.link(self.link(child).rigid_body);
            top.parent_joint
                .is_some_and(|j| self.link(self.joint(j).parent).rigid_body == self.link(parent).rigid_body)
        };
        is_parent(a, b) || is_parent(b, a)
    }
}
