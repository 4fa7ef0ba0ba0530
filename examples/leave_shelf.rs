//! An arm that touches a board in a shelf moves out of contact by the derivatives of signed distances, then home.
//! A check of every step proves that nothing touches from the first free state on.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use clearance::checker::Clearance;
use clearance::geometry::math::Pose;
use clearance::{
    CollisionChecker, Configuration, MotionVerdict, Obstacle, Primitive, RobotModel, Settings, Shape, World,
};

/// Distance that pairs keep (m).
const MARGIN: f64 = 0.02;
/// Distance up to which pairs limit a step (m).
const INFLUENCE: f64 = 0.1;
/// Longest step of a joint (rad, m).
const STEP: f64 = 0.02;

/// A step towards `goal`, changed as little as possible such that, to first order, pairs that are nearer than the margin move apart,
/// and no others come nearer than it: cyclic projections onto half-spaces (Kaczmarz 1937; Agmon 1954).
fn step(clearance: &Clearance, q: &Configuration, goal: &Configuration) -> Vec<f64> {
    let mut step: Vec<f64> = q.positions().iter().zip(goal.positions()).map(|(q, goal)| goal - q).collect();
    let longest = step.iter().fold(STEP, |longest, s| s.abs().max(longest));
    for s in &mut step {
        *s *= STEP / longest;
    }
    for _ in 0..50 {
        for (index, pair) in clearance.pairs.iter().enumerate() {
            let row = clearance.row(index); // derivatives of this pair's signed distance (m/rad, m/m)
            let squared: f64 = row.iter().map(|d| d * d).sum();
            let change: f64 = row.iter().zip(&step).map(|(d, s)| d * s).sum();
            let needed = (0.5 * (MARGIN - pair.distance)).min(0.01);
            if squared > 1e-9 && change < needed {
                let share = (needed - change) / squared;
                for (s, d) in step.iter_mut().zip(row) {
                    *s += share * d;
                }
            }
        }
    }
    step
}

fn shelf() -> Result<World, Box<dyn Error>> {
    let mut world = World::default();
    for (name, size, [x, y, z]) in [
        ("lower board", [0.4, 0.5, 0.02], [0.75, 0.0, 0.33]),
        ("upper board", [0.4, 0.5, 0.02], [0.75, 0.0, 0.66]),
        ("left side", [0.4, 0.02, 0.35], [0.75, 0.25, 0.495]),
        ("right side", [0.4, 0.02, 0.35], [0.75, -0.25, 0.495]),
    ] {
        let board = Shape::Primitive(Primitive::cuboid(size)?);
        world.add(Obstacle::of_shape(name, Pose::translation(x, y, z), board))?;
    }
    Ok(world)
}

/// The least signed distance (m) and its pair, as text.
fn nearest(checker: &CollisionChecker, clearance: &Clearance) -> String {
    let least = clearance.pairs.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
    least.map_or("nothing near".to_owned(), |pair| {
        let [a, b] = [pair.a, pair.b].map(|body| checker.body_name(body));
        format!("{:.4} m, {a} and {b}", pair.distance)
    })
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm");
    let srdf = folder.join("demo_arm.srdf");
    let robot = Arc::new(RobotModel::load(&folder.join("demo_arm.urdf"), Some(&srdf), &[])?);
    let checker = CollisionChecker::new(Arc::clone(&robot), &shelf()?, Settings::default())?;
    let mut workspace = checker.workspace();
    let named = |positions: [f64; 7]| {
        let names = ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7"];
        robot.configuration_from_names(names.into_iter().zip(positions))
    };
    let mut q = named([0.0, 0.3, 0.0, -1.75, 0.0, 3.6, 0.785])?;
    let home = named([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])?;

    let mut clearance = checker.clearance(&q, INFLUENCE, &mut workspace);
    println!("in the shelf: {}", nearest(&checker, &clearance));
    let mut was_free = checker.is_free(&q, &mut workspace);
    if was_free {
        return Err("the arm does not touch the shelf at the beginning".into());
    }
    for steps in 0..300 {
        if q.positions().iter().zip(home.positions()).all(|(q, home)| (q - home).abs() < 1e-9) {
            println!("home after {steps} steps: {}", nearest(&checker, &clearance));
            return if was_free { Ok(()) } else { Err("home is not free".into()) };
        }
        let moved: Vec<f64> =
            q.positions().iter().zip(step(&clearance, &q, &home)).map(|(q, s)| q + s).collect();
        let next = robot.configuration(&moved)?;
        let verdict = checker.check_motion(&q, &next, &mut workspace).verdict;
        if was_free && verdict != MotionVerdict::Free {
            return Err(format!("step {steps} is not free: {verdict:?}").into());
        }
        clearance = checker.clearance(&next, INFLUENCE, &mut workspace);
        let is_free = checker.is_free(&next, &mut workspace);
        if is_free && !was_free {
            println!("free after {} steps: {}", steps + 1, nearest(&checker, &clearance));
        }
        (q, was_free) = (next, is_free);
    }
    Err("the arm did not come home".into())
}
