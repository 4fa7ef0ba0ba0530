//! Verifies the proofs of a collision matrix.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Pose, Vector};
use clearance_geometry::{ScaleError, Shape};
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::{MeshModel, Settings};

use super::body::Body;
use super::matrix_certificate::{MatrixCertificate, NeverProof, matrix_fingerprint};
use super::matrix_motion::{MatrixMotion, MotionAlong};
use super::matrix_path::{MatrixPath, MatrixState};
use super::separation_test::SeparationTest;

/// Largest number of nested halvings.
const DEEPEST: usize = 400;

/// Reason why a certificate of a collision matrix is rejected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum MatrixRejection {
    #[error("the format is '{0}', not '{format}'", format = MatrixCertificate::FORMAT)]
    Format(String),
    #[error("the certificate was changed: its digest does not match its content")]
    Digest,
    #[error("the certificate is about another robot, or about other joint limits, shapes or settings")]
    OtherModel,
    #[error("the robot has no link '{0}' with collision geometry")]
    UnknownLink(String),
    #[error("'{0}' – '{1}': a joint between the links has no finite range, so that nothing can be proven")]
    Unbounded(String, String),
    #[error("'{0}' – '{1}': the text of the proof is damaged at character {2}")]
    Damaged(String, String, usize),
    #[error("'{0}' – '{1}': the links are not proven apart in the box that ends at character {2}")]
    NotApart(String, String, usize),
    #[error("'{0}' – '{1}': one link lies inside a closed mesh of the other")]
    Inside(String, String),
}

/// Verifies certificates of the collision matrix of one robot. It can be shared by threads.
#[derive(Debug)]
pub struct MatrixVerifier<'r> {
    robot: &'r RobotModel,
    fingerprint: String,
    /// By link; `None` without shapes.
    bodies: Vec<Option<Body>>,
    /// By link (m).
    paddings: Vec<f64>,
}

impl<'r> MatrixVerifier<'r> {
    /// Builds the bodies of all links.
    ///
    /// # Errors
    /// If a shape cannot be scaled.
    pub fn new(robot: &'r RobotModel, settings: &Settings) -> Result<Self, ScaleError> {
        let solid = settings.mesh_model == MeshModel::Solid;
        let bodies = robot.links().iter().map(|link| {
            let scale = settings.link_scale.get(&link.name).copied().unwrap_or(1.0);
            let scaled = |shape: &Shape| if scale == 1.0 { Ok(shape.clone()) } else { shape.scaled(scale) };
            let shapes = link.collisions.iter().map(|c| Ok((c.pose_ls, scaled(&c.shape)?)));
            let shapes: Vec<(Pose, Shape)> = shapes.collect::<Result<_, ScaleError>>()?;
            let shapes: Vec<(Pose, &Shape)> = shapes.iter().map(|(pose, shape)| (*pose, shape)).collect();
            Ok((!shapes.is_empty()).then(|| Body::new(&shapes, solid)))
        });
        let padding = |name: &String| settings.link_padding.get(name).copied().unwrap_or(settings.padding);
        let paddings =
            robot.links().iter().map(|link| if settings.pad_self { padding(&link.name) } else { 0.0 });
        Ok(Self {
            robot,
            fingerprint: matrix_fingerprint(robot, settings),
            bodies: bodies.collect::<Result<_, ScaleError>>()?,
            paddings: paddings.collect(),
        })
    }

    /// Checks that a certificate is complete and about this robot. Its proofs are verified by [`Self::verify_pair`].
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
        Ok(())
    }

    /// Verifies the proof of one pair; returns the number of boxes that were proven.
    ///
    /// # Errors
    /// The first box that is not proven.
    pub fn verify_pair(&self, proof: &NeverProof) -> Result<u64, MatrixRejection> {
        let links = [self.link(&proof.link1)?, self.link(&proof.link2)?];
        let named = || (proof.link1.clone(), proof.link2.clone());
        let unbounded = || MatrixRejection::Unbounded(named().0, named().1);
        if links[0] == links[1] {
            return Err(MatrixRejection::UnknownLink(proof.link2.clone()));
        }
        let path = MatrixPath::new(self.robot, links).ok_or_else(unbounded)?;
        let bodies =
            self.bodies_of(links).ok_or_else(|| MatrixRejection::UnknownLink(proof.link1.clone()))?;
        let mut reader = ProofReader {
            proof,
            at: 0,
            boxes: 0,
            pair: PairProof {
                bodies,
                threshold: links.map(|link| self.paddings[link.index()]).iter().sum::<f64>()
                    + CONTACT_DISTANCE,
                path,
            },
        };
        reader.pair.check_not_inside(proof)?;
        let mut ranges = reader.pair.path.ranges.clone();
        reader.verify_box(&mut ranges, 0)?;
        if reader.at != proof.proof.len() {
            return Err(reader.damaged());
        }
        Ok(reader.boxes)
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

/// Reads the text of a proof and verifies its boxes.
struct ProofReader<'p> {
    proof: &'p NeverProof,
    /// Next character.
    at: usize,
    boxes: u64,
    pair: PairProof<'p>,
}

impl ProofReader<'_> {
    fn damaged(&self) -> MatrixRejection {
        MatrixRejection::Damaged(self.proof.link1.clone(), self.proof.link2.clone(), self.at)
    }

    fn next(&mut self) -> Result<u8, MatrixRejection> {
        let byte = self.proof.proof.as_bytes().get(self.at).copied().ok_or_else(|| self.damaged())?;
        self.at += 1;
        Ok(byte)
    }

    fn verify_box(&mut self, ranges: &mut [[f64; 2]], depth: usize) -> Result<(), MatrixRejection> {
        if depth > DEEPEST {
            return Err(self.damaged());
        }
        let is_proven = match self.next()? {
            b'.' => self.pair.is_apart(ranges),
            b'|' => self.pair.has_gap_along_an_axis(ranges),
            b'/' => {
                let digits = [self.next()?, self.next()?, self.next()?];
                let direction = direction(digits).ok_or_else(|| self.damaged())?;
                self.pair.has_gap(ranges, &direction)
            }
            digit => {
                let variable = char::from(digit).to_digit(36).map(|digit| digit as usize);
                let variable = variable.filter(|v| *v < ranges.len()).ok_or_else(|| self.damaged())?;
                let [low, high] = ranges[variable];
                let middle = low.midpoint(high);
                for half in [[low, middle], [middle, high]] {
                    ranges[variable] = half;
                    self.verify_box(ranges, depth + 1)?;
                }
                ranges[variable] = [low, high];
                return Ok(());
            }
        };
        self.boxes += 1;
        let (a, b) = (&self.proof.link1, &self.proof.link2);
        let not_apart = || MatrixRejection::NotApart(a.clone(), b.clone(), self.at);
        is_proven.then_some(()).ok_or_else(not_apart)
    }
}

/// Tests of boxes of one pair.
struct PairProof<'p> {
    bodies: [&'p Body; 2],
    /// Distance (m) that the links must exceed.
    threshold: f64,
    path: MatrixPath<'p>,
}

impl PairProof<'_> {
    /// The state at the centre of a box, and half widths that reach both ends.
    fn centre(&self, ranges: &[[f64; 2]]) -> (MatrixState, Vec<f64>) {
        let values: Vec<f64> = ranges.iter().map(|[low, high]| low.midpoint(*high)).collect();
        let half = |([low, high], middle): (&[f64; 2], &f64)| (middle - low).greater(high - middle).next_up();
        let half_widths = ranges.iter().zip(&values).map(half).collect();
        (self.path.state(&values), half_widths)
    }

    /// True if the distance at the centre exceeds the motion in the box.
    fn is_apart(&self, ranges: &[[f64; 2]]) -> bool {
        let (state, half_widths) = self.centre(ranges);
        let motion = MatrixMotion { bodies: self.bodies, state: &state, half_widths: &half_widths };
        let target = motion.bound(MotionAlong::Any) + self.threshold;
        let [a, b] = self.bodies;
        // no bound holds for the motion of a plane
        let is_bounded = half_widths.is_empty() || self.bodies.iter().all(|body| body.planes().is_empty());
        is_bounded && target.is_finite() && SeparationTest::new(a, b, state.pose_ab(), target).prove()
    }

    /// True if the gap along a direction (frame of the first link) exceeds the motion along it.
    fn has_gap(&self, ranges: &[[f64; 2]], direction: &Vector) -> bool {
        let (state, half_widths) = self.centre(ranges);
        let along = MatrixPose::from(&state.poses[0]).rotation * direction;
        self.gap_exceeds_motion(&state, &half_widths, &along)
    }

    fn has_gap_along_an_axis(&self, ranges: &[[f64; 2]]) -> bool {
        let (state, half_widths) = self.centre(ranges);
        let both = state.axes.iter().flat_map(|axis| [axis.direction, -axis.direction]);
        both.into_iter().any(|along| self.gap_exceeds_motion(&state, &half_widths, &along))
    }

    /// `along` is a unit vector in the frame of the ancestor.
    fn gap_exceeds_motion(&self, state: &MatrixState, half_widths: &[f64], along: &Vector) -> bool {
        if self.bodies.iter().any(|body| body.root().is_none() || !body.planes().is_empty()) {
            return false;
        }
        let farthest = |side: usize, n: Vector| {
            let pose = MatrixPose::from(&state.poses[side]);
            n.dot(&pose.translation) + self.bodies[side].support(0, &pose.rotation.tr_mul(&n)).0
        };
        let gap = -farthest(1, -along) - farthest(0, *along) - self.threshold;
        let motion = MatrixMotion { bodies: self.bodies, state, half_widths };
        gap > 0.0 && gap > motion.bound(MotionAlong::Direction(along))
    }

    /// Rejects a link inside a closed mesh of the other: surfaces that are apart in all states leave it there.
    fn check_not_inside(&self, proof: &NeverProof) -> Result<(), MatrixRejection> {
        let [Some(a), Some(b)] = [&self.bodies[0].interior, &self.bodies[1].interior] else { return Ok(()) };
        let (state, _) = self.centre(&self.path.ranges);
        let inside = || MatrixRejection::Inside(proof.link1.clone(), proof.link2.clone());
        if a.overlap(b, &state.pose_ab()) { Err(inside()) } else { Ok(()) }
    }
}

/// The direction of three digits of 6 bits: the centre of a cell of an octahedron's net of 512 × 512 cells.
fn direction(digits: [u8; 3]) -> Option<Vector> {
    const CELLS: u32 = 512;
    let value = |digit: u8| {
        Some(match digit {
            b'0'..=b'9' => digit - b'0',
            b'A'..=b'Z' => digit - b'A' + 10,
            b'a'..=b'z' => digit - b'a' + 36,
            b'-' => 62,
            b'_' => 63,
            _ => return None,
        })
    };
    let [x, y, z] = digits.map(value);
    let cell = u32::from(x?) << 12 | u32::from(y?) << 6 | u32::from(z?);
    let coordinate = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(CELLS) - 1.0;
    let (x, y) = (coordinate(cell / CELLS), coordinate(cell % CELLS));
    let z = 1.0 - x.abs() - y.abs();
    // the lower half of the octahedron is folded outwards
    let fold = |c: f64, other: f64| if z < 0.0 { (1.0 - other.abs()).copysign(c) } else { c };
    Vector::new(fold(x, y), fold(y, x), z).try_normalize(0.0)
}
