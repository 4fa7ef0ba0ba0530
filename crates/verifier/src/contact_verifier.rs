//! Verifies a proof that two links collide in every state.
//!
//! A ball in a solid of each link: where the balls overlap, so do the solids. Let C and D be the regions around a common point of two
//! closed surfaces, in which their winding numbers do not change. If the connected surfaces had no common point, one of them would lie
//! in the region of the other: else, no surface would bound either region within the other, so that both would be one region with one
//! boundary, and the surfaces had common points. A point of each surface outside the hull of the other excludes this.

use std::collections::HashMap;

use clearance_geometry::Shape;
use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};

use super::always_certificate::{ContactEvidence, InnerBall};
use super::body::Body;
use super::inner_solid::{InnerSolid, point_body, point_of};
use super::matrix_motion::MotionAlong;
use super::matrix_path::MatrixPath;
use super::matrix_proof_text::{BoxFault, ProofText};
use super::matrix_separation::{ApartTest, BoxCentre};

/// Reason why the evidence of a contact is no proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ContactFault {
    /// Side of the link, and number of the ball.
    Ball(usize, usize),
    /// The tree of boxes, at a character.
    Box(BoxFault, usize),
}

/// Evidence of the contact of two links.
pub(super) struct ContactVerifier<'p> {
    pub path: MatrixPath<'p>,
    /// Shapes of both links.
    pub shapes: [&'p [(Pose, Shape)]; 2],
    /// Distance (m) within which the links collide.
    pub threshold: f64,
    pub meshes_are_solid: bool,
}

/// A verified ball.
struct VerifiedBall {
    centre: Point,
    radius: f64,
    body: Body,
    /// Number of its solid.
    solid: usize,
}

/// Largest number of balls of a link that the text of a proof can name.
const MOST_BALLS: usize = 1 << 18;

/// The verified balls of a link, with their solids.
struct VerifiedBalls {
    solids: Vec<InnerSolid>,
    /// By number of the shape and of the face: the place of the solid.
    places: HashMap<[usize; 2], usize>,
    balls: Vec<VerifiedBall>,
}

impl ContactVerifier<'_> {
    /// The number of boxes that are proven.
    pub fn verify(&self, evidence: &ContactEvidence) -> Result<u64, ContactFault> {
        let balls = [&evidence.balls1, &evidence.balls2];
        let [first, second] = [0, 1].map(|side| {
            VerifiedBalls::new(self.shapes[side], balls[side]).map_err(|ball| ContactFault::Ball(side, ball))
        });
        let balls = [first?, second?];
        let mut text = ProofText::new(&evidence.proof);
        let mut is_proven = |kind: u8, text: &mut ProofText, ranges: &[[f64; 2]]| match kind {
            b'*' => self.is_overlap(&balls, text, &BoxCentre::new(&self.path, ranges)),
            b'=' => Some(ranges.is_empty() && self.is_contact(evidence)),
            _ => None,
        };
        let verified = text.verify(&self.path.ranges, &mut is_proven);
        verified.map_err(|fault| ContactFault::Box(fault, text.at))
    }

    /// True if the balls that the text names overlap in the whole box, and neither solid lies inside the other.
    fn is_overlap(
        &self,
        balls: &[VerifiedBalls; 2],
        text: &mut ProofText,
        centre: &BoxCentre,
    ) -> Option<bool> {
        let [a, b] =
            [balls[0].balls.get(text.number()? as usize)?, balls[1].balls.get(text.number()? as usize)?];
        let sides = char::from(text.next()?).to_digit(4)?;
        let mut direction = |side: u32| {
            if sides & side == 0 { Some(None) } else { text.direction().map(Some) }
        };
        let [out_of_second, out_of_first] = [direction(1)?, direction(2)?];
        let distance = nalgebra::distance(&centre.point(0, &a.centre), &centre.point(1, &b.centre));
        let motion = centre.motion([&a.body, &b.body]).bound(MotionAlong::Any);
        let solids = [&balls[0].solids[a.solid], &balls[1].solids[b.solid]];
        let sticks_out = |side: usize, along: Option<Vector>| {
            !solids[1 - side].is_hollow(self.meshes_are_solid)
                || along.is_some_and(|n| sticks_out(solids, side, centre, &centre.direction(&n)))
        };
        let overlap = distance + motion < a.radius + b.radius;
        Some(overlap && sticks_out(0, out_of_second) && sticks_out(1, out_of_first))
    }

    /// True if the points of the evidence touch: the links have no joint between them.
    fn is_contact(&self, evidence: &ContactEvidence) -> bool {
        let Some([first, second]) = &evidence.contact else { return false };
        let (Some(p), Some(q)) = (point_of(self.shapes[0], first), point_of(self.shapes[1], second)) else {
            return false;
        };
        let centre = BoxCentre::new(&self.path, &[]);
        let (a, b) = (point_body(&p), point_body(&q));
        let rounding = centre.motion([&a, &b]).rounding();
        nalgebra::distance(&centre.point(0, &p), &centre.point(1, &q)) + rounding <= self.threshold
    }
}

/// True if a point of one solid stays outside the hull of the other in the whole box, along a direction in the frame of the ancestor.
fn sticks_out(solids: [&InnerSolid; 2], side: usize, centre: &BoxCentre, along: &Vector) -> bool {
    let pose = MatrixPose::from(&centre.state.poses[side]);
    let n = pose.rotation.tr_mul(along);
    let body = &solids[side].body;
    if body.root().is_none() {
        return false;
    }
    let element = body.support(0, &n).1;
    let point = point_body(&(element.extreme(&n) + n * element.ball()));
    // from the second body towards the first, or the reverse
    let (bodies, towards_second) =
        if side == 0 { ([&point, &solids[1].body], -along) } else { ([&solids[0].body, &point], *along) };
    ApartTest { bodies, threshold: 0.0 }.have_gap(centre, &towards_second)
}

impl VerifiedBalls {
    /// The number of the first ball that is in no solid is the error.
    fn new(shapes: &[(Pose, Shape)], balls: &[InnerBall]) -> Result<Self, usize> {
        let mut verified = Self { solids: Vec::new(), places: HashMap::new(), balls: Vec::new() };
        if balls.len() > MOST_BALLS {
            return Err(MOST_BALLS);
        }
        for (number, ball) in balls.iter().enumerate() {
            let place = verified.solid(shapes, ball).ok_or(number)?;
            if !verified.solids[place].contains(ball) {
                return Err(number);
            }
            let centre = Point::from(ball.centre);
            let body = point_body(&centre);
            verified.balls.push(VerifiedBall { centre, radius: ball.radius, body, solid: place });
        }
        Ok(verified)
    }

    /// The place of the solid that a ball names.
    fn solid(&mut self, shapes: &[(Pose, Shape)], ball: &InnerBall) -> Option<usize> {
        let name = [ball.shape, ball.face];
        if let Some(place) = self.places.get(&name) {
            return Some(*place);
        }
        self.places.insert(name, self.solids.len());
        self.solids.push(InnerSolid::new(shapes, ball)?);
        Some(self.solids.len() - 1)
    }
}
