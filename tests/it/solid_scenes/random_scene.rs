//! Test helper: random robots and worlds of closed and open meshes.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::robot::RobotModel;
use clearance::scene::{AttachedObject, Obstacle, World};

use crate::random::Random;

/// Joints of the robot: it has a link more.
pub const JOINTS: usize = 5;

/// A closed surface over a grid of angles.
fn grid(around: u32, across: u32, at: impl Fn(f64, f64) -> [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let angle = |i: u32, count: u32| f64::from(i) / f64::from(count) * std::f64::consts::TAU;
    let corner = |i: u32, j: u32| at(angle(i, around), angle(j, across));
    let cells = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let faces = cells.flat_map(|(i, j)| {
        let (k, l) = ((i + 1) % around, (j + 1) % across);
        let [a, b, c, d] = [corner(i, j), corner(k, j), corner(k, l), corner(i, l)];
        [[a, b, c], [a, c, d]]
    });
    faces.collect()
}

fn ring(radius: f64, thickness: f64) -> Vec<[[f64; 3]; 3]> {
    grid(16, 8, |u, v| {
        let out = radius + thickness * v.cos();
        [out * u.cos(), out * u.sin(), thickness * v.sin()]
    })
}

fn cuboid(half: [f64; 3], centre: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let corner = |i: usize| [0, 1, 2].map(|k| centre[k] + if i >> k & 1 == 0 { -half[k] } else { half[k] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    faces.map(|face: [usize; 3]| face.map(corner)).collect()
}

/// Faces of one of several kinds of mesh, about `size` (m) large.
fn mesh(random: &mut Random, size: f64) -> Vec<[[f64; 3]; 3]> {
    let half = [0, 1, 2].map(|_| random.within(0.4, 1.0) * size);
    match random.below(7) {
        0 => ring(0.7 * size, random.within(0.1, 0.3) * size),
        1 => cuboid(half, [0.0; 3]),
        // a hollow box
        2 => {
            let cavity = cuboid(half.map(|h| 0.8 * h), [0.0; 3]);
            [cuboid(half, [0.0; 3]), cavity.into_iter().map(|[a, b, c]| [a, c, b]).collect()].concat()
        }
        // an open box
        3 => cuboid(half, [0.0; 3])[2..].to_vec(),
        // several parts, one within another
        4 => [
            cuboid(half.map(|h| 0.3 * h), [0.6 * size, 0.0, 0.0]),
            cuboid(half.map(|h| 0.3 * h), [-0.6 * size, 0.0, 0.0]),
            cuboid(half.map(|h| 0.1 * h), [-0.6 * size, 0.0, 0.0]),
        ]
        .concat(),
        _ => {
            let blob = random.blob(5, size);
            (0..blob.triangles().len()).map(|i| blob.triangle(i).corners().map(|p| p.coords.into())).collect()
        }
    }
}

fn write_stl(path: &Path, facets: &[[[f64; 3]; 3]]) {
    let mut text = "solid s\n".to_owned();
    for facet in facets {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in facet {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    std::fs::write(path, text + "endsolid s\n").unwrap();
}

fn shape_of(facets: &[[[f64; 3]; 3]]) -> Shape {
    let vertices = facets.iter().flatten().map(|p| Point::from(*p)).collect();
    let faces = (0..u32::try_from(facets.len()).unwrap()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces.collect()).unwrap()))
}

/// A chain of links of meshes and primitives. Large ones are often inside each other, small ones only inside obstacles.
pub fn robot(random: &mut Random) -> Arc<RobotModel> {
    let scale = [1.0, 0.2, 0.2][random.below(3) as usize];
    let folder = tempfile::tempdir().unwrap();
    let mut urdf = "<robot name='r'><link name='root'/>".to_owned();
    for i in 0..=JOINTS {
        let mut shapes = String::new();
        for k in 0..=random.below(2) {
            let name = format!("{i}_{k}.stl");
            let size = scale * [0.04, 0.12, 0.35][random.below(3) as usize];
            write_stl(&folder.path().join(&name), &mesh(random, size));
            let geometry = if random.below(5) == 0 {
                format!("<sphere radius='{}'/>", 0.3 * size)
            } else {
                format!("<mesh filename='{name}'/>")
            };
            let [x, y, z] = random.vector(0.05).into();
            let _ = write!(
                shapes,
                "<collision><origin xyz='{x} {y} {z}' rpy='{y} {z} {x}'/><geometry>{geometry}</geometry></collision>"
            );
        }
        let _ = write!(urdf, "<link name='l{i}'>{shapes}</link>");
    }
    for i in 0..=JOINTS {
        let parent = if i == 0 { "root".to_owned() } else { format!("l{}", i - 1) };
        let kind = if i == 0 { "fixed" } else { ["prismatic", "revolute"][i % 2] };
        let axis = ["1 0 0", "0 1 0", "0 0 1"][random.below(3) as usize];
        let [x, y, z] = random.vector(0.3).into();
        let _ = write!(
            urdf,
            "<joint name='j{i}' type='{kind}'><parent link='{parent}'/><child link='l{i}'/><axis xyz='{axis}'/>
             <origin xyz='{x} {y} {z}'/><limit lower='-0.7' upper='0.7' effort='1' velocity='1'/></joint>"
        );
    }
    let path = folder.path().join("r.urdf");
    std::fs::write(&path, urdf + "</robot>").unwrap();
    Arc::new(RobotModel::load(&path, None, &[]).unwrap())
}

pub fn world(random: &mut Random) -> World {
    let mut world = World::default();
    for i in 0..2 + random.below(5) {
        let shape = match random.below(6) {
            0 => random.points(30, 0.4, 0.01),
            1 => Shape::Primitive(random.primitive()),
            // a room, and other large meshes
            2 => shape_of(&mesh(random, 1.2)),
            3 => shape_of(&ring(0.8, 0.35)),
            _ => shape_of(&mesh(random, 0.2)),
        };
        world.add(Obstacle::of_shape(format!("o{i}"), random.pose(0.5), shape)).unwrap();
    }
    if random.below(2) == 0 {
        let held = Obstacle::of_shape("held", random.pose(0.2), shape_of(&mesh(random, 0.1)));
        world.attach(AttachedObject::grasped(&held, "l5", &Pose::identity(), vec![])).unwrap();
    }
    world
}
