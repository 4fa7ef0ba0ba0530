//! Verifies the certificate of a collision matrix: pairs of links that never collide, or always.

use std::collections::HashSet;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Pose;
use clearance_geometry::{ScaleError, Shape};
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::{MeshModel, Settings};

use super::always_certificate::AlwaysProof;
use super::body::Body;
use super::contact_verifier::{ContactFault, ContactVerifier};
use super::matrix_certificate::{MatrixCertificate, NeverProof, matrix_fingerprint};
use super::matrix_path::MatrixPath;
use super::matrix_proof_text::{BoxFault, ProofText};
use super::matrix_rejection::MatrixRejection;
use super::matrix_separation::{ApartTest, BoxCentre};

/// Reason why the collision matrix of a robot cannot be verified with some settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum MatrixSettingsError {
    #[error(transparent)]
    Scale(#[from] ScaleError),
    #[error("the padding of '{link}' is {value}, but must be a finite number of metres, zero or more")]
    Padding { link: String, value: f64 },
}

/// Verifies certificates of the collision matrix of one robot. It can be shared by threads.
#[derive(Debug)]
pub struct MatrixVerifier<'r> {
    robot: &'r RobotModel,
    fingerprint: String,
    /// By link; `None` without shapes.
    bodies: Vec<Option<Body>>,
    /// By link, in its frame.
    shapes: Vec<Vec<(Pose, Shape)>>,
    meshes_are_solid: bool,
    /// By link (m).
    paddings: Vec<f64>,
}

impl<'r> MatrixVerifier<'r> {
    /// Builds the bodies of all links.
    ///
    /// # Errors
    /// If a shape cannot be scaled, or a padding is negative or not finite.
    pub fn new(robot: &'r RobotModel, settings: &Settings) -> Result<Self, MatrixSettingsError> {
        let solid = settings.mesh_model == MeshModel::Solid;
        let shapes = robot.links().iter().map(|link| {
            let scale = settings.link_scale.get(&link.name).copied().unwrap_or(1.0);
            let scaled = |shape: &Shape| if scale == 1.0 { Ok(shape.clone()) } else { shape.scaled(scale) };
            let shapes = link.collisions.iter().map(|c| Ok((c.pose_ls, scaled(&c.shape)?)));
            shapes.collect::<Result<Vec<(Pose, Shape)>, ScaleError>>()
        });
        let shapes: Vec<Vec<(Pose, Shape)>> = shapes.collect::<Result<_, _>>()?;
        let body = |shapes: &Vec<(Pose, Shape)>| {
            let shapes: Vec<(Pose, &Shape)> = shapes.iter().map(|(pose, shape)| (*pose, shape)).collect();
            (!shapes.is_empty()).then(|| Body::new(&shapes, solid))
        };
        Ok(Self {
            robot,
            fingerprint: matrix_fingerprint(robot, settings),
            bodies: shapes.iter().map(body).collect(),
            shapes,
            meshes_are_solid: solid,
            paddings: robot
                .links()
                .iter()
                .map(|link| padding(settings, &link.name))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Checks that a certificate is complete and about this robot. Its proofs are verified by [`Self::verify_pair`] and
    /// [`Self::verify_always`].
    ///
    /// # Errors
    /// If it is not.
    pub fn check_subject(&self, certificate: &MatrixCertificate) -> Result<(), MatrixRejection> {
        if certificate.format != MatrixCertificate::FORMAT {
            return Err(MatrixRejection::Format(certificate.format.clone()));
        }
        if certificate.digest != certificate.computed_digest() {
            return Err(MatrixRejection::Digest);
        }
        if certificate.model != self.fingerprint {
            return Err(MatrixRejection::OtherModel);
        }
        let never = certificate.pairs.iter().map(|proof| [&proof.link1, &proof.link2]);
        let always = certificate.always.iter().map(|proof| [&proof.link1, &proof.link2]);
        let mut known = HashSet::new();
        for [a, b] in never.chain(always) {
            if !known.insert([a.min(b), a.max(b)]) {
                return Err(MatrixRejection::Twice(a.clone(), b.clone()));
            }
        }
        Ok(())
    }

    /// Verifies the proof that a pair never collides; returns the number of boxes that were proven.
    ///
    /// # Errors
    /// The first box that is not proven.
    pub fn verify_pair(&self, proof: &NeverProof) -> Result<u64, MatrixRejection> {
        let NeverProof { link1, link2, proof } = proof;
        let (links, path) = self.path([link1, link2])?;
        let bodies = self.bodies_of(links).ok_or_else(|| MatrixRejection::UnknownLink(link1.clone()))?;
        let test = ApartTest { bodies, threshold: self.threshold(links) };
        let named = || (link1.clone(), link2.clone());
        if is_inside(bodies, &BoxCentre::new(&path, &path.ranges)) {
            return Err(MatrixRejection::Inside(named().0, named().1));
        }
        let mut is_proven = |kind: u8, text: &mut ProofText, ranges: &[[f64; 2]]| {
            let centre = BoxCentre::new(&path, ranges);
            Some(match kind {
                b'.' => test.are_apart(&centre),
                b'|' => test.have_gap_along_an_axis(&centre),
                b'/' => test.have_gap(&centre, &centre.direction(&text.direction()?)),
                _ => return None,
            })
        };
        let mut text = ProofText::new(proof);
        text.verify(&path.ranges, &mut is_proven).map_err(|fault| match (fault, named()) {
            (BoxFault::Damaged, (a, b)) => MatrixRejection::Damaged(a, b, text.at),
            (BoxFault::NotProven, (a, b)) => MatrixRejection::NotApart(a, b, text.at),
        })
    }

    /// Verifies the proof that a pair always collides; returns the number of boxes that were proven.
    ///
    /// # Errors
    /// The first ball that is in no solid, or the first box that is not proven.
    pub fn verify_always(&self, proof: &AlwaysProof) -> Result<u64, MatrixRejection> {
        let AlwaysProof { link1, link2, evidence } = proof;
        let (links, path) = self.path([link1, link2])?;
        let verifier = ContactVerifier {
            path,
            shapes: links.map(|link| self.shapes[link.index()].as_slice()),
            threshold: self.threshold(links),
            meshes_are_solid: self.meshes_are_solid,
        };
        let (a, b) = (link1.clone(), link2.clone());
        verifier.verify(evidence).map_err(|fault| match fault {
            ContactFault::Ball(side, ball) => {
                let of = [link1, link2][side].clone();
                MatrixRejection::Ball(a, b, of, ball)
            }
            ContactFault::Box(BoxFault::Damaged, at) => MatrixRejection::Damaged(a, b, at),
            ContactFault::Box(BoxFault::NotProven, at) => MatrixRejection::NotTouching(a, b, at),
        })
    }

    /// Two different links and the joints between them.
    fn path(&self, names: [&String; 2]) -> Result<([LinkId; 2], MatrixPath<'r>), MatrixRejection> {
        let links = [self.link(names[0])?, self.link(names[1])?];
        if links[0] == links[1] {
            return Err(MatrixRejection::UnknownLink(names[1].clone()));
        }
        let unbounded = || MatrixRejection::Unbounded(names[0].clone(), names[1].clone());
        Ok((links, MatrixPath::new(self.robot, links).ok_or_else(unbounded)?))
    }

    /// Distance (m) at or below which links collide.
    fn threshold(&self, links: [LinkId; 2]) -> f64 {
        links.map(|link| self.paddings[link.index()]).iter().sum::<f64>() + CONTACT_DISTANCE
    }

    fn link(&self, name: &str) -> Result<LinkId, MatrixRejection> {
        let found = self.robot.link_ids().find(|link| self.robot.described_name(*link) == name);
        found
            .filter(|link| self.bodies[link.index()].is_some())
            .ok_or_else(|| MatrixRejection::UnknownLink(name.to_owned()))
    }

    fn bodies_of(&self, [a, b]: [LinkId; 2]) -> Option<[&Body; 2]> {
        Some([self.bodies[a.index()].as_ref()?, self.bodies[b.index()].as_ref()?])
    }
}

/// True if a link is inside a closed mesh of the other at a state: surfaces that are apart in all states leave it there.
fn is_inside(bodies: [&Body; 2], centre: &BoxCentre) -> bool {
    let [Some(a), Some(b)] = bodies.map(|body| body.interior.as_ref()) else { return false };
    a.overlap(b, &centre.state.pose_ab())
}

/// The padding (m) of a link in checks with other links.
fn padding(settings: &Settings, link: &str) -> Result<f64, MatrixSettingsError> {
    let value = settings.link_padding.get(link).copied().unwrap_or(settings.padding);
    if !(value.is_finite() && value >= 0.0) {
        return Err(MatrixSettingsError::Padding { link: link.to_owned(), value });
    }
    Ok(if settings.pad_self { value } else { 0.0 })
}
