//! Tests of the evidence that links always collide: the independent verifier accepts it, and rejects changed evidence.

use std::sync::Arc;

use clearance_collision_matrix::{Decision, MatrixBuilder, MatrixDocument, MatrixOptions};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::{MeshModel, Settings};
use clearance_verifier::{
    AlwaysProof, ContactEvidence, ElementPoint, InnerBall, MatrixCertificate, MatrixRejection, MatrixVerifier,
};

/// A cube of edge length 1 around the origin, with a cavity of edge length 0.8.
const HOLLOW: &[u8] =
    b"v -.5 -.5 -.5\nv .5 -.5 -.5\nv .5 .5 -.5\nv -.5 .5 -.5\nv -.5 -.5 .5\nv .5 -.5 .5\nv .5 .5 .5\nv -.5 .5 .5\n\
      v -.4 -.4 -.4\nv .4 -.4 -.4\nv .4 .4 -.4\nv -.4 .4 -.4\nv -.4 -.4 .4\nv .4 -.4 .4\nv .4 .4 .4\nv -.4 .4 .4\n\
      f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
      f 10 11 12 9\nf 16 15 14 13\nf 13 14 10 9\nf 14 15 11 10\nf 15 16 12 11\nf 16 13 9 12\n";

/// A cube of edge length 1 around the origin.
static MESHES: [(&str, &[u8]); 2] = [("p/hollow.obj", HOLLOW), (
    "p/cube.obj",
    b"v -.5 -.5 -.5\nv .5 -.5 -.5\nv .5 .5 -.5\nv -.5 .5 -.5\nv -.5 -.5 .5\nv .5 -.5 .5\nv .5 .5 .5\nv -.5 .5 .5\n\
      f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
)];

fn mesh(size: &str) -> String {
    format!("<mesh filename='package://p/cube.obj' scale='{size}'/>")
}

fn link(name: &str, at: &str, geometry: &str) -> String {
    format!(
        "<link name='{name}'><collision><origin xyz='{at}'/><geometry>{geometry}</geometry></collision></link>"
    )
}

fn joint(child: &str, kind: &str, at: &str, axis: &str, [low, high]: [f64; 2]) -> String {
    format!(
        "<joint name='j_{child}' type='{kind}'><origin xyz='{at}'/><parent link='base'/><child link='{child}'/>
        <axis xyz='{axis}'/><limit lower='{low}' upper='{high}' effort='1' velocity='1'/></joint>"
    )
}

/// `arm` turns in `base`, `drawer` slides in it, `pin` stands on it, and `far` touches nothing.
fn urdf() -> String {
    [
        "<robot name='press'>".to_owned(),
        link("base", "0 0 0", &mesh("0.2 0.2 0.2")),
        link("arm", "0.1 0 0", &mesh("0.4 0.04 0.3")),
        link("drawer", "0 0 0", "<box size='0.3 0.05 0.05'/>"),
        link("pin", "0 0 0.15", "<box size='0.1 0.1 0.1'/>"),
        link("far", "0 0 2", "<sphere radius='0.1'/>"),
        joint("arm", "revolute", "0 0 0", "0 0 1", [-1.0, 1.0]),
        joint("drawer", "prismatic", "0 0 0", "1 0 0", [0.0, 0.1]),
        joint("pin", "fixed", "0 0 0", "1 0 0", [0.0, 0.0]),
        joint("far", "fixed", "0 0 0", "1 0 0", [0.0, 0.0]),
        "</robot>".to_owned(),
    ]
    .concat()
}

fn robot(urdf: &str) -> Arc<RobotModel> {
    let model = RobotModel::from_urdf(urdf, &MeshFiles::embedded(&MESHES));
    Arc::new(model.unwrap_or_else(|error| panic!("{error}")))
}

fn certificate(robot: &Arc<RobotModel>, settings: &Settings) -> MatrixCertificate {
    let builder = MatrixBuilder::new(robot, settings).unwrap();
    let pairs = builder.decide(&[], &MatrixOptions::default(), &|_| {});
    let always = pairs.iter().filter(|pair| matches!(pair.decision, Decision::Always { .. })).count();
    let certificate = MatrixDocument::new(robot, settings, pairs).certificate(robot, settings);
    assert_eq!(certificate.always.len(), always);
    certificate
}

fn verify(robot: &RobotModel, proof: &AlwaysProof) -> Result<u64, MatrixRejection> {
    MatrixVerifier::new(robot, &Settings::default()).unwrap().verify_always(proof)
}

/// The proof about a pair.
fn proof_of(certificate: &MatrixCertificate, link2: &str) -> AlwaysProof {
    let found = certificate.always.iter().find(|proof| proof.link1 == "base" && proof.link2 == link2);
    found.unwrap_or_else(|| panic!("base – {link2}")).clone()
}

#[test]
fn every_pair_in_contact_has_evidence_that_verifies() {
    let robot = robot(&urdf());
    let certificate = certificate(&robot, &Settings::default());
    let named = |proof: &AlwaysProof| format!("{} {}", proof.link1, proof.link2);
    let mut names: Vec<String> = certificate.always.iter().map(named).collect();
    names.sort();
    assert_eq!(names, ["arm drawer", "arm pin", "base arm", "base drawer", "base pin"]);
    for proof in &certificate.always {
        assert!(verify(&robot, proof).unwrap_or_else(|rejection| panic!("{rejection}")) > 0);
    }
    assert_eq!(proof_of(&certificate, "pin").evidence.proof, "=");
    let verifier = MatrixVerifier::new(&robot, &Settings::default()).unwrap();
    assert_eq!(verifier.check_subject(&certificate), Ok(()));
    let text = serde_json::to_string(&certificate).unwrap();
    assert_eq!(serde_json::from_str::<MatrixCertificate>(&text).unwrap(), certificate);
}

#[test]
fn solid_meshes_have_evidence_too() {
    let robot = robot(&urdf());
    let settings = Settings { mesh_model: MeshModel::Solid, ..Settings::default() };
    let certificate = certificate(&robot, &settings);
    assert_eq!(certificate.always.len(), 5);
    let verifier = MatrixVerifier::new(&robot, &settings).unwrap();
    for proof in &certificate.always {
        verifier.verify_always(proof).unwrap_or_else(|rejection| panic!("{rejection}"));
    }
}

#[test]
fn changed_trees_of_boxes_are_rejected() {
    let robot = robot(&urdf());
    let certificate = certificate(&robot, &Settings::default());
    for link2 in ["arm", "drawer", "pin"] {
        let valid = proof_of(&certificate, link2);
        let text = &valid.evidence.proof;
        let reject = |text: String| {
            let mut changed = valid.clone();
            changed.evidence.proof = text;
            assert!(verify(&robot, &changed).is_err(), "{changed:?}");
        };
        reject(String::new());
        reject(text[..text.len() - 1].to_owned());
        reject(format!("{text}{text}"));
        reject(format!("Z{text}{text}"));
        reject("*___000".to_owned());
        if link2 != "pin" {
            // half of the range is missing; points that touch in one state prove nothing about a range
            reject(format!("0{text}"));
            reject("=".to_owned());
        }
    }
}

#[test]
fn changed_balls_and_points_are_rejected() {
    let robot = robot(&urdf());
    let certificate = certificate(&robot, &Settings::default());
    let changes: [fn(&mut InnerBall); 7] = [
        |ball| ball.radius += 0.2,
        |ball| ball.radius = 1e-12,
        |ball| ball.radius = f64::NAN,
        |ball| ball.centre[1] += 1.0,
        |ball| ball.centre[2] = f64::INFINITY,
        |ball| ball.shape = 1,
        |ball| ball.face = 12,
    ];
    for link2 in ["arm", "drawer"] {
        let valid = proof_of(&certificate, link2);
        for (number, change) in changes.iter().enumerate() {
            let mut changed = valid.clone();
            changed.evidence.balls1.iter_mut().for_each(change);
            assert!(verify(&robot, &changed).is_err(), "{link2}: change {number}");
        }
    }
    let valid = proof_of(&certificate, "pin");
    let changes: [fn(&mut [ElementPoint; 2]); 5] = [
        |points| points[0].at = [1.0, 1.0, -1.0],
        |points| points[0].at = [0.5, 0.5, 0.5],
        |points| points[0].face = 12,
        |points| points[1].at = [0.0, 0.0, 0.06],
        |points| points[1].at = [0.0, 0.0, 0.05],
    ];
    for (number, change) in changes.iter().enumerate() {
        let mut changed = valid.clone();
        change(changed.evidence.contact.as_mut().unwrap());
        assert!(verify(&robot, &changed).is_err(), "change {number}");
    }
    let mut changed = valid;
    changed.evidence.contact = None;
    assert!(verify(&robot, &changed).is_err());
}

#[test]
fn evidence_about_other_pairs_ranges_and_shapes_is_rejected() {
    let text = urdf();
    let valid = certificate(&robot(&text), &Settings::default());
    let drawer = proof_of(&valid, "drawer");
    for link2 in ["far", "base", "none"] {
        let changed = AlwaysProof { link2: link2.to_owned(), ..drawer.clone() };
        assert!(verify(&robot(&text), &changed).is_err(), "{link2}");
    }
    // with this range the drawer leaves the base; the other drawer is beside it
    let wider = text.replace("upper='0.1'", "upper='0.5'");
    let beside = text.replace("<origin xyz='0 0 0'/><geometry><box", "<origin xyz='0 0.3 0'/><geometry><box");
    for other in [wider, beside] {
        assert_ne!(other, text);
        let other = robot(&other);
        assert!(verify(&other, &drawer).is_err());
        let verifier = MatrixVerifier::new(&other, &Settings::default()).unwrap();
        assert_eq!(verifier.check_subject(&valid), Err(MatrixRejection::OtherModel));
    }
    let mut changed = valid;
    changed.always[0].evidence.proof.push('.');
    let robot = robot(&text);
    let verifier = MatrixVerifier::new(&robot, &Settings::default()).unwrap();
    assert_eq!(verifier.check_subject(&changed), Err(MatrixRejection::Digest));
}

/// A cube inside of a larger one touches only if meshes are solid.
#[test]
fn a_mesh_inside_another_is_no_contact_of_surfaces() {
    let text = [
        "<robot name='nest'>".to_owned(),
        link("base", "0 0 0", &mesh("0.2 0.2 0.2")),
        link("inner", "0 0 0", &mesh("0.05 0.05 0.05")),
        joint("inner", "revolute", "0 0 0", "0 0 1", [-1.0, 1.0]),
        "</robot>".to_owned(),
    ]
    .concat();
    let robot = robot(&text);
    let ball = InnerBall { shape: 0, face: 0, centre: [0.0; 3], radius: 0.02 };
    let mut rejected = 0;
    let orders = [["base", "inner"], ["inner", "base"]];
    let all = ["0", "1000", "2000", "3000000", "3Wo-bEA", "3zzzzzz"];
    for (directions, [link1, link2]) in all.into_iter().flat_map(|text| orders.map(|order| (text, order))) {
        let evidence = ContactEvidence {
            balls1: vec![ball],
            balls2: vec![ball],
            contact: None,
            proof: format!("*000000{directions}"),
        };
        let proof = AlwaysProof { link1: link1.to_owned(), link2: link2.to_owned(), evidence };
        rejected += usize::from(verify(&robot, &proof).is_err());
        let solid = Settings { mesh_model: MeshModel::Solid, ..Settings::default() };
        assert_eq!(MatrixVerifier::new(&robot, &solid).unwrap().verify_always(&proof), Ok(1));
    }
    assert_eq!(rejected, 12);
    assert!(certificate(&robot, &Settings::default()).always.is_empty());
}

/// A ball in the cavity of a mesh touches nothing, whatever meshes are.
#[test]
fn a_body_in_a_cavity_is_no_contact() {
    let text = [
        "<robot name='nest'>".to_owned(),
        link("base", "0 0 0", "<mesh filename='package://p/hollow.obj'/>"),
        link("inner", "0 0 0", "<sphere radius='0.05'/>"),
        joint("inner", "revolute", "0 0 0", "0 0 1", [-1.0, 1.0]),
        "</robot>".to_owned(),
    ]
    .concat();
    let robot = robot(&text);
    let ball = |face| InnerBall { shape: 0, face, centre: [0.0; 3], radius: 0.02 };
    for meshes in [MeshModel::Surface, MeshModel::Solid] {
        let settings = Settings { mesh_model: meshes, ..Settings::default() };
        // the first faces of the outer cube and of the cavity
        for face in [0, 12] {
            for directions in ["0", "1000", "2000", "3000000", "3Wo-bEA"] {
                let evidence = ContactEvidence {
                    balls1: vec![ball(face)],
                    balls2: vec![ball(0)],
                    contact: None,
                    proof: format!("*000000{directions}"),
                };
                let proof = AlwaysProof { link1: "base".to_owned(), link2: "inner".to_owned(), evidence };
                let verifier = MatrixVerifier::new(&robot, &settings).unwrap();
                assert!(verifier.verify_always(&proof).is_err(), "{meshes:?} {face} {directions}");
            }
        }
        assert!(certificate(&robot, &settings).always.is_empty());
    }
}

#[test]
fn bad_paddings_and_doubled_pairs_are_rejected() {
    let robot = robot(&urdf());
    for padding in [-0.05, f64::INFINITY, f64::NAN] {
        for pad_self in [false, true] {
            let settings = Settings { padding, pad_self, ..Settings::default() };
            let error = MatrixVerifier::new(&robot, &settings).unwrap_err().to_string();
            assert!(error.contains("the padding of 'base'"), "{error}");
        }
    }
    let valid = certificate(&robot, &Settings::default());
    let mut always = valid.always.clone();
    let doubled =
        AlwaysProof { link1: always[0].link2.clone(), link2: always[0].link1.clone(), ..always[0].clone() };
    always.push(doubled);
    let changed = MatrixCertificate::new(&robot, &Settings::default(), valid.pairs, always);
    let verifier = MatrixVerifier::new(&robot, &Settings::default()).unwrap();
    assert!(matches!(verifier.check_subject(&changed), Err(MatrixRejection::Twice(..))));
}
