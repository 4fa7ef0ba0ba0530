//! Tests of the planner: its paths are proven and free in dense samples, its certificates verify.

use std::path::Path as FilePath;
use std::sync::Arc;

use clearance::checker::{CollisionChecker, MotionOptions};
use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, Shape};
use clearance::planner::{NoPlan, Path, Plan, PlanError, PlanOptions, plan};
use clearance::robot::{Configuration, JointGroup, MeshFiles, RobotModel};
use clearance::scene::{Obstacle, Settings, World};
use clearance::verifier::Verifier;
use serde_json::Value;

use crate::peer_results::{robot, scene_checker, scene_configuration, scene_files};
use crate::tally::{json, shared_folder};

/// The bundled arm between posts.
fn demo() -> (CollisionChecker, JointGroup) {
    let files = FilePath::new("urdf/demo_arm/demo_arm");
    let (urdf, srdf) = (files.with_extension("urdf"), files.with_extension("srdf"));
    let robot = Arc::new(RobotModel::load(&urdf, Some(&srdf), &[]).unwrap());
    let mut world = World::default();
    for (i, (x, y)) in [(0.45, 0.25), (0.45, -0.25), (0.1, 0.5), (0.1, -0.5)].into_iter().enumerate() {
        let post = Shape::Primitive(Primitive::cuboid([0.06, 0.06, 1.6]).unwrap());
        world.add(Obstacle::of_shape(format!("post{i}"), Pose::translation(x, y, 0.5), post)).unwrap();
    }
    let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default()).unwrap();
    let group = robot.joint_group("arm").unwrap();
    (checker, group)
}

/// Pairs of random free states in the group.
fn problems(checker: &CollisionChecker, group: &JointGroup, count: usize) -> Vec<[Configuration; 2]> {
    let mut random = fastrand::Rng::with_seed(11);
    let mut workspace = checker.workspace();
    let robot = checker.robot();
    let rest = robot.default_configuration();
    let mut free = std::iter::repeat_with(|| {
        let sample = robot.random_configuration(&mut random);
        let mut positions = vec![0.0; group.len()];
        group.get(&sample, &mut positions);
        let mut q = rest.clone();
        group.set(&mut q, &positions).unwrap();
        q
    })
    .filter(|q| checker.is_free(q, &mut workspace));
    (0..count).map(|_| [free.next().unwrap(), free.next().unwrap()]).collect()
}

fn found(
    checker: &CollisionChecker,
    group: &JointGroup,
    ends: &[Configuration; 2],
    options: &PlanOptions,
) -> Plan {
    plan(checker, group, &ends[0], &ends[1], options, &mut checker.workspace()).unwrap()
}

/// What every path must be: from start to goal, within limits, only joints of the group move, edges proven, samples free.
fn assert_sound(checker: &CollisionChecker, group: &JointGroup, ends: &[Configuration; 2], path: &Path) {
    let (first, last) = (path.states.first().unwrap(), path.states.last().unwrap());
    assert_eq!([first, last], [&ends[0], &ends[1]]);
    let mut workspace = checker.workspace();
    for q in &path.states {
        for (i, position) in q.positions().iter().enumerate() {
            match group.positions().iter().position(|index| *index == i) {
                Some(k) => assert!((group.lower()[k]..=group.upper()[k]).contains(position)),
                None => assert!(*position == ends[0].positions()[i]),
            }
        }
    }
    for edge in path.states.windows(2) {
        assert!(checker.check_motion(&edge[0], &edge[1], &mut workspace).is_free());
        for i in 0..=50 {
            let q = checker.robot().interpolate(&edge[0], &edge[1], f64::from(i) / 50.0);
            assert!(checker.is_free(&q, &mut workspace));
        }
    }
}

#[test]
fn paths_are_proven_and_certificates_verify() {
    let (checker, group) = demo();
    let verifier = Verifier::new(checker.robot(), checker.world(), checker.settings(), None).unwrap();
    let mut several = 0;
    for ends in problems(&checker, &group, 30) {
        let Plan::Found(path) = found(&checker, &group, &ends, &PlanOptions::default()) else {
            panic!("not found: {ends:?}");
        };
        assert_sound(&checker, &group, &ends, &path);
        let certificate = path.certificate(&checker, &MotionOptions::default(), &mut checker.workspace());
        verifier.verify(&certificate.unwrap()).unwrap();
        several += usize::from(path.states.len() > 2);
    }
    assert!(several > 5, "{several} paths have more than one edge");
}

#[test]
fn the_same_seed_gives_the_same_path_and_shortcuts_do_not_lengthen_it() {
    let (checker, group) = demo();
    let mut others = 0;
    for ends in problems(&checker, &group, 12) {
        let of = |seed, shortcuts| match found(
            &checker,
            &group,
            &ends,
            &PlanOptions { seed, shortcuts, ..PlanOptions::default() },
        ) {
            Plan::Found(path) => path,
            Plan::NotFound(reason) => panic!("{reason}"),
        };
        assert_eq!(of(3, 64), of(3, 64));
        assert!(of(3, 64).length() <= of(3, 0).length() + 1e-9);
        others += usize::from(of(3, 64).states != of(4, 64).states);
    }
    assert!(others > 0);
}

#[test]
fn failures_have_names() {
    let (checker, group) = demo();
    let [start, goal] = problems(&checker, &group, 1).remove(0);
    let colliding = collide(&checker, &group);
    let options = PlanOptions::default();
    let result = |start: &Configuration, goal: &Configuration, options: &PlanOptions| {
        plan(&checker, &group, start, goal, options, &mut checker.workspace())
    };
    assert_eq!(result(&colliding, &goal, &options), Ok(Plan::NotFound(NoPlan::StartNotFree)));
    assert_eq!(result(&start, &colliding, &options), Ok(Plan::NotFound(NoPlan::GoalNotFree)));
    let none = PlanOptions { most_edges: 0, ..PlanOptions::default() };
    assert_eq!(result(&start, &goal, &none), Ok(Plan::NotFound(NoPlan::MostEdges { edges: 0 })));
    let late = PlanOptions { deadline: Some(std::time::Instant::now()), ..PlanOptions::default() };
    assert_eq!(result(&start, &goal, &late), Ok(Plan::NotFound(NoPlan::Deadline { edges: 0 })));
    for range in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = result(&start, &goal, &PlanOptions { range, ..PlanOptions::default() }).unwrap_err();
        assert!(matches!(error, PlanError::NotPositive { option: "range", .. }), "{error}");
    }
    let mut beyond = start.clone();
    let far: Vec<f64> = (0..group.len()).map(|_| 40.0).collect();
    group.set(&mut beyond, &far).unwrap();
    let error = result(&beyond, &goal, &options).unwrap_err();
    assert!(error.to_string().starts_with("start: joint1 is at 40, beyond its limits"), "{error}");
}

#[test]
fn a_search_without_room_to_move_ends() {
    // the sphere is 0.1 mm from the box: free, but nearer than the tolerance of motions
    let urdf = "<robot name='stuck'><link name='base'/><link name='tool'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>
        <joint name='slide' type='prismatic'><parent link='base'/><child link='tool'/><axis xyz='1 0 0'/>
          <limit lower='0.25' upper='0.25' effort='1' velocity='1'/></joint></robot>";
    let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
    let mut world = World::default();
    let wall = Shape::Primitive(Primitive::cuboid([0.1, 1.0, 1.0]).unwrap());
    world.add(Obstacle::of_shape("wall".to_owned(), Pose::translation(0.4001, 0.0, 0.0), wall)).unwrap();
    let checker = CollisionChecker::new(Arc::clone(&robot), &world, Settings::default()).unwrap();
    let q = robot.configuration(&[0.25]).unwrap();
    let mut workspace = checker.workspace();
    assert!(checker.is_free(&q, &mut workspace));
    for (tolerance, most_edges) in [(1e-2, 50), (5e-4, 50)] {
        let options = PlanOptions { tolerance, most_edges, ..PlanOptions::default() };
        match plan(&checker, &robot.all_joints(), &q, &q, &options, &mut workspace).unwrap() {
            Plan::Found(path) => assert_eq!(path.states, [q.clone(), q.clone()]),
            Plan::NotFound(reason) => assert_eq!(reason, NoPlan::MostEdges { edges: most_edges }),
        }
    }
}

/// A state of the group that collides.
fn collide(checker: &CollisionChecker, group: &JointGroup) -> Configuration {
    let mut random = fastrand::Rng::with_seed(5);
    let mut workspace = checker.workspace();
    let robot = checker.robot();
    let mut q = robot.default_configuration();
    loop {
        let positions: Vec<f64> = (0..group.len())
            .map(|i| group.lower()[i] + (group.upper()[i] - group.lower()[i]) * random.f64())
            .collect();
        group.set(&mut q, &positions).unwrap();
        if !checker.is_free(&q, &mut workspace) {
            return q;
        }
    }
}

#[test]
fn joints_outside_of_the_group_do_not_move() {
    let (checker, group) = demo();
    let [start, goal] = problems(&checker, &group, 1).remove(0);
    let mut positions = goal.positions().to_vec();
    let other = (0..positions.len()).find(|i| !group.positions().contains(i)).unwrap();
    positions[other] += 0.001;
    let goal = checker.robot().configuration(&positions).unwrap();
    let error =
        plan(&checker, &group, &start, &goal, &PlanOptions::default(), &mut checker.workspace()).unwrap_err();
    assert!(matches!(error, PlanError::OtherJoint { .. }), "{error}");
}

/// The group that has exactly the joints of a problem.
fn group_of(robot: &RobotModel, problem: &Value) -> JointGroup {
    let joints = problem["start"].as_object().unwrap();
    let groups = robot.srdf().unwrap().groups.iter().map(|group| robot.joint_group(&group.name).unwrap());
    let mut same = groups.filter(|group| {
        group.len() == joints.len() && group.joint_names().iter().all(|joint| joints.contains_key(joint))
    });
    same.next().unwrap()
}

/// The samples of the shared scenes know which starts and goals are free.
#[test]
fn the_problems_of_the_shared_scenes_are_solved() {
    let (Some(scenes), Some(robots)) = (shared_folder("scenes"), shared_folder("robots")) else { return };
    let meshes = MeshFiles::under(&scenes);
    let (mut solved, mut unsolved) = (0, Vec::new());
    for file in scene_files(&scenes) {
        let scene = json(&file);
        let robot = Arc::new(robot(&robots, scene["robot"].as_str().unwrap(), true));
        for problem in scene["problems"].as_array().unwrap() {
            let is_valid = |end: &str| problem[end].as_bool().unwrap();
            let checker = scene_checker(&scene, problem, &robot, &meshes);
            let group = group_of(&robot, problem);
            let ends = [0.0, 1.0].map(|t| scene_configuration(problem, &robot, t));
            match found(&checker, &group, &ends, &PlanOptions::default()) {
                Plan::Found(path) => {
                    assert!(is_valid("start_valid") && is_valid("goal_valid"));
                    assert_sound(&checker, &group, &ends, &path);
                    solved += 1;
                }
                Plan::NotFound(NoPlan::StartNotFree) => assert!(!is_valid("start_valid")),
                Plan::NotFound(NoPlan::GoalNotFree) => assert!(!is_valid("goal_valid")),
                Plan::NotFound(reason) => unsolved.push(format!("{}: {reason}", problem["id"])),
            }
        }
    }
    assert!(unsolved.is_empty() && solved > 100, "{solved} solved, not: {unsolved:#?}");
}
