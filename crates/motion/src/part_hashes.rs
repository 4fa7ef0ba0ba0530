//! Computes the parts of a certificate: hashes of the links, joints, obstacles and attached objects.

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::{JointId, RobotModel};
use clearance_scene::{MeshModel, Settings, World};

use super::model_fingerprint::{add_kind, add_shape};
use super::{BodyPart, CertificateParts, Fingerprint, JointPart};

/// Number of digits of a part's hash: it only identifies differences; the hash of the whole decides.
const DIGITS: usize = 16;

/// The parts of a robot and a world, in their checked form.
#[must_use]
pub fn certificate_parts(robot: &RobotModel, world: &World, settings: &Settings) -> CertificateParts {
    let links = robot.links().iter().map(|link| {
        let padding = settings.link_padding.get(&link.name).copied().unwrap_or(settings.padding);
        let scale = settings.link_scale.get(&link.name).copied().unwrap_or(1.0);
        let shapes = link.collisions.iter().map(|c| (c.pose_ls, &c.shape));
        BodyPart(link.name.clone(), hash_of_shapes(&[], shapes), padding, scale)
    });
    let object = |name: &str, hash: String| {
        let padding = settings.object_padding.get(name).copied().unwrap_or(0.0);
        BodyPart(name.to_owned(), hash, padding, settings.object_scale.get(name).copied().unwrap_or(1.0))
    };
    let obstacles = world
        .obstacles()
        .map(|obstacle| object(&obstacle.name, hash_of_shapes(&[], obstacle.placed_shapes())));
    let attached = world.attached().iter().map(|held| {
        let carriers: Vec<&str> =
            std::iter::once(held.link.as_str()).chain(held.touch_links.iter().map(String::as_str)).collect();
        let shapes = held.shapes.iter().map(|placed| (held.pose_lo * placed.pose_os, &placed.shape));
        object(&held.name, hash_of_shapes(&carriers, shapes))
    });
    CertificateParts {
        links: links.collect(),
        joints: robot.joint_ids().map(|id| joint(robot, id)).collect(),
        obstacles: obstacles.collect(),
        attached_objects: attached.collect(),
        meshes: mesh_model_name(settings.mesh_model).to_owned(),
        pad_self: settings.pad_self,
        check_self: settings.check_self,
        check_world: settings.check_world,
    }
}

/// `surface` or `solid`.
#[must_use]
pub fn mesh_model_name(model: MeshModel) -> &'static str {
    match model {
        MeshModel::Surface => "surface",
        MeshModel::Solid => "solid",
    }
}

fn hash_of_shapes<'s>(carriers: &[&str], shapes: impl Iterator<Item = (Pose, &'s Shape)>) -> String {
    let mut print = Fingerprint::default();
    for name in carriers {
        print.text(name);
    }
    for (pose, shape) in shapes {
        add_shape(&mut print, &pose, shape);
    }
    short(print)
}

/// By names, so that an additional link does not change the hashes of later joints.
fn joint(robot: &RobotModel, id: JointId) -> JointPart {
    let joint = robot.joint(id);
    let mut print = Fingerprint::default();
    print.text(&robot.link(joint.parent).name).text(&robot.link(joint.child).name).pose(&joint.pose_pj);
    add_kind(&mut print, joint);
    if let Some(mimic) = joint.mimic {
        print.text(&robot.joint(mimic.joint).name).numbers(&[mimic.multiplier, mimic.offset]);
    }
    JointPart(joint.name.clone(), short(print))
}

fn short(print: Fingerprint) -> String {
    let mut hash = print.finish();
    hash.truncate(DIGITS);
    hash
}
