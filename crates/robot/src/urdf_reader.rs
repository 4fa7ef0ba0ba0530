//! Builds the robot model from the output of `urdf-rs`: joints, tree, shapes.

use std::collections::HashMap;

use clearance_geometry::math::{Pose, Rotation, UnitVector, Vector, pose_from_xyz_rpy};
use clearance_geometry::{Primitive, PrimitiveError, Shape};

use super::decimal_numbers::shortened;
use super::joint::{Joint, JointKind, Limits, Mimic};
use super::kinematic_tree::{Tree, TreeError};
use super::loaded_mesh::MeshCache;
use super::mesh_file_error::MeshFileError;
use super::mesh_files::MeshFiles;
use super::missing_meshes::MissingMeshes;
use super::model::{Collision, Link, MeshSource, RobotModel};
use super::model_error::ModelError;
use super::urdf_validation::{CollisionNotes, JointNotes, LinkNotes, ValidUrdf};
use super::{Fault, JointId, LinkId, Place, Warning, mimic_resolution, pair_limit};

/// Builds a robot from the output of `urdf-rs` for the validated text.
///
/// # Errors
/// Joints that form no tree or mimic no existing joint; shapes and meshes that cannot be loaded, all of them at once.
pub(super) fn build(
    robot: &urdf_rs::Robot,
    mut sound: ValidUrdf,
    files: &MeshFiles,
) -> Result<RobotModel, ModelError> {
    if (robot.links.len(), robot.joints.len()) != (sound.links.len(), sound.joints.len()) {
        return Err(ModelError::from(Fault {
            place: Place::default(),
            message: "the URDF has links or joints that urdf-rs does not see".to_owned(),
        }));
    }
    let mut joints = joints(robot, &sound)?;
    let remarks = mimic_resolution::resolve(&mut joints)
        .map_err(|e| Fault { place: place(&sound, e.joint), message: e.message })?;
    let remarks = remarks.into_iter().map(|r| Warning { place: place(&sound, r.joint), message: r.message });
    sound.warnings.extend(remarks.collect::<Vec<_>>());
    check_position_names(&joints, &sound)?;
    let tree = Tree::new(robot.links.len(), &joints).map_err(|e| tree_fault(e, &sound, &joints))?;
    let ValidUrdf { links: notes, joints: joint_notes, mut warnings, .. } = sound;
    let links = links(robot, &notes, &tree, files, &mut warnings)?;
    pair_limit::check(&links)?;
    let (first_position, position_names) = positions(&joints);
    let mut model = RobotModel {
        name: robot.name.clone(),
        links,
        joints,
        root: tree.root,
        topological_order: tree.topological_order,
        first_position,
        position_names,
        srdf: None,
        link_prefix: String::new(),
        warnings,
    };
    for (joint, message) in model.contradictory_limits() {
        let place = joint_notes.get(joint.index()).map(|notes| notes.place.clone()).unwrap_or_default();
        model.warnings.push(Warning { place, message });
    }
    Ok(model)
}

fn place(sound: &ValidUrdf, joint: JointId) -> Place {
    let notes = sound.joints.get(joint.index());
    notes.map(|n| n.place.clone()).unwrap_or_default()
}

/// The position names of a joint with several positions contain its own name: no other joint may have such a name.
fn check_position_names(joints: &[Joint], sound: &ValidUrdf) -> Result<(), ModelError> {
    let by_name: HashMap<&str, usize> =
        joints.iter().enumerate().map(|(i, j)| (j.name.as_str(), i)).collect();
    let mut faults = Vec::new();
    for joint in joints {
        for suffix in joint.kind.position_suffixes().iter().filter(|suffix| !suffix.is_empty()) {
            let name = format!("{}{suffix}", joint.name);
            if let Some(notes) = by_name.get(name.as_str()).and_then(|other| sound.joints.get(*other)) {
                let owner = shortened(&joint.name);
                let message = format!(
                    "a position of joint '{owner}' has the same name, so that states could not distinguish them: rename one of the joints"
                );
                faults.push(Fault { place: notes.place.clone(), message });
            }
        }
    }
    ModelError::unless_sound((), faults)
}

/// Index of each joint's first position, and the names of the positions.
fn positions(joints: &[Joint]) -> (Vec<Option<usize>>, Vec<String>) {
    let mut names = Vec::new();
    let first = (joints.iter())
        .map(|joint| {
            let suffixes = joint.kind.position_suffixes();
            let free = joint.mimic.is_none() && !suffixes.is_empty();
            let first = names.len();
            if free {
                names.extend(suffixes.iter().map(|s| format!("{}{s}", joint.name)));
            }
            free.then_some(first)
        })
        .collect();
    (first, names)
}

fn joints(robot: &urdf_rs::Robot, sound: &ValidUrdf) -> Result<Vec<Joint>, ModelError> {
    let link_ids: HashMap<&str, LinkId> =
        (robot.links.iter().zip(0..)).map(|(l, i)| (l.name.as_str(), LinkId(i))).collect();
    let joint_ids: HashMap<&str, JointId> =
        (robot.joints.iter().zip(0..)).map(|(j, i)| (j.name.as_str(), JointId(i))).collect();
    let mut joints = Vec::with_capacity(robot.joints.len());
    let mut faults = Vec::new();
    for (joint, notes) in robot.joints.iter().zip(&sound.joints) {
        match read_joint(joint, notes, &link_ids, &joint_ids) {
            Ok(joint) => joints.push(joint),
            Err(message) => faults.push(Fault { place: notes.place.clone(), message }),
        }
    }
    ModelError::unless_sound(joints, faults)
}

fn read_joint(
    joint: &urdf_rs::Joint,
    notes: &JointNotes,
    link_ids: &HashMap<&str, LinkId>,
    joint_ids: &HashMap<&str, JointId>,
) -> Result<Joint, String> {
    let link = |name: &str| {
        let id = link_ids.get(name.trim()).copied();
        id.ok_or_else(|| format!("link '{name}' does not exist"))
    };
    let mimic = match &joint.mimic {
        None => None,
        Some(mimic) => {
            let leader = joint_ids.get(mimic.joint.trim()).copied();
            Some(Mimic {
                joint: leader
                    .ok_or_else(|| format!("mimics joint '{}', which does not exist", mimic.joint))?,
                multiplier: mimic.multiplier.unwrap_or(1.0),
                offset: mimic.offset.unwrap_or(0.0),
            })
        }
    };
    Ok(Joint {
        name: joint.name.clone(),
        kind: kind(joint)?,
        parent: link(&joint.parent.link)?,
        child: link(&joint.child.link)?,
        pose_pj: pose(&joint.origin, notes.rotation),
        limits: notes.limited.then_some(Limits {
            lower: joint.limit.lower,
            upper: joint.limit.upper,
            velocity: joint.limit.velocity,
            acceleration: joint.limit.acceleration,
        }),
        mimic,
        passive: false,
    })
}

fn kind(joint: &urdf_rs::Joint) -> Result<JointKind, String> {
    use urdf_rs::JointType;
    let axis = || {
        let axis = UnitVector::try_new(Vector::from(*joint.axis.xyz), 1e-9);
        axis.ok_or_else(|| "the axis has no length".to_owned())
    };
    Ok(match joint.joint_type {
        JointType::Fixed => JointKind::Fixed,
        JointType::Revolute => JointKind::Revolute(axis()?),
        JointType::Continuous => JointKind::Continuous(axis()?),
        JointType::Prismatic => JointKind::Prismatic(axis()?),
        JointType::Floating => JointKind::Floating,
        JointType::Planar => JointKind::Planar(axis()?),
        JointType::Spherical => return Err("spherical joints are not read".to_owned()),
    })
}

fn pose(origin: &urdf_rs::Pose, rotation: Option<Rotation>) -> Pose {
    let mut pose = pose_from_xyz_rpy(*origin.xyz, *origin.rpy);
    if let Some(rotation) = rotation {
        pose.rotation = rotation;
    }
    pose
}

fn links(
    robot: &urdf_rs::Robot,
    notes: &[LinkNotes],
    tree: &Tree,
    files: &MeshFiles,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Link>, ModelError> {
    let LinkGeometries { links: geometries, faults, .. } = geometries(robot, notes, files, warnings);
    let bodies = tree.parent_joint.iter().zip(&tree.rigid_body);
    let links = (robot.links.iter().zip(geometries).zip(bodies)).map(
        |((link, collisions), (&parent_joint, &rigid_body))| Link {
            name: link.name.clone(),
            parent_joint,
            collisions,
            rigid_body,
        },
    );
    ModelError::unless_sound(links.collect(), faults)
}

/// The geometry of each link, as far as it can be loaded.
pub(super) struct LinkGeometries {
    pub links: Vec<Vec<Collision>>,
    /// The places of these elements in their link, from 1.
    pub numbers: Vec<Vec<usize>>,
    /// The errors of the rest.
    pub faults: Vec<Fault>,
}

/// Reads the geometry of each link.
pub(super) fn geometries(
    robot: &urdf_rs::Robot,
    notes: &[LinkNotes],
    files: &MeshFiles,
    warnings: &mut Vec<Warning>,
) -> LinkGeometries {
    let mut meshes = MeshCache::new(files);
    let (mut faults, mut missing) = (Vec::new(), MissingMeshes::default());
    let (mut links, mut numbers) = (Vec::with_capacity(robot.links.len()), Vec::new());
    for (link, notes) in robot.links.iter().zip(notes) {
        let (mut collisions, mut loaded) = (Vec::with_capacity(link.collision.len()), Vec::new());
        for ((collision, notes), number) in link.collision.iter().zip(&notes.collisions).zip(1..) {
            match read_collision(collision, notes, &mut meshes, warnings) {
                Ok(collision) => {
                    collisions.push(collision);
                    loaded.push(number);
                }
                Err(ShapeError::Mesh(error)) if missing.record(collision, &error, &notes.place) => {}
                Err(error) => faults.push(Fault { place: notes.place.clone(), message: error.to_string() }),
            }
        }
        links.push(collisions);
        numbers.push(loaded);
    }
    faults.extend(missing.faults(files));
    LinkGeometries { links, numbers, faults }
}

/// Reason why a collision has no shape.
#[derive(Debug, thiserror::Error)]
enum ShapeError {
    #[error(transparent)]
    Primitive(#[from] PrimitiveError),
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
}

fn read_collision(
    collision: &urdf_rs::Collision,
    notes: &CollisionNotes,
    meshes: &mut MeshCache,
    warnings: &mut Vec<Warning>,
) -> Result<Collision, ShapeError> {
    let primitive = |p: Result<Primitive, PrimitiveError>| p.map(Shape::Primitive).map_err(ShapeError::from);
    let shape = match &collision.geometry {
        urdf_rs::Geometry::Box { size } => primitive(Primitive::cuboid(**size)),
        urdf_rs::Geometry::Sphere { radius } => primitive(Primitive::sphere(*radius)),
        urdf_rs::Geometry::Cylinder { radius, length } => primitive(Primitive::cylinder(*radius, *length)),
        urdf_rs::Geometry::Capsule { radius, length } => primitive(Primitive::capsule(*radius, *length)),
        urdf_rs::Geometry::Mesh { filename, scale } => {
            let loaded = meshes.load(filename, mesh_scale(*scale))?;
            warnings.extend(
                loaded.remarks.into_iter().map(|message| Warning { place: notes.place.clone(), message }),
            );
            Ok(Shape::Mesh(loaded.mesh))
        }
    }?;
    Ok(Collision {
        name: collision.name.clone(),
        pose_ls: pose(&collision.origin, notes.rotation),
        shape,
        mesh_source: mesh_source(&collision.geometry),
    })
}

fn mesh_source(geometry: &urdf_rs::Geometry) -> Option<MeshSource> {
    match geometry {
        urdf_rs::Geometry::Mesh { filename, scale } => {
            Some(MeshSource { uri: filename.clone(), scale: mesh_scale(*scale) })
        }
        _ => None,
    }
}

fn mesh_scale(scale: Option<urdf_rs::Vec3>) -> Vector {
    scale.map_or(Vector::from_element(1.0), |s| Vector::from(*s))
}

fn tree_fault(error: TreeError, sound: &ValidUrdf, joints: &[Joint]) -> Fault {
    let link_place = |id: LinkId| {
        let notes = sound.links.get(id.index());
        notes.map(|n| n.place.clone()).unwrap_or_default()
    };
    let listed = |ids: &[LinkId]| {
        let names: Vec<String> =
            (ids.iter().take(20)).map(|&id| link_place(id).element.unwrap_or_default()).collect();
        let more = if ids.len() > 20 { " …" } else { "" };
        names.join(", ") + more
    };
    let joint_name = |id: JointId| joints.get(id.index()).map_or("", |j| j.name.as_str());
    let (place, message) = match error {
        TreeError::NoLinks => (Place::default(), "the robot has no <link>".to_owned()),
        TreeError::TwoParents(child, first, second) => (
            link_place(child),
            format!(
                "has two parents: it is the child of joint '{}' and of joint '{}'",
                joint_name(first),
                joint_name(second)
            ),
        ),
        TreeError::SeveralRoots(roots) => (
            roots.get(1).map(|&r| link_place(r)).unwrap_or_default(),
            format!("{} links have no parent, but only one may: {}", roots.len(), listed(&roots)),
        ),
        TreeError::Cycle(links) => (
            links.first().map(|&l| link_place(l)).unwrap_or_default(),
            format!("these links hang on each other in a circle: {}", listed(&links)),
        ),
    };
    Fault { place, message }
}
