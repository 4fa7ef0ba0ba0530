//! Tests of memory: warm queries allocate none, and a checker's memory per pair does not grow with the joints between its links. A process
//! of its own, since a counter replaces the allocator.

use std::path::Path;
use std::sync::Arc;

use clearance::checker::{Clearance, ClearanceOptions};
use clearance::geometry::math::Pose;
use clearance::geometry::{Cube, Plane, PointCloud, Primitive, Shape, Voxels};
use clearance::proximity::{CollisionBody, Scratch, collide, distance, within_margin};
use clearance::robot::MeshFiles;
use clearance::{CollisionChecker, Configuration, Question, RobotModel, Settings, World};

fn checker(name: &str) -> CollisionChecker {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = |kind: &str| root.join(format!("urdf/{name}/{name}.{kind}"));
    let robot = Arc::new(RobotModel::load(&path("urdf"), Some(&path("srdf")), &[]).unwrap());
    CollisionChecker::new(robot, &World::default(), Settings::default()).unwrap()
}

/// Every combination of the ends and the middle of the first joints' ranges.
fn states(checker: &CollisionChecker) -> Vec<Configuration> {
    let robot = checker.robot();
    let middle = robot.default_configuration();
    let count = middle.positions().len().min(4);
    (0..3usize.pow(u32::try_from(count).unwrap()))
        .map(|code| {
            let mut positions = middle.positions().to_vec();
            for (i, position) in positions.iter_mut().take(count).enumerate() {
                *position = [-0.9, 0.3, 1.2][code / 3usize.pow(u32::try_from(i).unwrap()) % 3];
            }
            robot.configuration(&positions).unwrap()
        })
        .collect()
}

fn allocations(f: impl FnOnce()) -> u64 {
    allocation_counter::measure(f).count_total
}

#[test]
fn warm_checks_allocate_nothing() {
    for name in ["demo_arm", "dual_arm"] {
        let checker = checker(name);
        let states = states(&checker);
        let mut workspace = checker.workspace();
        let (options, mut result) = (ClearanceOptions::new(0.3), Clearance::default());
        let mut pass = |count: bool| {
            for q in &states {
                let free = allocations(|| {
                    let _ = checker.is_free(q, &mut workspace);
                });
                // a report that holds no pair has no memory of its own
                let least = Question::Distance { limit: f64::INFINITY };
                let mut hits = 0;
                let distance = allocations(|| {
                    hits = checker.check(q, least, &mut workspace).colliding_pairs.len();
                });
                let clearance =
                    allocations(|| checker.clearance_into(q, &options, &mut workspace, &mut result));
                let overlaps = result.pairs.iter().any(|pair| pair.distance <= 0.0);
                assert!(
                    !count || overlaps || clearance == 0,
                    "{name}: clearance allocated {clearance} times"
                );
                let least = Question::SelfAndWorldDistance { limit: f64::INFINITY };
                let both = allocations(|| drop(checker.check(q, least, &mut workspace)));
                assert!(!count || hits > 0 || both == 0, "{name}: distances allocated {both} times");
                assert!(!count || free == 0, "{name}: is_free allocated {free} times");
                assert!(!count || hits > 0 || distance == 0, "{name}: distance allocated {distance} times");
            }
        };
        pass(false);
        pass(true);
    }
}

#[test]
fn warm_queries_of_bodies_allocate_nothing() {
    let checker = checker("demo_arm");
    let robot = checker.robot();
    let of_links = (robot.links().iter())
        .filter_map(|l| CollisionBody::new(l.collisions.iter().map(|c| (&c.pose_ls, &c.shape))));
    let primitives = [
        Primitive::cuboid([0.1, 0.2, 0.3]),
        Primitive::capsule(0.05, 0.2),
        Primitive::cylinder(0.07, 0.2),
        Primitive::cone(0.07, 0.2),
        Primitive::sphere(0.1),
    ];
    let turned = Pose::rotation(clearance::geometry::math::Vector::new(0.4, 0.5, 0.6));
    let of_primitives = primitives
        .map(|p| CollisionBody::new([(&turned, &Shape::Primitive(p.unwrap()))]).expect("a body has a shape"));
    #[allow(clippy::cast_precision_loss)]
    let points: Vec<[f32; 3]> = (0..500).map(|i| [0.1, 0.001 * i as f32, 0.01 * (i % 20) as f32]).collect();
    let cubes = points.iter().map(|centre| Cube { centre: *centre, half_edge: 0.01 }).collect();
    let of_others = [
        Shape::Plane(Plane::from_coefficients([1.0, 2.0, 3.0, -0.2]).unwrap()),
        Shape::Points(PointCloud::new(points, 0.01).unwrap().into()),
        Shape::Voxels(Voxels::new(cubes).unwrap().into()),
    ]
    .map(|shape| CollisionBody::new([(&turned, &shape)]).expect("a body has a shape"));
    let bodies: Vec<CollisionBody> = of_links.chain(of_primitives).chain(of_others).collect();
    let mut scratch = Scratch::default();
    let mut pass = |count: bool| {
        for a in &bodies {
            for b in &bodies {
                for step in 0..5 {
                    let pose = Pose::translation(0.1 * f64::from(step), 0.05, -0.1);
                    let allocated = allocations(|| {
                        let _ = collide(a, b, &pose, &mut scratch);
                        let _ = distance(a, b, &pose, f64::INFINITY, &mut scratch);
                        let _ = within_margin(a, b, &pose, 0.02, &mut scratch);
                    });
                    assert!(!count || allocated == 0, "{allocated} allocations");
                }
            }
        }
    };
    pass(false);
    pass(true);
}

/// A chain of links with a box each, joined by joints that turn.
fn long_chain(links: usize) -> Arc<RobotModel> {
    let link = |i| {
        format!(
            "<link name='l{i}'><collision><origin xyz='0.05 0 0'/><geometry><box size='0.08 0.02 0.02'/></geometry></collision></link>"
        )
    };
    let joint = |i| {
        format!(
            "<joint name='j{i}' type='revolute'><parent link='l{}'/><child link='l{i}'/><origin xyz='0.1 0 0'/>
             <axis xyz='0 {} 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>",
            i - 1,
            i % 2
        )
    };
    let elements: String = (0..links).map(link).chain((1..links).map(joint)).collect();
    let urdf = format!("<robot name='chain'>{elements}</robot>");
    Arc::new(RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap())
}

/// Storage of a pair does not grow with the joints between its links.
#[test]
fn pairs_of_long_chains_take_no_more_memory_than_others() {
    const PER_PAIR: u64 = 160;
    const PER_LINK: u64 = 20_000;
    let links = 500;
    let robot = long_chain(links);
    let most = allocation_counter::measure(|| {
        let checker = CollisionChecker::new(robot, &World::default(), Settings::default()).unwrap();
        let mut stream = checker.streaming_workspace();
        let q = checker.robot().default_configuration();
        assert!(checker.is_free(&q, &mut stream));
    });
    let links = links as u64;
    let bound = PER_PAIR * links * (links - 1) / 2 + PER_LINK * links;
    assert!(most.bytes_max < bound, "{} bytes, more than {bound}", most.bytes_max);
}
