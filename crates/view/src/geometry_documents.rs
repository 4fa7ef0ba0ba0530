//! Geometry documents: links, obstacles and attached objects with the shapes that are checked.

use clearance_geometry::math::{Extremes, Pose};
use clearance_geometry::{PointCloud, Primitive, Shape, TriangleMesh, Voxels};
use clearance_monitor::Revision;
use clearance_robot::LinkPoses;
use clearance_scene::ObstacleShape;
use clearance_scene::Settings;
use hyper::body::Bytes;
use serde::Serialize;

use crate::document::{Numbers, Span};
use crate::reach::sampled_reach;

/// Largest number of triangles in one document. Meshes beyond it are shown as their bounding boxes.
const TRIANGLES_SHOWN: usize = 1_000_000;
/// Largest number of balls shown for one cloud, sampled evenly.
const POINTS_SHOWN: usize = 50_000;
/// Largest number of cubes shown for one octree, sampled evenly.
const CUBES_SHOWN: usize = 50_000;

#[derive(Serialize)]
struct Robot<'a> {
    model: u64,
    name: &'a str,
    frame: &'a str,
    links: Vec<DrawnBody<'a>>,
    /// By link: its pose in the default configuration, which is shown while no joint state is known.
    default_poses: Vec<[f32; 7]>,
    /// Lower and upper corner (root frame) of a box around the reach of the robot.
    reach: Option<[[f32; 3]; 2]>,
}

#[derive(Serialize)]
struct Surroundings<'a> {
    model: u64,
    world: u64,
    obstacles: Vec<DrawnBody<'a>>,
    attached: Vec<DrawnBody<'a>>,
    /// By link: scale factor of its shapes.
    link_scales: Vec<f32>,
    /// The largest padding (m) that is subtracted from the distance of a pair. Padding is not drawn.
    largest_padding: f32,
}

#[derive(Serialize)]
struct DrawnBody<'a> {
    name: &'a str,
    /// The link that carries the object; `None`: its poses are in the root frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    link: Option<&'a str>,
    shapes: Vec<DrawnShape>,
}

#[derive(Serialize)]
struct DrawnShape {
    /// Position (m) and quaternion (x, y, z, w) in the frame of the link, or in the root frame.
    pose: [f32; 7],
    #[serde(flatten)]
    form: Form,
    /// Whether only a part of the shape is shown, or only its bounding box.
    coarse: bool,
}

/// Shape to draw. Lengths in metres. Ranges of numbers: three for a vertex, a triangle or a point, four for a cube
/// (centre, half edge).
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Form {
    Box { size: [f32; 3] },
    Sphere { radius: f32 },
    Cylinder { radius: f32, length: f32 },
    Cone { radius: f32, length: f32 },
    Capsule { radius: f32, length: f32 },
    Plane { normal: [f32; 3], offset: f32 },
    Mesh { vertices: Span, triangles: Span },
    Points { radius: f32, centres: Span },
    Cubes { cubes: Span },
}

/// Document with the links of a robot, each in its own frame.
pub fn robot(revision: &Revision) -> Bytes {
    let robot = revision.checker.robot();
    let mut sketch = Sketch::default();
    let links = robot.links().iter().map(|link| DrawnBody {
        name: &link.name,
        link: None,
        shapes: link.collisions.iter().map(|c| sketch.shape(&c.pose_ls, &c.shape)).collect(),
    });
    let links = links.collect();
    let mut poses = LinkPoses::new(robot);
    robot.forward_kinematics(&robot.default_configuration(), &mut poses);
    sketch.numbers.document(&Robot {
        model: revision.model,
        name: robot.name(),
        frame: revision.frame(),
        links,
        default_poses: robot.link_ids().map(|link| pose_numbers(poses.pose(link))).collect(),
        reach: sampled_reach(robot).map(|corners| corners.map(|corner| corner.map(short).into())),
    })
}

/// The largest padding (m) that a distance between two bodies may contain.
fn largest_padding(settings: &Settings) -> f64 {
    let of_links = settings.link_padding.values().copied().fold(settings.padding, f64::greater);
    let of_links = if settings.pad_self { 2.0 * of_links } else { of_links };
    of_links + settings.object_padding.values().copied().fold(0.0, f64::greater)
}

/// Document with the obstacles and the attached objects.
pub fn world(revision: &Revision) -> Bytes {
    let checker = &revision.checker;
    let (world, settings) = (checker.world(), checker.settings());
    let mut sketch = Sketch::default();
    let obstacles = world.obstacles().map(|obstacle| DrawnBody {
        name: &obstacle.name,
        link: None,
        shapes: sketch.shapes(&obstacle.pose_ro, &obstacle.shapes, settings.object_scale.get(&obstacle.name)),
    });
    let obstacles = obstacles.collect();
    let attached = world.attached().iter().map(|object| DrawnBody {
        name: &object.name,
        link: Some(&object.link),
        shapes: sketch.shapes(&object.pose_lo, &object.shapes, settings.object_scale.get(&object.name)),
    });
    let attached = attached.collect();
    let scale = |name: &String| settings.link_scale.get(name).map_or(1.0, |&scale| short(scale));
    sketch.numbers.document(&Surroundings {
        model: revision.model,
        world: revision.world,
        obstacles,
        attached,
        largest_padding: short(largest_padding(settings)),
        link_scales: checker.robot().links().iter().map(|link| scale(&link.name)).collect(),
    })
}

/// Builder of a document.
#[derive(Default)]
struct Sketch {
    numbers: Numbers,
    triangles: usize,
}

impl Sketch {
    /// The shapes of an object at a pose, each scaled by a factor.
    fn shapes(&mut self, pose: &Pose, shapes: &[ObstacleShape], scale: Option<&f64>) -> Vec<DrawnShape> {
        let scaled = |shape: &Shape| scale.and_then(|&factor| shape.scaled(factor).ok());
        let draw = |placed: &ObstacleShape| {
            let larger = scaled(&placed.shape);
            self.shape(&(pose * placed.pose_os), larger.as_ref().unwrap_or(&placed.shape))
        };
        shapes.iter().map(draw).collect()
    }

    fn shape(&mut self, pose: &Pose, shape: &Shape) -> DrawnShape {
        let whole = |form| DrawnShape { pose: pose_numbers(pose), form, coarse: false };
        match shape {
            Shape::Primitive(primitive) => whole(primitive_form(primitive)),
            Shape::Mesh(mesh) => self.mesh(pose, mesh),
            Shape::Plane(plane) => whole(Form::Plane {
                normal: [plane.normal.x, plane.normal.y, plane.normal.z].map(short),
                offset: short(plane.offset),
            }),
            Shape::Points(cloud) => {
                DrawnShape { coarse: cloud.points().len() > POINTS_SHOWN, ..whole(self.points(cloud)) }
            }
            Shape::Voxels(voxels) => {
                DrawnShape { coarse: voxels.cubes().len() > CUBES_SHOWN, ..whole(self.cubes(voxels)) }
            }
        }
    }

    fn mesh(&mut self, pose: &Pose, mesh: &TriangleMesh) -> DrawnShape {
        self.triangles += mesh.triangles().len();
        if self.triangles > TRIANGLES_SHOWN {
            self.triangles -= mesh.triangles().len();
            let (low, high) = mesh.bounds();
            let middle = nalgebra::center(&low, &high);
            let pose = pose * Pose::from_parts(middle.coords.into(), nalgebra::one());
            let form = Form::Box { size: (high - low).map(short).into() };
            return DrawnShape { pose: pose_numbers(&pose), form, coarse: true };
        }
        let vertices = mesh.vertices().iter().flat_map(|p| [p.x, p.y, p.z]).map(short);
        let form = Form::Mesh {
            vertices: self.numbers.floats(vertices),
            triangles: self.numbers.integers(mesh.triangles().iter().flatten().copied()),
        };
        DrawnShape { pose: pose_numbers(pose), form, coarse: false }
    }

    fn points(&mut self, cloud: &PointCloud) -> Form {
        let step = cloud.points().len().div_ceil(POINTS_SHOWN).max(1);
        let centres = cloud.points().iter().step_by(step).flatten().copied();
        Form::Points { radius: short(cloud.radius()), centres: self.numbers.floats(centres) }
    }

    fn cubes(&mut self, voxels: &Voxels) -> Form {
        let step = voxels.cubes().len().div_ceil(CUBES_SHOWN).max(1);
        let shown = voxels.cubes().iter().step_by(step);
        let cubes = shown.flat_map(|cube| cube.centre.into_iter().chain([cube.half_edge]));
        Form::Cubes { cubes: self.numbers.floats(cubes) }
    }
}

fn primitive_form(primitive: &Primitive) -> Form {
    let twice = |half: f64| short(2.0 * half);
    match *primitive {
        Primitive::Box { half_extents } => Form::Box { size: half_extents.map(twice) },
        Primitive::Sphere { radius } => Form::Sphere { radius: short(radius) },
        Primitive::Cylinder { radius, half_length } => {
            Form::Cylinder { radius: short(radius), length: twice(half_length) }
        }
        Primitive::Cone { radius, half_length } => {
            Form::Cone { radius: short(radius), length: twice(half_length) }
        }
        Primitive::Capsule { radius, half_length } => {
            Form::Capsule { radius: short(radius), length: twice(half_length) }
        }
    }
}

/// Position, and quaternion in the order x, y, z, w.
pub fn pose_numbers(pose: &Pose) -> [f32; 7] {
    let (p, q) = (pose.translation.vector, pose.rotation.quaternion());
    [p.x, p.y, p.z, q.i, q.j, q.k, q.w].map(short)
}

#[expect(clippy::cast_possible_truncation, reason = "a picture needs no more digits")]
pub fn short(number: f64) -> f32 {
    number as f32
}
