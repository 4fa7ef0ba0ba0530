//! Checks that a certificate belongs to this robot, this world and one connected motion.

use std::collections::HashSet;

use clearance_motion::{Certificate, CertificateParts, shown};
use clearance_robot::RobotModel;

use super::Refusal;
use super::differences::Differences;
use super::segment_kinematics::SegmentKinematics;
use super::subjects::Pair;

/// What a certificate has to name.
#[derive(Debug)]
pub(super) struct Subject {
    pub model: String,
    pub world: String,
    pub parts: CertificateParts,
    pub pairs: Vec<Pair>,
}

/// Rejects certificates of something else.
pub(super) fn check(certificate: &Certificate, robot: &RobotModel, subject: &Subject) -> Result<(), Refusal> {
    if !certificate.has_known_format() {
        return Err(Refusal::Format(shown(&certificate.format)));
    }
    if certificate.digest != certificate.content_hash() {
        return Err(Refusal::Digest);
    }
    if certificate.robot != robot.name() {
        let (given, expected) = (shown(&certificate.robot), robot.name().to_owned());
        return Err(Refusal::Robot { given, expected });
    }
    check_subject(certificate, subject)?;
    if let Some(tolerance) = certificate.tolerance.filter(|t| !(t.is_finite() && *t > 0.0)) {
        return Err(Refusal::Tolerance(tolerance));
    }
    if certificate.motion != certificate.motion_hash() {
        return Err(Refusal::MotionHash);
    }
    check_joints(&certificate.joints, robot.position_names())?;
    check_pairs(&certificate.pairs, &subject.pairs)?;
    if certificate.segments.is_empty() { Err(Refusal::NoSegments) } else { Ok(()) }
}

/// Rejects another robot or another world. The hashes decide; the parts only describe the differences, and must not contradict the hashes.
fn check_subject(certificate: &Certificate, subject: &Subject) -> Result<(), Refusal> {
    let (mut models, mut worlds) = (Differences::default(), Differences::default());
    if let Some(parts) = &certificate.parts {
        models.add_models(parts, &subject.parts);
        worlds.add_worlds(parts, &subject.parts);
    }
    let is_another = [certificate.model != subject.model, certificate.world != subject.world];
    if is_another[0] {
        // of pairs with obstacles the world decides
        if models.is_empty() && !is_another[1] {
            models.add_pairs(&certificate.pairs, &subject.pairs);
        }
        return Err(Refusal::Model(models));
    }
    if is_another[1] {
        return Err(Refusal::World(worlds));
    }
    match certificate.parts.as_ref().filter(|parts| **parts != subject.parts) {
        Some(_) if !models.is_empty() => Err(Refusal::Parts(models)),
        Some(_) => Err(Refusal::Parts(worlds)),
        None => Ok(()),
    }
}

fn check_joints(given: &[String], expected: &[String]) -> Result<(), Refusal> {
    for place in 0..given.len().max(expected.len()) {
        let name = |list: &[String]| list.get(place).map(|name| shown(name)).unwrap_or_default();
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
    let listed: HashSet<&[String; 2]> = given.iter().collect();
    if let Some(missing) = expected.iter().find(|e| !listed.contains(&e.names)) {
        let [a, b] = missing.names.clone();
        return Err(Refusal::MissingPair(a, b));
    }
    let needed: HashSet<&[String; 2]> = expected.iter().map(|e| &e.names).collect();
    if let Some([a, b]) = given.iter().find(|g| !needed.contains(g)) {
        return Err(Refusal::UnknownPair(shown(a), shown(b)));
    }
    let place = given.iter().zip(expected).position(|(g, e)| *g != e.names).unwrap_or(expected.len());
    let name = |names: Option<&[String; 2]>| names.map(|[a, b]| [shown(a), shown(b)]).unwrap_or_default();
    let expected = name(expected.get(place).map(|e| &e.names));
    Err(Refusal::PairOrder { place, given: name(given.get(place)), expected })
}

/// Rejects a segment whose ends are no valid configurations.
pub(super) fn check_ends(
    segment: usize,
    course: &SegmentKinematics,
    robot: &RobotModel,
) -> Result<(), Refusal> {
    for t in [0.0, 1.0] {
        let end = course.motion.at(t);
        robot.configuration(end.positions()).map_err(|error| Refusal::Configuration { segment, error })?;
    }
    Ok(())
}
