//! Many states on all cores: which are free, and how far is each from a collision?

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use clearance::{CollisionChecker, Configuration, Question, RobotModel, Settings, World};

/// A regular grid of the second and fourth joint (rad).
fn grid(robot: &RobotModel) -> Result<Vec<Configuration>, Box<dyn Error>> {
    let mut states = Vec::new();
    for i in 0..40 {
        for k in 0..40 {
            let (joint2, joint4) = (-1.0 + 0.05 * f64::from(i), -2.9 + 0.07 * f64::from(k));
            states.push(robot.configuration_from_names([("joint2", joint2), ("joint4", joint4)])?);
        }
    }
    Ok(states)
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm");
    let srdf = folder.join("demo_arm.srdf");
    let robot = Arc::new(RobotModel::load(&folder.join("demo_arm.urdf"), Some(&srdf), &[])?);
    let checker = CollisionChecker::new(Arc::clone(&robot), &World::default(), Settings::default())?;
    let states = grid(&robot)?;

    // the same results for any number of threads
    let free = checker.are_free(&states);
    println!("{} of {} states are free", free.iter().filter(|free| **free).count(), states.len());

    let reports = checker.check_states(&states, Question::Distance { limit: 1.0 });
    let distances = reports.iter().filter(|report| report.is_free()).filter_map(|report| report.nearest);
    let least = distances.min_by(|a, b| a.distance.total_cmp(&b.distance));
    let least = least.ok_or("no free state has anything within 1 m")?;
    println!("the free state nearest to a collision is {:.4} m from it", least.distance);
    Ok(())
}
