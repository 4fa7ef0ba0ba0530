//! Tests of certificates of collision matrices: proofs verify with the independent verifier, changed ones do not.

use std::path::Path;
use std::sync::Arc;

use clearance::collision_matrix::{DocumentError, MatrixBuilder, MatrixDocument, MatrixOptions};
use clearance::robot::RobotModel;
use clearance::scene::Settings;
use clearance::verifier::{MatrixCertificate, MatrixRejection, MatrixVerifier, NeverProof};

use super::small_robots::{decide, robot, urdf};
use crate::tally::shared_folder;

fn document(robot: &Arc<RobotModel>) -> MatrixDocument {
    MatrixDocument::new(robot, &Settings::default(), decide(robot, 2))
}

/// Verifies a certificate as a whole.
pub fn verify(robot: &RobotModel, certificate: &MatrixCertificate) -> Result<u64, MatrixRejection> {
    let verifier = MatrixVerifier::new(robot, &Settings::default()).unwrap();
    verifier.check_subject(certificate)?;
    let always = certificate.always.iter().map(|proof| verifier.verify_always(proof));
    certificate.pairs.iter().map(|proof| verifier.verify_pair(proof)).chain(always).sum()
}

/// A certificate of other proofs, whose digest fits.
pub fn claiming(robot: &RobotModel, pairs: Vec<NeverProof>) -> MatrixCertificate {
    MatrixCertificate::new(robot, &Settings::default(), pairs, Vec::new())
}

/// Robots with their matrices and certificates.
fn certified(seeds: std::ops::Range<u64>) -> Vec<(Arc<RobotModel>, MatrixDocument, MatrixCertificate)> {
    let of_seed = |seed| {
        let robot = robot(&urdf(seed));
        let document = document(&robot);
        let certificate = document.certificate(&robot, &Settings::default());
        (robot, document, certificate)
    };
    seeds.map(of_seed).collect()
}

#[test]
fn proofs_verify() {
    let (mut pairs, mut contacts, mut boxes, mut kinds) = (0, 0, 0, [false; 3]);
    for (robot, _, certificate) in certified(0..25) {
        let verified = verify(&robot, &certificate);
        boxes += verified.unwrap_or_else(|rejection| panic!("{rejection}"));
        pairs += certificate.pairs.len();
        contacts += certificate.always.len();
        for (kind, character) in kinds.iter_mut().zip(['.', '|', '/']) {
            *kind |= certificate.pairs.iter().any(|pair| pair.proof.contains(character));
        }
    }
    println!("{pairs} pairs apart, {contacts} in contact, {boxes} boxes, kinds of leaves {kinds:?}");
    assert!(pairs >= 20 && contacts >= 2 && boxes > 100 && kinds[0] && kinds[2], "{pairs} {boxes} {kinds:?}");
}

#[test]
fn a_pair_that_can_collide_has_no_proof() {
    let mut tried = 0;
    for (robot, document, certificate) in certified(0..30) {
        let proofs: Vec<&String> = certificate.pairs.iter().map(|pair| &pair.proof).collect();
        let open = document.pairs.iter().filter(|pair| !matches!(pair.decision.name(), "never"));
        for pair in open {
            for proof in proofs.iter().copied().chain([&".".to_owned(), &"|".to_owned(), &"0..".to_owned()]) {
                let (link1, link2) = (pair.link1.clone(), pair.link2.clone());
                let claim = claiming(&robot, vec![NeverProof { link1, link2, proof: proof.clone() }]);
                assert!(verify(&robot, &claim).is_err(), "{} – {}: {proof}", pair.link1, pair.link2);
                tried += 1;
            }
        }
    }
    assert!(tried > 30, "{tried}");
}

#[test]
fn changed_proofs_are_rejected() {
    let (mut changed, mut splits) = (0, 0);
    for (robot, _, certificate) in certified(0..12) {
        for pair in &certificate.pairs {
            let reject = |proof: String| {
                let claim = claiming(&robot, vec![NeverProof { proof: proof.clone(), ..pair.clone() }]);
                assert!(verify(&robot, &claim).is_err(), "{} instead of {}", proof, pair.proof);
            };
            let text = &pair.proof;
            // boxes that are missing or left over, variables that do not exist, damaged directions
            reject(text[..text.len() - 1].to_owned());
            reject(format!("{text}."));
            reject(String::new());
            reject(format!("Z{text}{text}"));
            reject("/!!!".to_owned());
            reject(format!("x{text}"));
            changed += 6;
            // a tree of which the first half is left out
            if text.len() > 1 && text.starts_with(|c: char| c.is_ascii_digit()) {
                reject(text[1..].to_owned());
                splits += 1;
            }
        }
    }
    assert!(changed > 50 && splits > 5, "{changed} {splits}");
}

#[test]
fn a_proof_of_another_robot_is_rejected() {
    let text = urdf(0);
    let robot_0 = robot(&text);
    let certificate = document(&robot_0).certificate(&robot_0, &Settings::default());
    // any wider limit, shape or padding is another model
    let wider = robot(&text.replacen("<limit lower='-", "<limit lower='-1", 1));
    assert_eq!(verify(&wider, &certificate), Err(MatrixRejection::OtherModel));
    let padded = Settings { padding: 0.01, pad_self: true, ..Settings::default() };
    let verifier = MatrixVerifier::new(&robot_0, &padded).unwrap();
    assert_eq!(verifier.check_subject(&certificate), Err(MatrixRejection::OtherModel));
    let other = MatrixCertificate { robot: "other".to_owned(), ..certificate.clone() };
    assert_eq!(verify(&robot_0, &other), Err(MatrixRejection::Digest));
    let format = MatrixCertificate { format: "x".to_owned(), ..certificate };
    assert_eq!(verify(&robot_0, &format), Err(MatrixRejection::Format("x".to_owned())));
}

#[test]
fn documents_keep_their_decisions_and_changed_ones_are_rejected() {
    let robot_1 = robot(&urdf(1));
    let (settings, document) = (Settings::default(), document(&robot_1));
    let text = document.to_json();
    let read = MatrixDocument::from_json(&text, &robot_1, &settings).unwrap();
    assert_eq!(read.to_json(), text);
    let altered = text.replacen("\"contact_share\":", "\"contact_share\":1", 1);
    assert_eq!(MatrixDocument::from_json(&altered, &robot_1, &settings), Err(DocumentError::Altered));
    let other = robot(&urdf(2));
    assert_eq!(MatrixDocument::from_json(&text, &other, &settings), Err(DocumentError::OtherModel));
    assert!(MatrixDocument::from_json("{}", &robot_1, &settings).is_err());
    // known pairs are taken over: without any box, the rest of a fresh search is undecided
    let builder = MatrixBuilder::new(&robot_1, &settings).unwrap();
    let options = MatrixOptions { most_boxes: 0, ..MatrixOptions::default() };
    assert_eq!(builder.decide(&read.pairs, &options, &|_| {}), read.pairs);
}

#[test]
fn every_pair_of_the_panda_is_decided_and_every_proof_verifies() {
    let Some(folder) = shared_folder("robots") else { return };
    let urdf = folder.join("moveit_resources_panda_description/urdf/panda.urdf");
    let srdf = folder.join("moveit_resources_panda_description/srdf/panda.srdf");
    let robot = Arc::new(RobotModel::load(&urdf, Some(Path::new(&srdf)), &[folder]).unwrap());
    let builder = MatrixBuilder::new(&robot, &Settings::default()).unwrap();
    let pairs = builder.decide(&[], &MatrixOptions::default(), &|_| {});
    assert!(pairs.iter().all(|pair| pair.decision.is_final()));
    let document = MatrixDocument::new(&robot, &Settings::default(), pairs);
    let certificate = document.certificate(&robot, &Settings::default());
    assert!(certificate.pairs.len() > 20 && certificate.always.len() > 5);
    let boxes = verify(&robot, &certificate).unwrap_or_else(|rejection| panic!("{rejection}"));
    println!("{} pairs, {boxes} boxes", certificate.pairs.len());
}
