//! Hashes of the robot and the world that a certificate belongs to.

use std::collections::HashMap;

use clearance_geometry::math::{Pose, UnitVector};
use clearance_geometry::{Cube, Plane, Primitive, Shape};
use clearance_robot::{Joint, JointKind, RobotModel};
use clearance_scene::{AllowedCollisionMatrix, BodyId, MeshModel, PairList, Settings, World};

use super::Fingerprint;

/// Format of the hashed data of a model. If this data changes, increase the number: earlier certificates get invalid.
const MODEL_FORMAT: &str = "clearance model 1";

/// Format of the hashed data of a world; see [`MODEL_FORMAT`].
const WORLD_FORMAT: &str = "clearance world 1";

/// Model hash: SHA-256 of everything that determines how the robot moves, its geometry, and the pairs that are checked:
/// links, shapes, joints except their limits, paddings, mesh treatment, pairs of links. File names and the order of the
/// URDF's attributes do not matter.
#[must_use]
pub fn model_fingerprint(
    robot: &RobotModel,
    settings: &Settings,
    matrix: Option<&AllowedCollisionMatrix>,
) -> String {
    let mut print = Fingerprint::default();
    print.text(MODEL_FORMAT).text(robot.name()).count(robot.links().len());
    for link in robot.links() {
        let padding = settings.link_padding.get(&link.name).copied().unwrap_or(settings.padding);
        let scale = settings.link_scale.get(&link.name).copied().unwrap_or(1.0);
        print.text(&link.name).numbers(&[padding, scale]).count(link.collisions.len());
        for collision in &link.collisions {
            add_shape(&mut print, &collision.pose_ls, &collision.shape);
        }
    }
    print.count(robot.joints().len());
    for joint in robot.joints() {
        add_joint(&mut print, joint);
    }
    let solid = settings.mesh_model == MeshModel::Solid;
    let choices = [settings.pad_self, settings.check_self, settings.check_world, solid];
    print.indices(&choices.map(u32::from));
    let pairs = PairList::new(robot, &World::default(), matrix);
    let pairs = pairs.restricted(settings.check_self, settings.check_world);
    print.count(pairs.len());
    for (a, b) in pairs.self_pairs() {
        for body in [a, b] {
            if let BodyId::Link(link) = body {
                print.indices(&[link.0]);
            }
        }
    }
    add_objects(&mut print, "padding", &settings.object_padding);
    add_objects(&mut print, "scale", &settings.object_scale);
    print.finish()
}

/// Values of individual objects, by name.
fn add_objects(print: &mut Fingerprint, what: &str, numbers: &HashMap<String, f64>) {
    let mut sorted: Vec<_> = numbers.iter().collect();
    sorted.sort_by_key(|(name, _)| *name);
    print.text(what).count(sorted.len());
    for (name, number) in sorted {
        print.text(name).numbers(&[*number]);
    }
}

/// World hash: SHA-256 of the obstacles and attached objects: names, shapes, poses, and touch links.
#[must_use]
pub fn world_fingerprint(world: &World) -> String {
    let mut print = Fingerprint::default();
    print.text(WORLD_FORMAT).count(world.len());
    for obstacle in world.obstacles() {
        print.text(&obstacle.name).count(obstacle.shapes.len());
        for (pose_rs, shape) in obstacle.placed_shapes() {
            add_shape(&mut print, &pose_rs, shape);
        }
    }
    print.count(world.attached().len());
    for object in world.attached() {
        print.text(&object.name).text(&object.link).count(object.touch_links.len());
        for link in &object.touch_links {
            print.text(link);
        }
        print.count(object.shapes.len());
        for placed in object.shapes.iter() {
            add_shape(&mut print, &(object.pose_lo * placed.pose_os), &placed.shape);
        }
    }
    print.finish()
}

fn add_joint(print: &mut Fingerprint, joint: &Joint) {
    print.text(&joint.name).indices(&[joint.parent.0, joint.child.0]).pose(&joint.pose_pj);
    add_kind(print, joint);
    match joint.mimic {
        Some(m) => print.count(1).indices(&[m.joint.0]).numbers(&[m.multiplier, m.offset]),
        None => print.count(0),
    };
}

/// How a joint moves.
pub(super) fn add_kind(print: &mut Fingerprint, joint: &Joint) {
    let axis = |axis: &UnitVector| vec![axis.x, axis.y, axis.z];
    let (kind, axis) = match &joint.kind {
        JointKind::Fixed => ("fixed", vec![]),
        // except for limits these are the same
        JointKind::Revolute(a) | JointKind::Continuous(a) => ("turning", axis(a)),
        JointKind::Prismatic(a) => ("prismatic", axis(a)),
        JointKind::Floating => ("floating", vec![]),
        JointKind::Planar(a) => ("planar", axis(a)),
    };
    print.text(kind).numbers(&axis);
}

pub(super) fn add_shape(print: &mut Fingerprint, pose: &Pose, shape: &Shape) {
    print.pose(pose).text(shape.kind());
    match shape {
        Shape::Primitive(Primitive::Box { half_extents }) => print.numbers(half_extents),
        Shape::Primitive(Primitive::Sphere { radius }) => print.numbers(&[*radius]),
        Shape::Primitive(
            Primitive::Cylinder { radius, half_length }
            | Primitive::Cone { radius, half_length }
            | Primitive::Capsule { radius, half_length },
        ) => print.numbers(&[*radius, *half_length]),
        Shape::Mesh(mesh) => {
            print.count(mesh.vertices().len());
            for p in mesh.vertices() {
                print.numbers(&[p.x, p.y, p.z]);
            }
            print.count(mesh.triangles().len());
            for t in mesh.triangles() {
                print.indices(t);
            }
            print
        }
        Shape::Plane(plane) => {
            let Plane { normal, offset } = plane;
            print.numbers(&[normal.x, normal.y, normal.z, *offset])
        }
        Shape::Points(cloud) => {
            print.numbers(&[cloud.radius()]).count(cloud.points().len());
            for p in cloud.points() {
                print.numbers(&p.map(f64::from));
            }
            print
        }
        Shape::Voxels(voxels) => {
            print.count(voxels.cubes().len());
            for Cube { centre: [x, y, z], half_edge } in voxels.cubes() {
                print.numbers(&[*x, *y, *z, *half_edge].map(f64::from));
            }
            print
        }
    };
}
