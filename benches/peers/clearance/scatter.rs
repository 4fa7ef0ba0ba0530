//! Generates random worlds of boxes, cylinders and spheres scattered around a robot.

use std::collections::BTreeSet;

use clearance::geometry::math::{Point, Vector, pose_from_xyz_quaternion};
use clearance::geometry::{Primitive, Shape};
use clearance::robot::LinkPoses;
use clearance::scene::BodyId;
use clearance::scene::Obstacle;
use clearance::{CollisionChecker, Configuration, Question, World};

use crate::Outcome;
use crate::random::Random;
use crate::surroundings::Surroundings;

/// Half the edge (m) of the cube in which the widest scatter lies, and by how much each next one is narrower.
const WIDEST: f64 = 12.0;
const NARROWER: f64 = 0.88;
const NARROWEST: f64 = 0.3;

/// An obstacle that more of the states touch stands where the robot always is, and is drawn again.
const OFTEN: f64 = 0.2;

/// So often, after which it is left out.
const TRIES: usize = 30;

/// A shape and where it is in the cube from -1 to 1.
struct Solid {
    shape: Primitive,
    at: [f64; 3],
    quaternion: [f64; 4],
}

impl Solid {
    /// Every third is a box, a cylinder, a sphere. The more there are, the smaller, as in the truth.
    fn draw(index: usize, count: usize, random: &mut Random) -> Outcome<Self> {
        let size = match count {
            0..50 => 1.2,
            50..500 => 1.0,
            _ => 0.8,
        };
        let mut between = |lower, upper| size * random.between(lower, upper);
        let shape = match index % 3 {
            0 => Primitive::cuboid(std::array::from_fn(|_| between(0.05, 0.2)))?,
            1 => Primitive::cylinder(between(0.025, 0.1), between(0.075, 0.3))?,
            _ => Primitive::sphere(between(0.025, 0.1))?,
        };
        let at = std::array::from_fn(|_| random.between(-1.0, 1.0));
        Ok(Self { shape, at, quaternion: random.in_ball() })
    }

    fn obstacle(&self, name: usize, centre: &Point, half_edge: f64) -> Outcome<Obstacle> {
        let at = centre + Vector::from(self.at) * half_edge;
        let pose = pose_from_xyz_quaternion(at.coords.into(), self.quaternion).ok_or("no pose")?;
        Ok(Obstacle::of_shape(name.to_string(), pose, Shape::Primitive(self.shape)))
    }
}

/// `count` primitives, as near to the robot as lets half of the states be free.
pub fn around(
    checker: &CollisionChecker,
    states: &[Configuration],
    count: usize,
    random: &mut Random,
) -> Outcome<World> {
    let centre = middle(checker);
    let mut solids: Vec<Solid> = (0..count).map(|i| Solid::draw(i, count, random)).collect::<Outcome<_>>()?;
    let mut half_edge = WIDEST;
    loop {
        let (world, free) = settle(checker, states, &mut solids, (&centre, half_edge), random)?;
        if 2.0 * free <= 1.0 || half_edge < NARROWEST {
            return Ok(world);
        }
        half_edge *= NARROWER;
    }
}

/// Primitives of the same density in ever larger cubes: each world holds the one before, in the middle. `counts` ascend; the
/// cube of the first has the half edge `reach`.
pub fn growing(
    checker: &CollisionChecker,
    states: &[Configuration],
    reach: f64,
    counts: &[usize],
    random: &mut Random,
) -> Outcome<Vec<World>> {
    let (Some(&first), Some(&last)) = (counts.first(), counts.last()) else { return Ok(Vec::new()) };
    let centre = middle(checker);
    let mut near: Vec<Solid> = (0..first).map(|i| Solid::draw(i, first, random)).collect::<Outcome<_>>()?;
    let (mut world, _) = settle(checker, states, &mut near, (&centre, reach), random)?;
    #[allow(clippy::cast_precision_loss)] // counts of obstacles
    let wider = (last as f64 / first as f64).cbrt();
    let from_middle = |s: &Solid| s.at.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let mut far = Vec::new();
    while far.len() < last - near.len() {
        let solid = Solid::draw(far.len(), first, random)?;
        if from_middle(&solid) * wider > 1.0 {
            far.push(solid);
        }
    }
    far.sort_by(|a, b| from_middle(a).total_cmp(&from_middle(b)));
    let mut far = far.iter();
    let mut worlds = Vec::new();
    for &count in counts {
        while world.len() < count {
            let solid = far.next().ok_or("too few primitives are drawn")?;
            world.add(solid.obstacle(world.len(), &centre, reach * wider)?)?;
        }
        worlds.push(world.clone());
    }
    Ok(worlds)
}

/// The world of the solids, of which none is touched often, and the share of states that it leaves free.
#[allow(clippy::cast_precision_loss)] // counts of states
fn settle(
    checker: &CollisionChecker,
    states: &[Configuration],
    solids: &mut Vec<Solid>,
    (centre, half_edge): (&Point, f64),
    random: &mut Random,
) -> Outcome<(World, f64)> {
    for attempt in 0.. {
        let mut world = World::default();
        for (name, solid) in solids.iter().enumerate() {
            world.add(solid.obstacle(name, centre, half_edge)?)?;
        }
        let (hits, free) = hits(checker, &world, states)?;
        let often: BTreeSet<usize> =
            (0..solids.len()).filter(|&i| hits[i] as f64 > OFTEN * states.len() as f64).collect();
        if often.is_empty() {
            return Ok((world, free as f64 / states.len().max(1) as f64));
        }
        if attempt < TRIES {
            let count = solids.len();
            for i in often {
                solids[i] = Solid::draw(i, count, random)?;
            }
        } else {
            let mut number = 0..;
            solids.retain(|_| number.next().is_some_and(|i| !often.contains(&i)));
        }
    }
    Err("every attempt was in vain".into())
}

/// By obstacle, how many states touch it; and how many touch none.
fn hits(checker: &CollisionChecker, world: &World, states: &[Configuration]) -> Outcome<(Vec<usize>, usize)> {
    let among = Surroundings::new(checker, world)?;
    let mut workspace = among.checker().workspace();
    let (mut hits, mut free) = (vec![0; world.place_count()], 0);
    for q in states {
        let report = among.checker().check(q, Question::Pairs, &mut workspace);
        let touched: BTreeSet<u32> = (report.colliding_pairs.iter())
            .filter_map(|(_, b)| if let BodyId::Obstacle(id) = b { Some(id.0) } else { None })
            .collect();
        free += usize::from(touched.is_empty());
        for id in touched {
            hits[id as usize] += 1;
        }
    }
    Ok((hits, free))
}

/// The mean of the origins of all links with geometry, in the default state.
fn middle(checker: &CollisionChecker) -> Point {
    let robot = checker.robot();
    let mut poses = LinkPoses::new(robot);
    robot.forward_kinematics(&robot.default_configuration(), &mut poses);
    let solid = robot.link_ids().filter(|&l| !robot.link(l).collisions.is_empty());
    let origins: Vec<Vector> = solid.map(|l| poses.pose(l).translation.vector).collect();
    #[allow(clippy::cast_precision_loss)] // a count of links
    let count = origins.len().max(1) as f64;
    Point::from(origins.iter().sum::<Vector>() / count)
}

/// How far (m) the robot gets from its middle in these states, along any axis.
pub fn reach(checker: &CollisionChecker, states: &[Configuration]) -> f64 {
    let (robot, centre) = (checker.robot(), middle(checker));
    let mut poses = LinkPoses::new(robot);
    let mut reach: f64 = 0.0;
    for q in states {
        robot.forward_kinematics(q, &mut poses);
        for link in robot.link_ids() {
            for collision in &robot.link(link).collisions {
                let pose = poses.pose(link) * collision.pose_ls;
                let beyond = match &collision.shape {
                    Shape::Mesh(mesh) => farthest(mesh.vertices().iter().map(|v| pose * v), &centre),
                    Shape::Primitive(p) => {
                        farthest([pose * Point::origin()].into_iter(), &centre) + p.bounding_radius()
                    }
                    _ => 0.0,
                };
                reach = reach.max(beyond);
            }
        }
    }
    reach
}

fn farthest(points: impl Iterator<Item = Point>, centre: &Point) -> f64 {
    points.map(|p| (p - centre).amax()).fold(0.0, f64::max)
}
