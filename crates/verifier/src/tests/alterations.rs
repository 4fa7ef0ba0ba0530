//! Test helper: alterations of a certificate, and the rejection that each must cause.

use clearance_motion::{Certificate, MovingObstacle, Proof};

use crate::Rejection;

/// Changes a certificate, and says what the rejection must look like once the digest fits again.
pub type Alteration = (&'static str, fn(&mut Certificate), fn(&Rejection) -> bool);

fn first_proof(c: &mut Certificate) -> &mut Proof {
    &mut c.segments[0].proofs[0]
}

pub const ALTERATIONS: &[Alteration] = &[
    ("format", |c| c.format.push('2'), |r| matches!(r, Rejection::Format(_))),
    ("robot", |c| c.robot.push('2'), |r| matches!(r, Rejection::Robot { .. })),
    ("model", |c| c.model.replace_range(..1, "x"), |r| matches!(r, Rejection::Model(_))),
    ("world", |c| c.world.replace_range(..1, "x"), |r| matches!(r, Rejection::World(_))),
    ("motion hash", |c| c.motion.replace_range(..1, "x"), |r| matches!(r, Rejection::MotionHash)),
    (
        "joints swapped",
        |c| {
            c.joints.swap(0, 1);
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Joints { place: 0, .. }),
    ),
    (
        "joint missing",
        |c| {
            c.joints.pop();
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Joints { place: 1, .. }),
    ),
    (
        "joint added",
        |c| {
            c.joints.push("j".into());
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Joints { place: 2, .. }),
    ),
    (
        "pair missing",
        |c| {
            c.pairs.remove(2);
        },
        |r| matches!(r, Rejection::MissingPair(..)),
    ),
    ("pair renamed", |c| c.pairs[1][0] = "x".into(), |r| matches!(r, Rejection::MissingPair(..))),
    ("pair added", |c| c.pairs.push(["x".into(), "y".into()]), |r| matches!(r, Rejection::UnknownPair(..))),
    (
        "pair twice",
        |c| {
            let p = c.pairs[0].clone();
            c.pairs.push(p);
        },
        |r| matches!(r, Rejection::PairOrder { place: 7, .. }),
    ),
    ("pairs swapped", |c| c.pairs.swap(1, 2), |r| matches!(r, Rejection::PairOrder { place: 1, .. })),
    ("names swapped", |c| c.pairs[1].swap(0, 1), |r| matches!(r, Rejection::MissingPair(..))),
    (
        "no segments",
        |c| {
            c.segments.clear();
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::NoSegments),
    ),
    (
        "segment missing",
        |c| {
            c.segments.remove(1);
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Jump { segment: 1, .. }),
    ),
    (
        "motion altered",
        |c| c.segments[0].motion.tube = vec![0.1, 0.1],
        |r| matches!(r, Rejection::MotionHash),
    ),
    ("ends apart", |c| shift_end(c, 1e-6), |r| matches!(r, Rejection::Jump { segment: 1, .. })),
    (
        "too long",
        |c| {
            c.segments[0].motion.from.as_mut().unwrap().push(0.0);
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Motion { segment: 0, .. }),
    ),
    (
        "no motion",
        |c| {
            c.segments[0].motion.from = None;
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Motion { segment: 0, .. }),
    ),
    ("no number", |c| shift_end(c, f64::NAN), |r| matches!(r, Rejection::Motion { segment: 0, .. })),
    ("too far", |c| shift_end(c, 1e9), |r| matches!(r, Rejection::Motion { segment: 0, .. })),
    (
        "obstacle unknown",
        |c| with_obstacle(c, |o| o.name = "x".into()),
        |r| matches!(r, Rejection::UnknownObstacle { segment: 0, .. }),
    ),
    (
        "obstacle faster",
        |c| with_obstacle(c, |o| o.linear[0] -= 0.1),
        |r| matches!(r, Rejection::ObstacleJump { segment: 1, .. } | Rejection::Bound { .. }),
    ),
    (
        "obstacle turned",
        |c| with_obstacle(c, |o| o.start = Some(([0.0; 3], [9.0; 4]))),
        |r| matches!(r, Rejection::Motion { segment: 0, .. }),
    ),
    (
        "obstacle twice",
        |c| {
            let o = c.segments[0].motion.obstacles[0].clone();
            c.segments[0].motion.obstacles.push(o);
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::ObstacleTwice { segment: 0, .. }),
    ),
    ("pair number", |c| first_proof(c).0 = 7, |r| matches!(r, Rejection::PairNumber { pair: 7, .. })),
    ("another pair", |c| first_proof(c).0 = 1, |r| matches!(r, Rejection::Gap { .. })),
    (
        "backwards",
        |c| {
            let p = first_proof(c);
            (p.1, p.2) = (p.2, p.1);
        },
        |r| matches!(r, Rejection::Interval { .. }),
    ),
    ("before the start", |c| first_proof(c).1 = -0.1, |r| matches!(r, Rejection::Interval { .. })),
    (
        "after the end",
        |c| c.segments[0].proofs.last_mut().unwrap().2 = 1.1,
        |r| matches!(r, Rejection::Interval { .. }),
    ),
    ("no interval", |c| first_proof(c).2 = f64::NAN, |r| matches!(r, Rejection::Interval { .. })),
    ("later start", |c| first_proof(c).1 += 1e-12, |r| matches!(r, Rejection::Gap { .. })),
    (
        "earlier end",
        |c| c.segments[0].proofs.last_mut().unwrap().2 -= 1e-12,
        |r| matches!(r, Rejection::Gap { .. }),
    ),
    (
        "proof missing",
        |c| {
            c.segments[1].proofs.remove(3);
        },
        |r| matches!(r, Rejection::Gap { segment: 1, .. }),
    ),
    ("no proofs", |c| c.segments[2].proofs.clear(), |r| matches!(r, Rejection::Gap { segment: 2, .. })),
    ("lower raised", |c| first_proof(c).3 += 1e-6, |r| matches!(r, Rejection::Near { proof: 0, .. })),
    ("lower endless", |c| first_proof(c).3 = f64::INFINITY, |r| matches!(r, Rejection::Lengths { .. })),
    ("lower no number", |c| first_proof(c).3 = f64::NAN, |r| matches!(r, Rejection::Lengths { .. })),
    (
        "lower is bound",
        |c| {
            let p = first_proof(c);
            p.3 = p.4;
        },
        |r| matches!(r, Rejection::Short { .. }),
    ),
    ("bound lowered", |c| first_proof(c).4 *= 0.9, |r| matches!(r, Rejection::Bound { proof: 0, .. })),
    ("bound zero", |c| first_proof(c).4 = 0.0, |r| matches!(r, Rejection::Bound { proof: 0, .. })),
    ("bound negative", |c| first_proof(c).4 = -1.0, |r| matches!(r, Rejection::Lengths { .. })),
    ("bound no number", |c| first_proof(c).4 = f64::NAN, |r| matches!(r, Rejection::Lengths { .. })),
    (
        "bound above lower",
        |c| {
            let p = first_proof(c);
            p.4 = p.3;
        },
        |r| matches!(r, Rejection::Short { .. }),
    ),
    (
        "wider tube",
        |c| {
            c.segments[2].motion.tube = vec![0.3, 0.3];
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::OpenJoin { segment: 2, .. }),
    ),
    (
        "tube negative",
        |c| {
            c.segments[2].motion.tube = vec![-0.3, 0.3];
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Motion { segment: 2, .. }),
    ),
    (
        "bent more",
        |c| {
            c.segments[1].motion.polynomials.as_mut().unwrap()[0][4] += 0.3;
            c.segments[1].motion.polynomials.as_mut().unwrap()[0][5] -= 0.3;
            c.motion = c.motion_hash();
        },
        |r| matches!(r, Rejection::Bound { .. } | Rejection::Near { .. }),
    ),
];

fn shift_end(c: &mut Certificate, by: f64) {
    c.segments[0].motion.to.as_mut().unwrap()[1] += by;
    c.motion = c.motion_hash();
}

fn with_obstacle(c: &mut Certificate, change: impl Fn(&mut MovingObstacle)) {
    change(&mut c.segments[0].motion.obstacles[0]);
    c.motion = c.motion_hash();
}
