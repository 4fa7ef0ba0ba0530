//! Tests of capsule pairs and capsule fits: bounds against true distances, and equal results on all SIMD levels.

#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]

use clearance_geometry::math::{Point, UnitVector, Vector};
use clearance_geometry::simd::{Level, dispatch, f64x8};
use clearance_geometry::testing::{Random, levels};

use super::*;
use crate::capsules::capsule_fit::fit_capsule;

/// Distance of two segments in f64: between interior points if that is the least, else from an end.
pub fn true_distance(c: &LinkCapsule, d: &LinkCapsule) -> f64 {
    let ends = [d.axis_distance(&c.a), d.axis_distance(&c.b), c.axis_distance(&d.a), c.axis_distance(&d.b)];
    let least = ends.into_iter().fold(f64::INFINITY, f64::min);
    let (u, v, w) = (c.b - c.a, d.b - d.a, d.a - c.a);
    let (uu, vv, uv, uw, vw) = (u.dot(&u), v.dot(&v), u.dot(&v), u.dot(&w), v.dot(&w));
    let determinant = uu * vv - uv * uv;
    let (s, t) = ((uw * vv - uv * vw) / determinant, (uv * uw - uu * vw) / determinant);
    let inside = |x: f64| (0.0..=1.0).contains(&x);
    let axes = if inside(s) && inside(t) { least.min((w + v * t - u * s).norm()) } else { least };
    axes - c.radius - d.radius
}

/// Two capsules that may be parallel, degenerate, crossing, touching or far away.
pub fn random_pair(random: &mut Random) -> (LinkCapsule, LinkCapsule) {
    let size = |random: &mut Random| [0.0, 1e-6, 0.05, 0.3, 1.0][random.below(5)];
    let spread = [0.0, 1e-3, 0.3, 1.0, 30.0][random.below(5)];
    let (middle_c, middle_d) = (random.vector(spread), random.vector(spread));
    let u = random.vector(1.0) * size(random);
    let v = match random.below(5) {
        0 => u * random.within(2.0),
        1 => u * random.within(2.0) + random.vector(1e-4) * u.norm(),
        2 => u * random.within(2.0) + random.vector(1e-7) * u.norm(),
        _ => random.vector(1.0) * size(random),
    };
    let middle_d = match random.below(6) {
        0 => middle_c + u * random.within(1.0) + v * random.within(1.0),
        1 => middle_c + u * random.within(3.0),
        2 => middle_c + u.cross(&v) * random.within(2.0),
        _ => middle_d,
    };
    let capsule = |random: &mut Random, middle: Vector, half: Vector| LinkCapsule {
        a: Point::from(middle - half),
        b: Point::from(middle + half),
        radius: [0.0, 0.05, 0.1][random.below(3)],
    };
    (capsule(random, middle_c, u), capsule(random, middle_d, v))
}

/// Results of all query functions on one state: bounds, and nearness to `margin`.
struct Results {
    bounds: Vec<f32>,
    near: Vec<bool>,
}

#[inline(always)]
fn query_eight<S: Simd>(
    simd: S,
    pairs: &CapsulePairs,
    frames: &[Vec<Frame<f64>>],
    margin: f64,
) -> Vec<Results> {
    let lanes = |of: &dyn Fn(usize) -> f64| f64x8::from_fn(simd, of);
    let frames: Vec<Frame<f64x8<S>>> = (0..frames[0].len())
        .map(|body| Frame {
            r: std::array::from_fn(|c| std::array::from_fn(|i| lanes(&|k| frames[k][body].r[c][i]))),
            t: std::array::from_fn(|i| lanes(&|k| frames[k][body].t[i])),
        })
        .collect();
    let zero = [f32x8::splat(simd, 0.0); 3];
    let mut segments = vec![Segment { centre: zero, half: zero }; pairs.capsule_count()];
    let (mut masks, mut bounds) = (vec![0; pairs.pair_count()], vec![[0.0; 8]; pairs.pair_count()]);
    pairs.place(&frames, &mut segments);
    pairs.near(simd, &segments, |_| round_up(margin), &mut masks);
    pairs.lower_bounds(simd, &segments, &mut bounds);
    (0..8)
        .map(|k| Results {
            bounds: bounds.iter().map(|b| b[k]).collect(),
            near: masks.iter().map(|m| m >> k & 1 == 1).collect(),
        })
        .collect()
}

#[inline(always)]
fn query_one<S: Simd>(simd: S, pairs: &CapsulePairs, frames: &[Frame<f64>], margin: f64) -> Results {
    let mut segments = vec![PlacedSegment::default(); pairs.capsule_count()];
    let (mut masks, mut bounds) = (vec![0; pairs.group_count()], vec![[0.0; 8]; pairs.group_count()]);
    let placed: Vec<_> = frames.iter().map(PlacedFrame::from).collect();
    pairs.place_one(simd, &placed, &mut segments);
    pairs.near_one(simd, &segments, |_| [round_up(margin); 8], &mut masks);
    pairs.lower_bounds_one(simd, &segments, &mut bounds);
    let count = pairs.pair_count();
    assert!((count..8 * masks.len()).all(|i| masks[i / 8] >> (i % 8) & 1 == 0));
    Results {
        bounds: bounds.into_flattened()[..count].to_vec(),
        near: (0..count).map(|i| masks[i / 8] >> (i % 8) & 1 == 1).collect(),
    }
}

/// Compares the results of all SIMD levels, in eight states and one by one.
fn query(pairs: &CapsulePairs, frames: &[Vec<Frame<f64>>], margin: f64, levels: &[Level]) -> Vec<Results> {
    let bits = |results: &Results| results.bounds.iter().map(|b| b.to_bits()).collect::<Vec<_>>();
    let mut all =
        levels.iter().map(|&level| dispatch!(level, simd => query_eight(simd, pairs, frames, margin)));
    let first = all.next().unwrap();
    for (level, other) in levels[1..].iter().zip(all) {
        for (a, b) in first.iter().zip(&other) {
            assert!(bits(a) == bits(b) && a.near == b.near, "{level:?}");
        }
    }
    for &level in levels {
        for (state, a) in frames.iter().zip(&first) {
            let b = dispatch!(level, simd => query_one(simd, pairs, state, margin));
            assert!(bits(a) == bits(&b) && a.near == b.near, "{level:?}");
        }
    }
    first
}

/// Random capsules on two bodies in random states: capsules 2i and 2i + 1 make a pair.
fn check(random: &mut Random, far: f64, levels: &[Level]) -> f64 {
    let count = 1 + random.below(20);
    let capsules: Vec<LinkCapsule> =
        (0..count).map(|_| random_pair(random)).flat_map(|(c, d)| [c, d]).collect();
    let robot_bodies: Vec<_> = capsules.iter().enumerate().map(|(i, &c)| (i % 2, c)).collect();
    let list: Vec<_> = (0..count).map(|i| (2 * i, 2 * i + 1)).collect();
    let pairs = CapsulePairs::new(&robot_bodies, &list);
    let still = random.below(2) == 0;
    let frames: Vec<Vec<_>> = (0..8)
        .map(|_| {
            let pose = random.pose(far);
            let other = if still { pose } else { pose * random.pose(1.0) };
            vec![Frame::from(&pose), Frame::from(&other)]
        })
        .collect();
    let margin = [0.0, 0.01, 0.2][random.below(3)];
    let mut loosest = 0.0_f64;
    for (state, results) in frames.iter().zip(query(&pairs, &frames, margin, levels)) {
        let seen: Vec<_> = robot_bodies.iter().map(|(body, c)| c.seen_through(&state[*body])).collect();
        let extent =
            seen.iter().map(|c| (c.a - seen[0].a).amax().max((c.b - seen[0].a).amax())).fold(1.0, f64::max);
        for (i, pair) in seen.chunks_exact(2).enumerate() {
            let distance = true_distance(&pair[0], &pair[1]);
            let bound = f64::from(results.bounds[i]);
            // far from the origin the poses themselves have rounding errors
            assert!(bound <= distance + 1e-15 * far, "{bound} > {distance}: {pair:?}");
            assert!(results.near[i] || distance > margin, "{distance} is near: {pair:?}");
            // a mask is no stricter than the bound
            assert!(!results.near[i] || bound <= margin + 1e-5 * extent, "{bound} is not near: {pair:?}");
            if distance + pair[0].radius + pair[1].radius > 0.05 {
                loosest = loosest.max((distance - bound) / extent);
            }
        }
    }
    loosest
}

#[test]
fn bounds_never_exceed_the_distance_and_are_tight() {
    let (mut random, levels) = (Random::new(20), [Level::new()]);
    let mut loosest: Vec<f64> = (0..20_000).map(|_| check(&mut random, 1.0, &levels)).collect();
    loosest.sort_by(f64::total_cmp);
    let at = |part: f64| loosest[((loosest.len() - 1) as f64 * part) as usize];
    println!("loosest of a robot: median {:e}, 99 % {:e}, worst {:e}", at(0.5), at(0.99), at(1.0));
    assert!(at(0.5) < 1e-5 && at(1.0) < 1e-3);
}

#[test]
fn levels_and_ways_agree_to_the_bit() {
    let mut random = Random::new(21);
    for _ in 0..1000 {
        check(&mut random, 1.0, &levels());
    }
}

#[test]
fn robots_far_from_the_origin_lose_nothing() {
    let mut random = Random::new(22);
    for _ in 0..1000 {
        assert!(check(&mut random, 1e6, &[Level::new()]) < 1e-3);
    }
}

#[test]
fn no_number_is_near() {
    let capsule = LinkCapsule { a: Point::origin(), b: Point::new(1.0, 0.0, 0.0), radius: 0.1 };
    let pairs = CapsulePairs::new(&[(0, capsule), (1, capsule)], &[(0, 1)]);
    for t in [f64::NAN, f64::INFINITY, 1e30] {
        let frames = vec![vec![Frame::IDENTITY, Frame { t: [t, 9.0, 9.0], ..Frame::IDENTITY }]; 8];
        for level in levels() {
            let eight = dispatch!(level, simd => query_eight(simd, &pairs, &frames, 0.0));
            let one = dispatch!(level, simd => query_one(simd, &pairs, &frames[0], 0.0));
            if t.is_nan() {
                assert!(eight[0].near[0] && one.near[0], "{level:?}");
            }
            for bound in [eight[0].bounds[0], one.bounds[0]] {
                assert!(bound.is_nan() || t.is_nan() || f64::from(bound) <= t, "{level:?}: {bound}");
            }
        }
    }
}

#[test]
fn fitted_capsules_hold_their_points() {
    let mut random = Random::new(23);
    for _ in 0..2000 {
        let (flatten, centre, turn) = (random.vector(1.0), random.vector(5.0), random.rotation());
        let flatten = flatten.map(|c| if c.abs() < 0.2 { 0.0 } else { c });
        let points: Vec<Point> = (0..=random.below(60))
            .map(|_| Point::from(centre + turn * random.vector(1.0).component_mul(&flatten)))
            .collect();
        let capsule = fit_capsule(&points).unwrap();
        assert!(points.iter().all(|p| capsule.axis_distance(p) <= capsule.radius), "{points:?}");
    }
    assert_eq!(fit_capsule(&[]), None);
}

#[test]
fn fitted_capsules_are_tight() {
    let mut random = Random::new(24);
    for _ in 0..100 {
        let (direction, centre) = (random.direction(), random.vector(1.0));
        let (half, radius) = (0.1 + random.within(0.5).abs(), 0.05 + random.within(0.1).abs());
        let points: Vec<Point> = (0..3000)
            .map(|_| {
                let along = random.within(half);
                let out = UnitVector::new_normalize(random.vector(1.0));
                let end = if out.dot(&direction) > 0.0 { half } else { -half };
                let at = if random.below(3) == 0 { end } else { along };
                let out = if at == end { out.into_inner() } else { direction.cross(&out).normalize() };
                Point::from(centre + direction.into_inner() * at + out * radius)
            })
            .collect();
        let capsule = fit_capsule(&points).unwrap();
        let volume = |length: f64, radius: f64| radius * radius * (length + radius * (4.0 / 3.0));
        let (fitted, made) =
            (volume((capsule.b - capsule.a).norm(), capsule.radius), volume(2.0 * half, radius));
        assert!(fitted < 1.03 * made, "{fitted} {made}");
    }
}
