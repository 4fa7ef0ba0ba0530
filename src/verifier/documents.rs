//! Whether a certificate is about this robot, this world and one connected motion.

use super::Refusal;
use super::course::Course;
use super::subjects::Pair;
use crate::math::Pose;
use crate::motion::Certificate;
use crate::robot::{JointKind, RobotModel};
use crate::world::World;

/// The format whose meaning is known here.
const FORMAT: &str = "clearance certificate 1";

/// How far (rad, m) the end of a segment may be from the start of the next: what rounding makes of polynomials.
const JOINED: f64 = 1e-9;

/// What a certificate has to name.
#[derive(Debug)]
pub(super) struct Subject {
    pub model: String,
    pub world: String,
    pub pairs: Vec<Pair>,
}

/// Refuses what is about something else.
pub(super) fn check(certificate: &Certificate, robot: &RobotModel, subject: &Subject) -> Result<(), Refusal> {
    if certificate.format != FORMAT {
        return Err(Refusal::Format(certificate.format.clone()));
    }
    if certificate.digest != certificate.content_hash() {
        return Err(Refusal::Digest);
    }
    if certificate.robot != robot.name() {
        let (given, expected) = (certificate.robot.clone(), robot.name().to_owned());
        return Err(Refusal::Robot { given, expected });
    }
    if certificate.model != subject.model {
        return Err(Refusal::Model);
    }
    if certificate.world != subject.world {
        return Err(Refusal::World);
    }
    if certificate.motion != certificate.motion_hash() {
        return Err(Refusal::MotionHash);
    }
    check_joints(&certificate.joints, robot.position_names())?;
    check_pairs(&certificate.pairs, &subject.pairs)?;
    if certificate.segments.is_empty() { Err(Refusal::NoSegments) } else { Ok(()) }
}

fn check_joints(given: &[String], expected: &[String]) -> Result<(), Refusal> {
    for place in 0..given.len().max(expected.len()) {
        let name = |list: &[String]| list.get(place).cloned().unwrap_or_default();
        if given.get(place) != expected.get(place) {
            return Err(Refusal::Joints { place, given: name(given), expected: name(expected) });
        }
    }
    Ok(())
}

fn check_pairs(given: &[[String; 2]], expected: &[Pair]) -> Result<(), Refusal> {
    let same = given.len() == expected.len() && given.iter().zip(expected).all(|(g, e)| *g == e.names);
    if same {
        return Ok(());
    }
    if let Some(missing) = expected.iter().find(|e| !given.contains(&e.names)) {
        let [a, b] = missing.names.clone();
        return Err(Refusal::MissingPair(a, b));
    }
    if let Some([a, b]) = given.iter().find(|g| expected.iter().all(|e| e.names != **g)) {
        return Err(Refusal::UnknownPair(a.clone(), b.clone()));
    }
    let place = given.iter().zip(expected).position(|(g, e)| *g != e.names).unwrap_or(expected.len());
    let name = |names: Option<&[String; 2]>| names.cloned().unwrap_or_default();
    let expected = name(expected.get(place).map(|e| &e.names));
    Err(Refusal::PairOrder { place, given: name(given.get(place)), expected })
}

/// Refuses a segment whose ends are no configurations, and one that does not begin where the last ended.
pub(super) fn check_ends(
    segment: usize,
    last: Option<&Course>,
    course: &Course,
    robot: &RobotModel,
    world: &World,
) -> Result<(), Refusal> {
    for t in [0.0, 1.0] {
        let end = course.motion.at(t);
        robot.configuration(end.positions()).map_err(|error| Refusal::Configuration { segment, error })?;
    }
    let Some(last) = last else { return Ok(()) };
    let mut from = last.motion.at(1.0).positions().to_vec();
    let to = course.motion.at(0.0);
    turn_alike(robot, &mut from, to.positions());
    for ((from, to), position) in from.iter().zip(to.positions()).zip(robot.position_names()) {
        let joined = (from - to).abs() <= JOINED;
        if !joined {
            return Err(Refusal::Jump { segment, position: position.clone(), from: *from, to: *to });
        }
    }
    for id in world.ids() {
        let o = id.0 as usize;
        let (from, to) = (displacement(last, o, 1.0), displacement(course, o, 0.0));
        let shift = (to.translation.vector - from.translation.vector).amax();
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis().amax();
        let size = 1.0 + from.translation.vector.amax();
        if !(shift <= JOINED * size && turn <= JOINED) {
            return Err(Refusal::ObstacleJump { segment, name: world.obstacle(id).name.clone() });
        }
    }
    Ok(())
}

/// A quaternion and its negative are one rotation: takes the one that is nearer to the other configuration's.
fn turn_alike(robot: &RobotModel, positions: &mut [f64], other: &[f64]) {
    for id in robot.joint_ids() {
        let (JointKind::Floating, Some(first)) = (&robot.joint(id).kind, robot.first_position(id)) else {
            continue;
        };
        let (own, other) = (&mut positions[first + 3..first + 7], &other[first + 3..first + 7]);
        if own.iter().zip(other).map(|(p, q)| p * q).sum::<f64>() < 0.0 {
            for c in own {
                *c = -*c;
            }
        }
    }
}

fn displacement(course: &Course, obstacle: usize, t: f64) -> Pose {
    match course.mover_of[obstacle] {
        Some(mover) => course.motion.obstacles()[mover].displacement(t),
        None => Pose::identity(),
    }
}
