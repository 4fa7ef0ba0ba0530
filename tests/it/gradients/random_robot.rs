//! Test helper: random robots with all joint types, primitives, meshes and an attached object, in a random world.

use std::fmt::Write as _;
use std::sync::{Arc, LazyLock};

use clearance::checker::CollisionChecker;
use clearance::geometry::math::Pose;
use clearance::geometry::{Shape, TriangleMesh};
use clearance::robot::{Configuration, JointKind, MeshFiles, RobotModel};
use clearance::scene::{AttachedObject, MeshModel, Obstacle, ObstacleShape, Settings, World};

use crate::random::Random;

/// A box and a bumpy solid as STL files.
static MESHES: LazyLock<[(&'static str, &'static [u8]); 2]> = LazyLock::new(|| {
    let mut random = Random::new(17);
    let cuboid = random_box_mesh([0.5; 3]);
    let bumpy = random.blob(5, 0.5);
    [("p/box.stl", stl(&cuboid)), ("p/bumpy.stl", stl(&bumpy))]
});

/// The surface of a box.
pub fn random_box_mesh(half: [f64; 3]) -> TriangleMesh {
    let corner = |i: usize| std::array::from_fn(|k| if i >> k & 1 == 0 { -half[k] } else { half[k] }).into();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), faces).unwrap()
}

fn stl(mesh: &TriangleMesh) -> &'static [u8] {
    let mut text = "solid s\n".to_owned();
    for corners in mesh.triangles() {
        text += "facet normal 0 0 0\nouter loop\n";
        for p in corners.map(|i| mesh.vertices()[i as usize]) {
            writeln!(text, "vertex {} {} {}", p.x, p.y, p.z).unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    Box::leak((text + "endsolid\n").into_bytes().into_boxed_slice())
}

fn numbers(random: &mut Random, size: f64) -> String {
    let [x, y, z] = [(); 3].map(|()| random.within(-size, size));
    format!("{x} {y} {z}")
}

/// Kinds of shapes of a random robot and its world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shapes {
    All,
    /// Primitives and meshes: their depths are exact.
    Boxes,
}

fn geometry(random: &mut Random, shapes: Shapes) -> String {
    let mut size = || random.within(0.05, 0.2);
    let (x, y, z) = (size(), size(), size());
    let kind = if shapes == Shapes::Boxes { 3 * random.below(2) } else { random.below(6) };
    match kind {
        0 => format!("<box size='{x} {y} {z}'/>"),
        1 => format!("<sphere radius='{x}'/>"),
        2 => format!("<cylinder radius='{x}' length='{y}'/>"),
        3 | 4 => format!("<mesh filename='package://p/box.stl' scale='{x} {y} {z}'/>"),
        _ => format!("<mesh filename='package://p/bumpy.stl' scale='{x} {y} {z}'/>"),
    }
}

/// The joint between a link and its parent; some follow the revolute joint of the first link.
fn joint(random: &mut Random, child: u32) -> String {
    let parent = if random.below(4) == 0 { random.below(child) } else { child - 1 };
    let kind = if child == 1 { 0 } else { random.below(8) };
    let (kind, more) = match kind {
        0 => ("revolute", "<limit lower='-3' upper='3' effort='1' velocity='1'/>".to_owned()),
        1 => ("prismatic", "<limit lower='-0.5' upper='0.5' effort='1' velocity='1'/>".to_owned()),
        2 => ("planar", String::new()),
        3 => ("floating", String::new()),
        4 => ("fixed", String::new()),
        5 | 6 => {
            let (kind, factor) =
                (["revolute", "prismatic"][random.below(2) as usize], random.within(-1.5, 1.5));
            let limit = "<limit lower='-9' upper='9' effort='1' velocity='1'/>";
            (kind, format!("{limit}<mimic joint='j1' multiplier='{factor}' offset='0.2'/>"))
        }
        _ => ("continuous", String::new()),
    };
    let axis = if matches!(kind, "fixed" | "floating") {
        String::new()
    } else {
        let v = random.vector(1.0).normalize();
        format!("<axis xyz='{} {} {}'/>", v.x, v.y, v.z)
    };
    format!(
        "<joint name='j{child}' type='{kind}'><parent link='l{parent}'/><child link='l{child}'/>
         <origin xyz='{}' rpy='{}'/>{axis}{more}</joint>",
        numbers(random, 0.5),
        numbers(random, 3.0)
    )
}

fn robot(random: &mut Random, shapes: Shapes) -> RobotModel {
    let links = 3 + random.below(6);
    let mut urdf = "<robot name='random'>".to_owned();
    for link in 0..links {
        let (xyz, rpy) = (numbers(random, 0.1), numbers(random, 3.0));
        let origin = format!("<origin xyz='{xyz}' rpy='{rpy}'/>");
        let geometry = geometry(random, shapes);
        write!(
            urdf,
            "<link name='l{link}'><collision>{origin}<geometry>{geometry}</geometry></collision></link>"
        )
        .unwrap();
    }
    for child in 1..links {
        urdf += &joint(random, child);
    }
    RobotModel::from_urdf(&(urdf + "</robot>"), &MeshFiles::embedded(&*MESHES))
        .unwrap_or_else(|e| panic!("{e}"))
}

fn shape(random: &mut Random, shapes: Shapes) -> Shape {
    let kind = if shapes == Shapes::Boxes { 0 } else { random.below(3) };
    match kind {
        0 => Shape::Mesh(random_box_mesh([(); 3].map(|()| random.within(0.05, 0.2))).into()),
        1 => Shape::Mesh(random.blob(5, 0.2).into()),
        _ => Shape::Primitive(random.primitive()),
    }
}

fn world(random: &mut Random, robot: &RobotModel, shapes: Shapes) -> World {
    let mut world = World::default();
    for i in 0..3 {
        world.add(Obstacle::of_shape(format!("o{i}"), random.pose(1.0), shape(random, shapes))).unwrap();
    }
    let links = u32::try_from(robot.links().len()).unwrap();
    let object = AttachedObject {
        name: "held".to_owned(),
        link: format!("l{}", random.below(links)),
        pose_lo: random.pose(0.3),
        shapes: vec![ObstacleShape { pose_os: random.pose(0.05), shape: shape(random, shapes) }].into(),
        subframes: Vec::new(),
        touch_links: Vec::new(),
    };
    world.attach(object).unwrap();
    world
}

/// A random robot in a random world, with paddings and scales.
pub fn checker(random: &mut Random, shapes: Shapes) -> CollisionChecker {
    checker_with(random, shapes, MeshModel::Surface)
}

pub fn checker_with(random: &mut Random, shapes: Shapes, mesh_model: MeshModel) -> CollisionChecker {
    let robot = robot(random, shapes);
    let world = world(random, &robot, shapes);
    let mut settings = Settings { mesh_model, ..Settings::default() };
    if random.below(2) == 0 {
        settings.padding = random.within(0.0, 0.05);
        settings.pad_self = random.below(2) == 0;
        settings.link_scale.insert("l1".to_owned(), random.within(0.7, 1.3));
        settings.object_scale.insert("held".to_owned(), random.within(0.7, 1.3));
        settings.object_padding.insert("o1".to_owned(), 0.01);
    }
    CollisionChecker::new(Arc::new(robot), &world, settings).unwrap()
}

/// A random configuration, also of planar and floating joints.
pub fn configuration(robot: &RobotModel, random: &mut Random) -> Configuration {
    let mut positions = robot.default_configuration().positions().to_vec();
    for joint in robot.joint_ids() {
        let Some(first) = robot.first_position(joint) else { continue };
        match (&robot.joint(joint).kind, robot.joint(joint).limits) {
            (JointKind::Floating, _) => {
                let Pose { translation, rotation } = random.pose(0.5);
                positions[first..first + 3].copy_from_slice(translation.vector.as_slice());
                positions[first + 3..first + 7].copy_from_slice(rotation.coords.as_slice());
            }
            (JointKind::Planar(_), _) => {
                (0..3).for_each(|k| positions[first + k] = random.within(-0.5, 0.5));
            }
            (_, Some(limits)) => positions[first] = random.within(limits.lower, limits.upper),
            _ => positions[first] = random.within(-3.0, 3.0),
        }
    }
    robot.configuration(&positions).unwrap()
}
