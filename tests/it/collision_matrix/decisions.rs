//! Tests of collision matrix decisions for small random robots, on dense grids and by a search for counterexamples.

use std::sync::Arc;

use clearance::collision_matrix::{DecidedPair, Decision, MatrixBuilder, MatrixDocument, MatrixOptions};
use clearance::robot::RobotModel;
use clearance::scene::Settings;
use clearance::verifier::NeverProof;
use fastrand::Rng;

use super::small_robots::{PairOracle, decide, robot, urdf};

/// Seeds of the robots.
const ROBOTS: u64 = 40;

/// States of a grid along each position.
const GRID: u32 = 13;

/// States of a grid over the limits of all positions, limits included.
fn grid(robot: &RobotModel) -> Vec<Vec<f64>> {
    let mut states = vec![Vec::new()];
    for [low, high] in robot.sampling_ranges() {
        states = (states.iter())
            .flat_map(|state| {
                (0..GRID).map(move |i| {
                    let value = low + (high - low) * f64::from(i) / f64::from(GRID - 1);
                    [&state[..], &[value]].concat()
                })
            })
            .collect();
    }
    states
}

/// The least distance (m) that a search by random steps finds.
fn least_distance(robot: &RobotModel, pair: &DecidedPair, oracle: &mut PairOracle, random: &mut Rng) -> f64 {
    let ranges = robot.sampling_ranges();
    let mut least = f64::INFINITY;
    for _ in 0..4 {
        let mut state: Vec<f64> = ranges.iter().map(|[l, h]| l + (h - l) * random.f64()).collect();
        let mut distance = oracle.distance(pair, &state);
        let mut step = 0.3;
        for _ in 0..120 {
            let moved = ranges.iter().zip(&state).map(|([low, high], value)| {
                (value + step * (high - low) * (2.0 * random.f64() - 1.0)).clamp(*low, *high)
            });
            let next: Vec<f64> = moved.collect();
            let there = oracle.distance(pair, &next);
            if there < distance {
                (distance, state) = (there, next);
            } else {
                step = (step * 0.95).max(1e-4);
            }
        }
        least = least.min(distance);
    }
    least
}

fn assert_holds(robot: &Arc<RobotModel>, pair: &DecidedPair, states: &[Vec<f64>], random: &mut Rng) {
    let mut oracle = PairOracle::new(robot);
    let named = format!("{} – {}", pair.link1, pair.link2);
    match &pair.decision {
        Decision::Never { .. } => {
            for state in states {
                assert!(!oracle.collides(pair, state), "{named} at {state:?}");
            }
            assert!(least_distance(robot, pair, &mut oracle, random) > 0.0, "{named}");
        }
        Decision::Always { .. } => {
            for state in states {
                assert!(oracle.collides(pair, state), "{named} at {state:?}");
            }
        }
        Decision::Sometimes { colliding, free } => {
            assert!(oracle.collides(pair, colliding) && !oracle.collides(pair, free), "{named}");
            for state in [colliding, free] {
                assert!(robot.outside_limits(state).next().is_none(), "{named} at {state:?}");
            }
        }
        Decision::Undecided { least_distance, state } => {
            assert!(!state.is_empty() && least_distance.is_some(), "{named}");
        }
    }
}

#[test]
fn no_decision_is_refuted() {
    let mut random = Rng::with_seed(3);
    let mut counts = std::collections::BTreeMap::new();
    for seed in 0..ROBOTS {
        let robot = robot(&urdf(seed));
        if robot.position_ranges().iter().any(|[low, high]| low > high) {
            continue;
        }
        let states = grid(&robot);
        for pair in decide(&robot, 2) {
            assert_holds(&robot, &pair, &states, &mut random);
            *counts.entry(pair.decision.name()).or_insert(0) += 1;
        }
    }
    println!("{counts:?}");
    for (name, least) in [("never", 20), ("always", 2), ("sometimes", 10)] {
        assert!(counts.get(name).is_some_and(|count| *count >= least), "{name}: {counts:?}");
    }
    let undecided = counts.get("undecided").copied().unwrap_or(0);
    assert!(undecided * 10 <= counts.values().sum::<i32>(), "{counts:?}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    for seed in 0..4 {
        let robot = robot(&urdf(seed));
        let one = decide(&robot, 1);
        assert!(one == decide(&robot, 3));
        assert_eq!(one.len(), robot.links().len() * (robot.links().len() - 1) / 2);
    }
}

#[test]
fn a_whole_turn_of_a_continuous_joint_counts() {
    // the arm hits the post only half a turn away from zero
    let text = "<robot name='turn'>
        <link name='base'><collision><origin xyz='-0.5 0 0'/><geometry><box size='0.1 0.1 0.1'/></geometry></collision></link>
        <link name='arm'><collision><origin xyz='0.3 0 0'/><geometry><box size='0.4 0.02 0.02'/></geometry></collision></link>
        <joint name='j' type='KIND'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/>
        <limit lower='-2.5' upper='2.5' effort='1' velocity='1'/></joint></robot>";
    let decision = |kind: &str| decide(&robot(&text.replace("KIND", kind)), 1)[0].decision.name();
    assert_eq!(decision("continuous"), "sometimes");
    assert_eq!(decision("revolute"), "never");
}

#[test]
fn a_mimic_joint_moves_with_its_leader() {
    // each finger alone would reach the other; together they keep their distance
    let finger = |name: &str, y: f64| {
        format!(
            "<link name='{name}'><collision><origin xyz='0 {y} 0'/><geometry><box size='0.02 0.02 0.1'/></geometry></collision></link>"
        )
    };
    let joint = |child: &str, mimic: &str| {
        format!(
            "<joint name='j{child}' type='prismatic'><parent link='palm'/><child link='{child}'/><axis xyz='0 1 0'/>
            <limit lower='-0.2' upper='0.2' effort='1' velocity='1'/>{mimic}</joint>"
        )
    };
    let text = |mimic: &str| {
        format!(
            "<robot name='hand'><link name='palm'/>{}{}{}{}</robot>",
            finger("a", 0.03),
            finger("b", -0.03),
            joint("a", ""),
            joint("b", mimic)
        )
    };
    let decision = |mimic: &str| decide(&robot(&text(mimic)), 1)[0].decision.name();
    assert_eq!(decision("<mimic joint='ja'/>"), "never");
    assert_eq!(decision("<mimic joint='ja' multiplier='-1'/>"), "sometimes");
    assert_eq!(decision(""), "sometimes");
}

#[test]
fn limits_of_followers_do_not_narrow_those_of_their_leader() {
    // the follower's limits have the wrong sign, and together with the leader's only zero would remain
    let text = "<robot name='hand'>
        <link name='palm'><collision><origin xyz='0 0.15 0'/><geometry><box size='0.02 0.02 0.1'/></geometry></collision></link>
        <link name='a'><collision><geometry><box size='0.02 0.02 0.1'/></geometry></collision></link>
        <link name='b'/>
        <joint name='ja' type='prismatic'><parent link='palm'/><child link='a'/><axis xyz='0 1 0'/>
        <limit lower='0' upper='0.2' effort='1' velocity='1'/></joint>
        <joint name='jb' type='prismatic'><parent link='palm'/><child link='b'/><axis xyz='0 1 0'/>
        <limit lower='0' upper='0.2' effort='1' velocity='1'/><mimic joint='ja' multiplier='-1'/></joint></robot>";
    let robot = robot(text);
    let pairs = decide(&robot, 1);
    assert_eq!(pairs[0].decision.name(), "sometimes");
    // the verifier agrees on the range: a proof at zero alone is none
    let proof =
        NeverProof { link1: pairs[0].link1.clone(), link2: pairs[0].link2.clone(), proof: ".".to_owned() };
    assert!(
        super::certificates::verify(&robot, &super::certificates::claiming(&robot, vec![proof])).is_err()
    );
}

#[test]
fn what_a_closed_surface_can_contain_is_not_always_in_contact() {
    // a ball in a box of faces that is a micrometre wider: free near zero only
    let folder = crate::program::Folder::new();
    let corner = |i: u32| {
        let side = |bit: u32| if i & bit == 0 { -0.100_001 } else { 0.100_001 };
        format!("v {} {} {}\n", side(1), side(2), side(4))
    };
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    folder.write("box.obj", &((0..8).map(corner).collect::<String>() + faces));
    folder.write(
        "r.urdf",
        "<robot name='shaker'>
        <link name='box'><collision><geometry><mesh filename='box.obj'/></geometry></collision></link>
        <link name='ball'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>
        <joint name='j' type='prismatic'><parent link='box'/><child link='ball'/><axis xyz='1 0 0'/>
        <limit lower='-0.05' upper='0.06' effort='1' velocity='1'/></joint></robot>",
    );
    let robot = Arc::new(RobotModel::load(&folder.path("r.urdf"), None, &[]).unwrap());
    assert_ne!(decide(&robot, 1)[0].decision.name(), "always");
}

#[test]
fn joints_without_a_range_prove_nothing() {
    let text = "<robot name='drone'>
        <link name='a'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>
        <link name='b'><collision><origin xyz='0 0 9'/><geometry><sphere radius='0.1'/></geometry></collision></link>
        <joint name='j' type='floating'><parent link='a'/><child link='b'/></joint></robot>";
    let robot = robot(text);
    let pairs = decide(&robot, 1);
    assert_eq!(pairs[0].decision.name(), "undecided");
    let document = MatrixDocument::new(&robot, &Settings::default(), pairs);
    let read = MatrixDocument::from_json(&document.to_json(), &robot, &Settings::default());
    assert_eq!(read, Ok(document));
}

#[test]
fn after_the_deadline_all_open_pairs_are_undecided() {
    let robot = robot(&urdf(0));
    let builder = MatrixBuilder::new(&robot, &Settings::default()).unwrap();
    let options = MatrixOptions { deadline: Some(std::time::Instant::now()), ..MatrixOptions::default() };
    let pairs = builder.decide(&[], &options, &|_| {});
    let can_move = |pair: &&DecidedPair| pair.variables > 0;
    assert!(!pairs.is_empty() && pairs.iter().filter(can_move).all(|pair| !pair.decision.is_final()));
}
