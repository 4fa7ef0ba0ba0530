//! Snapshot tests of the reports and work counters of robots: a slow-down or another result shows in a diff.

use clearance::checker::{CollisionChecker, Question};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::Settings;
use clearance::scene::{SceneLoader, World};
use std::path::Path;
use std::sync::Arc;

use crate::random::Random;
use crate::tally::{json, shared_folder};

fn checker(urdf: &str, srdf: Option<&str>, world: Option<&str>) -> CollisionChecker {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let srdf = srdf.map(|s| root.join(s));
    let robot = RobotModel::load(&root.join(urdf), srdf.as_deref(), &[]).unwrap();
    let scene = world.map(|w| {
        let text = std::fs::read_to_string(root.join(w)).unwrap();
        SceneLoader::from_yaml(&text, w, &robot, &MeshFiles::default()).unwrap()
    });
    let world = scene.unwrap_or_default().scene.world;
    CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap()
}

/// Twelve states within the limits: what each question answers, and the work that all states took.
fn summary(checker: &CollisionChecker) -> String {
    let robot = checker.robot();
    let mut random = Random::new(2026);
    let mut workspace = checker.workspace();
    let mut lines = vec![format!("{} pairs", checker.pairs().len())];
    lines.extend(checker.pairs().skipped().map(|(reason, count)| format!("skipped: {count} {reason}")));
    for state in 0..12 {
        let positions: Vec<f64> = (robot.joint_ids())
            .filter(|j| robot.first_position(*j).is_some())
            .map(|j| robot.joint(j).limits.map_or(0.0, |l| random.within(l.lower, l.upper)))
            .collect();
        let q = robot.configuration(&positions).unwrap();
        let mut work = clearance::proximity::Work::default();
        let questions = [Question::Free, Question::Pairs, Question::Distance { limit: f64::INFINITY }];
        let [_, pairs, distance] = questions.map(|question| {
            let report = checker.check(&q, question, &mut workspace);
            work += report.work;
            report
        });
        let nearest = distance.nearest.unwrap();
        lines.push(format!(
            "state {state}: {} colliding, {:.6} m {} – {}; {} volume tests, {} screened pairs, {} primitive tests",
            pairs.colliding_pairs.len(),
            nearest.distance,
            checker.body_name(nearest.a),
            checker.body_name(nearest.b),
            work.volume_tests,
            work.screened_pairs,
            work.primitive_tests,
        ));
    }
    lines.join("\n")
}

#[test]
fn two_link() {
    insta::assert_snapshot!(summary(&checker("urdf/two_link/two_link.urdf", None, None)));
}

#[test]
fn demo_arm_in_its_world() {
    let srdf = Some("urdf/demo_arm/demo_arm.srdf");
    let world = Some("config/demo_world.yaml");
    insta::assert_snapshot!(summary(&checker("urdf/demo_arm/demo_arm.urdf", srdf, world)));
}

#[test]
fn dual_arm() {
    let srdf = Some("urdf/dual_arm/dual_arm.srdf");
    insta::assert_snapshot!(summary(&checker("urdf/dual_arm/dual_arm.urdf", srdf, None)));
}

/// Robots that nobody here wrote: a slow-down on them shows too.
#[test]
fn shared_robots() {
    let Some(folder) = shared_folder("robots") else { return };
    for entry in json(&folder.join("robots.json")).as_array().unwrap() {
        let path = |key: &str| entry[key].as_str().map(|p| folder.join(p));
        let robot = RobotModel::load(
            &path("urdf").unwrap(),
            path("srdf").as_deref(),
            &[path("package_root").unwrap_or_else(|| folder.clone())],
        );
        let name = entry["name"].as_str().unwrap();
        let robot = Arc::new(robot.unwrap_or_else(|e| panic!("{name}: {e}")));
        let checker = CollisionChecker::new(robot, &World::default(), Settings::default()).unwrap();
        insta::assert_snapshot!(format!("shared_{name}"), summary(&checker));
    }
}
