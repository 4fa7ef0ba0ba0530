//! Tests of compiled kinematics: comparison with composed poses, eight states in lanes, and reachable regions.

#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]

use clearance_geometry::math::Rotation;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, dispatch, f64x8};
use clearance_geometry::testing::{Random, levels};

use super::*;

/// A random tree of `links` links, the number of its positions, and which links are needed.
pub(super) fn random_tree(random: &mut Random, links: usize) -> (Vec<ChainJoint>, usize, Vec<bool>) {
    let mut count = 0;
    let joints = (1..links)
        .map(|child| {
            let parent = if random.below(4) == 0 { random.below(child) } else { child - 1 };
            let motion = random_motion(random, &mut count);
            ChainJoint { parent, child, pose_pj: random.pose(1.0), motion }
        })
        .collect();
    (joints, count, (0..links).map(|_| random.below(3) > 0).collect())
}

fn random_motion(random: &mut Random, count: &mut usize) -> Motion {
    let known = *count;
    let mut take = |n| std::mem::replace(count, known + n);
    let axis = random.direction();
    match random.below(12) {
        0 | 1 => Motion::Fixed,
        2 => {
            let (multiplier, offset) = (random.within(2.0), random.within(2.0));
            Motion::Prismatic(axis, Source { index: take(1), multiplier, offset })
        }
        3 => Motion::Floating(take(7)),
        4 => Motion::Planar(random.rotation().to_rotation_matrix().into_inner(), take(3)),
        5 if known > 0 => Motion::Revolute(
            axis,
            Source { index: random.below(known), multiplier: random.within(2.0), offset: random.within(2.0) },
        ),
        _ => Motion::Revolute(axis, free(take(1))),
    }
}

fn free(index: usize) -> Source {
    Source { index, multiplier: 1.0, offset: 0.0 }
}

/// Random positions; those of floating joints have quaternions of length one.
pub(super) fn random_positions(random: &mut Random, joints: &[ChainJoint], count: usize) -> Vec<f64> {
    let mut q: Vec<f64> = (0..count).map(|_| random.within(4.0)).collect();
    for joint in joints {
        if let Motion::Floating(first) = joint.motion {
            let turn = random.rotation();
            q[first + 3..first + 7].copy_from_slice(turn.coords.as_slice());
        }
    }
    q
}

/// Poses of all links, by a simple reference computation.
fn reference(joints: &[ChainJoint], links: usize, q: &[f64]) -> Vec<Pose> {
    let mut poses = vec![Pose::identity(); links];
    for joint in joints {
        let value = |s: Source| s.multiplier * q[s.index] + s.offset;
        let motion = match joint.motion {
            Motion::Fixed => Pose::identity(),
            Motion::Revolute(axis, s) => {
                Pose::from_parts(Vector::zeros().into(), Rotation::from_axis_angle(&axis, value(s)))
            }
            Motion::Prismatic(axis, s) => {
                Pose::from_parts((axis.into_inner() * value(s)).into(), Rotation::identity())
            }
            Motion::Planar(plane, i) => {
                let shift = plane * Vector::new(q[i], q[i + 1], 0.0);
                let normal = UnitVector::new_normalize(plane.column(2).into_owned());
                Pose::from_parts(shift.into(), Rotation::from_axis_angle(&normal, q[i + 2]))
            }
            Motion::Floating(i) => Pose::from_parts(
                Vector::new(q[i], q[i + 1], q[i + 2]).into(),
                Rotation::from_quaternion(nalgebra::Quaternion::new(q[i + 6], q[i + 3], q[i + 4], q[i + 5])),
            ),
        };
        poses[joint.child] = poses[joint.parent] * joint.pose_pj * motion;
    }
    poses
}

pub(super) fn frames(chain: &Chain, q: &[f64]) -> Vec<Frame<f64>> {
    let mut frames = vec![Frame::IDENTITY; chain.body_count()];
    chain.frames((), |i| q[i], &mut frames);
    frames
}

fn largest_difference(a: &Frame<f64>, b: &Frame<f64>) -> f64 {
    let all = |f: &Frame<f64>| f.r.into_iter().flatten().chain(f.t).collect::<Vec<_>>();
    all(a).iter().zip(all(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn equals_the_straightforward_way() {
    let mut random = Random::new(7);
    let mut worst = 0.0_f64;
    for round in 0..20_000 {
        let links = 1 + random.below(if round % 100 == 0 { 100 } else { 12 });
        let (joints, count, needed) = random_tree(&mut random, links);
        let chain = Chain::compile(0, &joints, &needed);
        let q = random_positions(&mut random, &joints, count);
        let (frames, poses) = (frames(&chain, &q), reference(&joints, links, &q));
        for (link, pose) in poses.iter().enumerate() {
            let frame = chain.link_frame(link, &frames);
            assert_eq!(frame.is_some(), needed[link]);
            let Some(frame) = frame else { continue };
            worst = worst.max(largest_difference(&frame, &Frame::from(pose)) / links as f64);
        }
    }
    println!("worst difference {worst:e} per link");
    assert!(worst < 2e-14, "{worst:e}");
}

#[inline(always)]
fn in_lanes<S: Simd>(simd: S, chain: &Chain, states: &[Vec<f64>]) -> Vec<Vec<Frame<f64>>> {
    let mut frames = vec![Frame::splat(simd, &Frame::IDENTITY); chain.body_count()];
    chain.frames(simd, |i| f64x8::from_fn(simd, |lane| states[lane][i]), &mut frames);
    let lane =
        |f: &Frame<f64x8<S>>, i: usize| Frame { r: f.r.map(|c| c.map(|v| v[i])), t: f.t.map(|v| v[i]) };
    (0..8).map(|i| frames.iter().map(|f| lane(f, i)).collect()).collect()
}

#[test]
fn eight_states_equal_each_alone_to_the_bit() {
    let mut random = Random::new(8);
    for _ in 0..500 {
        let (joints, count, needed) = random_tree(&mut random, 15);
        let chain = Chain::compile(0, &joints, &needed);
        let states: Vec<_> = (0..8).map(|_| random_positions(&mut random, &joints, count)).collect();
        for level in levels() {
            let lanes = dispatch!(level, simd => in_lanes(simd, &chain, &states));
            for (state, lane) in states.iter().zip(lanes) {
                // debug text shows all bits, and distinguishes 0 from -0
                let text = format!("{:?}", frames(&chain, state));
                assert_eq!(text, format!("{lane:?}"), "{level:?}");
                let mut alone = vec![PlacedFrame::IDENTITY; chain.body_count()];
                dispatch!(level, simd => chain.frames_of_one(simd, state, &mut alone, |_, _| {}));
                let alone: Vec<_> = alone.iter().map(PlacedFrame::frame).collect();
                assert_eq!(text, format!("{alone:?}"), "{level:?}");
            }
        }
    }
}

#[test]
fn deep_chains_stay_orthogonal() {
    let mut random = Random::new(9);
    for same in [true, false] {
        let pose = random.pose(0.1);
        let mut joint = |parent| ChainJoint {
            parent,
            child: parent + 1,
            pose_pj: if same { pose } else { random.pose(0.1) },
            motion: Motion::Revolute(if same { Vector::z_axis() } else { random.direction() }, free(0)),
        };
        let joints: Vec<_> = (0..10_000).map(&mut joint).collect();
        let chain = Chain::compile(0, &joints, &vec![true; joints.len() + 1]);
        let q = [1.1];
        let (frames, poses) = (frames(&chain, &q), reference(&joints, joints.len() + 1, &q));
        let last = chain.link_frame(10_000, &frames).unwrap();
        let r = RotationMatrix::from_columns(&last.r.map(Vector::from));
        let error = (r.transpose() * r - RotationMatrix::identity()).abs().max();
        let difference = largest_difference(&last, &Frame::from(&poses[10_000]));
        println!("orthogonal to {error:e}, differs by {difference:e}");
        assert!(error < 1e-11, "{error:e}");
        assert!(difference < 1e-8, "{difference:e}");
    }
}

#[test]
fn fixed_and_unneeded_links_cost_nothing() {
    let motions = [Motion::Revolute(Vector::y_axis(), free(0)), Motion::Fixed, Motion::Fixed];
    let joints: Vec<_> = (motions.iter().zip(0..))
        .map(|(&motion, parent)| ChainJoint { parent, child: parent + 1, pose_pj: Pose::identity(), motion })
        .collect();
    let chain = |needed| Chain::compile(0, &joints, needed).body_count();
    assert_eq!(chain(&[true, true, true, true]), 2);
    assert_eq!(chain(&[false, false, false, true]), 2);
    assert_eq!(chain(&[true, false, false, false]), 1);
}

#[test]
fn a_chain_of_turning_joints_is_all_twists() {
    let mut random = Random::new(10);
    let joints: Vec<_> = (0..7)
        .map(|parent| ChainJoint {
            parent,
            child: parent + 1,
            pose_pj: random.pose(1.0),
            motion: Motion::Revolute(random.direction(), free(parent)),
        })
        .collect();
    let chain = Chain::compile(0, &joints, &[true; 8]);
    let twists = chain.bodies.iter().filter(|b| matches!(b.step, Step::Turn(Turn::Twist { .. }, _))).count();
    assert_eq!(twists, 6);
}

#[test]
fn bodies_never_leave_their_territories() {
    let (mut random, mut bounded, mut tight) = (Random::new(12), 0, 0);
    for _ in 0..300 {
        let (joints, count, needed) = random_tree(&mut random, 6);
        let chain = Chain::compile(0, &joints, &needed);
        let territories = chain.territories(|_| Some(-4.0..=4.0));
        let mut farthest = vec![0.0_f64; chain.body_count()];
        for _ in 0..200 {
            let frames = frames(&chain, &random_positions(&mut random, &joints, count));
            for ((frame, territory), farthest) in frames.iter().zip(&territories).zip(&mut farthest) {
                *farthest = farthest.max((Vector::from(frame.t) - territory.centre).norm());
            }
        }
        for (farthest, ReachableRegion { radius, .. }) in farthest.iter().zip(&territories) {
            assert!(*farthest <= radius + 1e-12, "{farthest} {radius}");
            bounded += usize::from(radius.is_finite() && *radius > 0.0);
            tight += usize::from(*farthest > 0.9 * radius && *radius > 0.0);
        }
    }
    assert!(bounded > 200 && tight > 150, "of {bounded} bodies only {tight} come near the edge");
    let slides = Chain::compile(
        0,
        &[ChainJoint {
            parent: 0,
            child: 1,
            pose_pj: Pose::identity(),
            motion: Motion::Prismatic(Vector::z_axis(), free(0)),
        }],
        &[true; 2],
    );
    assert!(slides.territories(|_| None)[1].radius.is_infinite());
    assert_eq!(slides.sliding_positions().collect::<Vec<_>>(), [0]);
}

/// All paths of a serial chain are stored as one, and the stored paths of a comb are no longer than its teeth are deep.
#[test]
fn ways_of_long_chains_are_stored_once() {
    let chain_of = |parents: &[usize]| {
        let joint = |(child, parent): (usize, &usize)| ChainJoint {
            parent: *parent,
            child: child + 1,
            pose_pj: Pose::translation(0.1, 0.0, 0.0),
            motion: Motion::Revolute(Vector::z_axis(), free(child)),
        };
        let joints: Vec<_> = parents.iter().enumerate().map(joint).collect();
        Chain::compile(0, &joints, &vec![true; parents.len() + 1])
    };
    let parents: Vec<usize> = (0..2000).collect();
    assert_eq!(chain_of(&parents).paths_to_root().stored(), 2001);
    assert_eq!(chain_of(&[0; 100]).paths_to_root().stored(), 200);
    assert_eq!(chain_of(&[]).paths_to_root().stored(), 1);
}
