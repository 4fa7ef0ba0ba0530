//! An arm reaches into a shelf and touches a board. It moves to its home position by derivatives of signed distances, and a check of the
//! motion proves that nothing touches on the way.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use clearance::checker::Clearance;
use clearance::geometry::math::Pose;
use clearance::{
    CollisionChecker, Configuration, MotionVerdict, Obstacle, Primitive, RobotModel, Settings, Shape, World,
};

/// Pairs keep this distance (m).
const MARGIN: f64 = 0.02;

/// Pairs up to this distance (m) limit the motion.
const INFLUENCE: f64 = 0.1;

/// Longest step of a joint (rad, m).
const STEP: f64 = 0.02;

/// One step towards `goal`, changed as little as possible such that no pair comes nearer than the margin, to first order.
fn step(clearance: &Clearance, q: &Configuration, goal: &Configuration) -> Vec<f64> {
    let mut step: Vec<f64> = q.positions().iter().zip(goal.positions()).map(|(q, goal)| goal - q).collect();
    let longest = step.iter().fold(STEP, |longest, s| s.abs().max(longest));
    for s in &mut step {
        *s *= STEP / longest;
    }
    // projections on the half-spaces row · step >= needed, in turn (Kaczmarz)
    for _ in 0..50 {
        for (i, pair) in clearance.pairs.iter().enumerate() {
            let row = clearance.row(i);
            let squared: f64 = row.iter().map(|d| d * d).sum();
            let change: f64 = row.iter().zip(&step).map(|(d, s)| d * s).sum();
            let needed = (0.5 * (MARGIN - pair.distance)).min(0.01);
            if squared > 1e-9 && change < needed {
                let share = (needed - change) / squared;
                step.iter_mut().zip(row).for_each(|(s, d)| *s += share * d);
            }
        }
    }
    step
}

fn shelf() -> Result<World, Box<dyn Error>> {
    let mut world = World::default();
    for (name, size, at) in [
        ("lower board", [0.4, 0.5, 0.02], [0.75, 0.0, 0.33]),
        ("upper board", [0.4, 0.5, 0.02], [0.75, 0.0, 0.66]),
        ("left side", [0.4, 0.02, 0.35], [0.75, 0.25, 0.495]),
        ("right side", [0.4, 0.02, 0.35], [0.75, -0.25, 0.495]),
    ] {
        let [x, y, z] = at;
        let board = Shape::Primitive(Primitive::cuboid(size)?);
        world.add(Obstacle::of_shape(name, Pose::translation(x, y, z), board))?;
    }
    Ok(world)
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
    let mut q = named([0.0, 0.35, 0.0, -1.8, 0.0, 3.6, 0.785])?;
    let home = named([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])?;
    for k in 0..300 {
        let clearance = checker.clearance(&q, INFLUENCE, &mut workspace);
        let nearest = clearance.pairs.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
        if k % 10 == 0 {
            println!(
                "{k}: {:?} {:?}",
                nearest.map(|n| (checker.body_name(n.a), checker.body_name(n.b), n.distance)),
                q.positions()
            );
        }
        let step = step(&clearance, &q, &home);
        let moved: Vec<f64> = q.positions().iter().zip(&step).map(|(q, s)| q + s).collect();
        let next = robot.configuration(&moved)?;
        if nearest.is_none_or(|nearest| nearest.distance > 0.0) {
            let verdict = checker.check_motion(&q, &next, &mut workspace).verdict;
            if verdict != MotionVerdict::Free {
                println!("step {k}: {verdict:?}");
            }
        }
        q = next;
    }
    Ok(())
}
