//! Bench worlds: obstacles that are closed meshes (trench and rings) around a robot that is outside of them.

use std::f64::consts::TAU;
use std::sync::Arc;

use clearance::World;
use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::scene::Obstacle;

use crate::random::Random;

/// A round trench with a wall: a closed mesh whose bounding box contains the robot, and whose inside does not.
fn trench(reach: f64, around: u32, across: u32) -> TriangleMesh {
    let profile: [[f64; 2]; 6] = [[0.4, -0.3], [1.4, -0.3], [1.4, 1.2], [1.3, 1.2], [1.3, -0.2], [0.4, -0.2]];
    let lengths: Vec<f64> = (0..6)
        .map(|i| {
            let ([a, b], [c, d]) = (profile[i], profile[(i + 1) % 6]);
            (c - a).hypot(d - b)
        })
        .collect();
    let total: f64 = lengths.iter().sum();
    let at_length = |mut s: f64| {
        for (i, length) in lengths.iter().enumerate() {
            if s <= *length || i == 5 {
                let ([a, b], [c, d]) = (profile[i], profile[(i + 1) % 6]);
                return [a + (c - a) * s / length, b + (d - b) * s / length];
            }
            s -= length;
        }
        unreachable!("the last side ends the loop")
    };
    let vertices = (0..around).flat_map(|i| (0..across).map(move |j| (i, j))).map(|(i, j)| {
        let [r, z] = at_length(f64::from(j) / f64::from(across) * total);
        let angle = f64::from(i) / f64::from(around) * TAU;
        let ripple = 1.0 + 0.004 * (17.0 * angle).sin() * (23.0 * z).cos();
        Point::new(reach * r * ripple * angle.cos(), reach * r * ripple * angle.sin(), reach * z)
    });
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let quads = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let faces = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh::new(vertices.collect(), faces.collect()).expect("a valid mesh")
}

/// Small closed rings around the robot.
fn rings(reach: f64, count: usize, random: &mut Random) -> Vec<Obstacle> {
    let ring = Arc::new(trench(0.1 * reach, 60, 40));
    (0..count)
        .map(|i| {
            let mut pose = random.pose(0.0);
            #[allow(clippy::cast_precision_loss)] // few rings
            let angle = TAU * (i as f64 / count as f64);
            pose.translation =
                [reach * angle.cos(), reach * angle.sin(), reach * random.within(-0.6, 0.6)].into();
            Obstacle::of_shape(format!("ring{i}"), pose, Shape::Mesh(Arc::clone(&ring)))
        })
        .collect()
}

/// Surroundings of a robot of this reach (m), and whether the robot is checked with itself, too.
pub fn worlds(reach: f64) -> Vec<(&'static str, World, bool)> {
    let (mut large, mut scattered) = (World::default(), World::default());
    let mesh = Shape::Mesh(Arc::new(trench(reach, 400, 128)));
    large.add(Obstacle::of_shape("trench", Pose::identity(), mesh)).expect("a new name");
    for ring in rings(reach, 20, &mut Random::new(3)) {
        scattered.add(ring).expect("a new name");
    }
    vec![("itself", World::default(), true), ("trench", large, false), ("rings", scattered, false)]
}
