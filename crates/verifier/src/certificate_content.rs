//! Checks the format, hash, robot, world, joints and pairs of a certificate, and that its ends are valid states.

use std::collections::HashSet;

use clearance_motion::{Certificate, CertificateParts, shown};
use clearance_robot::RobotModel;

use super::CertificateDifferences;
use super::Rejection;
use super::body_pair::BodyPair;
use super::segment_kinematics::SegmentKinematics;

/// Fingerprints, parts and pairs that a certificate must contain.
#[derive(Debug)]
pub(super) struct RequiredContent {
    pub model: String,
    pub world: String,
    pub parts: CertificateParts,
    pub pairs: Vec<BodyPair>,
}

/// Rejects certificates of another robot, world or set of pairs.
pub(super) fn check(
    certificate: &Certificate,
    robot: &RobotModel,
    required: &RequiredContent,
) -> Result<(), Rejection> {
    if !certificate.has_known_format() {
        return Err(Rejection::Format(shown(&certificate.format)));
    }
    if certificate.digest != certificate.content_hash() {
        return Err(Rejection::Digest);
    }
    if certificate.robot != robot.name() {
        let (given, expected) = (shown(&certificate.robot), robot.name().to_owned());
        return Err(Rejection::Robot { given, expected });
    }
    check_robot_and_world(certificate, required)?;
    if let Some(tolerance) = certificate.tolerance.filter(|t| !(t.is_finite() && *t > 0.0)) {
        return Err(Rejection::Tolerance(tolerance));
    }
    if let Some(margin) = certificate.margin.filter(|m| !(m.is_finite() && *m >= 0.0)) {
        return Err(Rejection::BadMargin(margin));
    }
    if certificate.motion != certificate.motion_hash() {
        return Err(Rejection::MotionHash);
    }
    check_joints(&certificate.joints, robot.position_names())?;
    check_pairs(&certificate.pairs, &required.pairs)?;
    if certificate.segments.is_empty() { Err(Rejection::NoSegments) } else { Ok(()) }
}

/// Rejects another robot or another world. The hashes decide; the parts only describe the differences, and must not contradict the hashes.
fn check_robot_and_world(certificate: &Certificate, required: &RequiredContent) -> Result<(), Rejection> {
    let (mut models, mut worlds) = (CertificateDifferences::default(), CertificateDifferences::default());
    if let Some(parts) = &certificate.parts {
        models.add_models(parts, &required.parts);
        worlds.add_worlds(parts, &required.parts);
    }
    let is_another = [certificate.model != required.model, certificate.world != required.world];
    if is_another[0] {
        // pairs with obstacles depend on the world
        if models.is_empty() && !is_another[1] {
            models.add_pairs(&certificate.pairs, &required.pairs);
        }
        return Err(Rejection::Model(models));
    }
    if is_another[1] {
        return Err(Rejection::World(worlds));
    }
    match certificate.parts.as_ref().filter(|parts| **parts != required.parts) {
        Some(_) if !models.is_empty() => Err(Rejection::Parts(models)),
        Some(_) => Err(Rejection::Parts(worlds)),
        None => Ok(()),
    }
}

fn check_joints(given: &[String], expected: &[String]) -> Result<(), Rejection> {
    for place in 0..given.len().max(expected.len()) {
        let name = |list: &[String]| list.get(place).map(|name| shown(name)).unwrap_or_default();
        if given.get(place) != expected.get(place) {
            return Err(Rejection::Joints { place, given: name(given), expected: name(expected) });
        }
    }
    Ok(())
}

fn check_pairs(given: &[[String; 2]], expected: &[BodyPair]) -> Result<(), Rejection> {
    let same = given.len() == expected.len() && given.iter().zip(expected).all(|(g, e)| *g == e.names);
    if same {
        return Ok(());
    }
    let listed: HashSet<&[String; 2]> = given.iter().collect();
    if let Some(missing) = expected.iter().find(|e| !listed.contains(&e.names)) {
        let [a, b] = missing.names.clone();
        return Err(Rejection::MissingPair(a, b));
    }
    let needed: HashSet<&[String; 2]> = expected.iter().map(|e| &e.names).collect();
    if let Some([a, b]) = given.iter().find(|g| !needed.contains(g)) {
        return Err(Rejection::UnknownPair(shown(a), shown(b)));
    }
    let place = given.iter().zip(expected).position(|(g, e)| *g != e.names).unwrap_or(expected.len());
    let name = |names: Option<&[String; 2]>| names.map(|[a, b]| [shown(a), shown(b)]).unwrap_or_default();
    let expected = name(expected.get(place).map(|e| &e.names));
    Err(Rejection::PairOrder { place, given: name(given.get(place)), expected })
}

/// Rejects a segment whose ends are no valid configurations.
pub(super) fn check_ends(
    segment: usize,
    course: &SegmentKinematics,
    robot: &RobotModel,
) -> Result<(), Rejection> {
    for t in [0.0, 1.0] {
        let end = course.motion.at(t);
        robot.configuration(end.positions()).map_err(|error| Rejection::Configuration { segment, error })?;
    }
    Ok(())
}
