//! Tests of bounding volumes in the root frame: distance bounds and enclosing boxes against exact distances.

use clearance_geometry::math::Vector;
use clearance_geometry::simd::dispatch;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::testing::{Random, levels};

use super::*;
use crate::capsules::LinkCapsule;
use crate::capsules::capsule_pairs::tests::{random_pair, true_distance};

/// The capsule that a chain with its first body at `origin` computes.
fn seen_from(origin: Vector, capsule: &LinkCapsule) -> RootCapsule {
    let middle = (capsule.a.coords + capsule.b.coords) * 0.5;
    let segment = Segment { centre: single(middle - origin), half: single((capsule.b - capsule.a) * 0.5) };
    RootCapsule::new((), segment, single(origin), round_up(capsule.radius), 0.0)
}

fn reach(capsule: &LinkCapsule) -> Reach {
    Reach { ends: [capsule.a.coords, capsule.b.coords], radius: capsule.radius }
}

fn holds(within: &AxisBox, point: &Point, farther: f64) -> bool {
    (0..3).all(|i| {
        f64::from(within.lo[i]) <= point[i] - farther && point[i] + farther <= f64::from(within.hi[i])
    })
}

#[test]
fn bounds_of_capsules_are_never_above_distances_and_boxes_hold_all() {
    let mut random = Random::new(31);
    let mut tight = 0;
    for _ in 0..20_000 {
        let (c, d) = random_pair(&mut random);
        let origin = random.vector(1.0) * [0.0, 1.0, 1e3][random.below(3)];
        let distance = true_distance(&c, &d);
        let (a, b) = (seen_from(origin, &c), RootCapsule::of_reach(&reach(&d), 0.0));
        for bound in [RootVolume::Capsule(a).lower_bound(&b), RootVolume::Capsule(b).lower_bound(&a)] {
            let bound = f64::from(bound);
            assert!(bound <= distance, "{bound} {distance} {c:?} {d:?} {origin:?}");
            tight += usize::from(bound > distance - 1e-4 * (1.0 + distance));
        }
        let within = a.axis_box(0.1);
        assert!([c.a, c.b].iter().all(|end| holds(&within, end, c.radius + 0.1)), "{within:?} {c:?}");
    }
    assert!(tight > 8_000, "only {tight} bounds are of use");
}

#[test]
fn bounds_of_boxes_are_never_above_distances_and_boxes_hold_all() {
    let mut random = Random::new(32);
    let mut tight = 0;
    for _ in 0..4_000 {
        let (c, _) = random_pair(&mut random);
        let mut edge = || [0.0, 1e-3, 0.1, 0.5][random.below(4)];
        let half = Vector::new(edge(), edge(), edge());
        let pose = MatrixPose::from(&clearance_geometry::math::Pose::from_parts(
            random.vector(2.0).into(),
            nalgebra::UnitQuaternion::from_scaled_axis(random.vector(3.0)),
        ));
        let volume = PieceVolume::Box { centre: Point::origin(), axes: nalgebra::one(), half_extents: half };
        let of_box = RootVolume::of_piece(&volume, &pose, 0.05);
        let bound = f64::from(of_box.lower_bound(&seen_from(random.vector(1.0), &c)));
        // reference: the nearest of many points of the axis, whose distance to a box is known
        let inverse = pose.inverse();
        let to_box = |s: f64| {
            let p = (&inverse * (c.a + (c.b - c.a) * s)).coords;
            (p.abs() - half).sup(&Vector::zeros()).norm()
        };
        let sampled = (0..=400).map(|i| to_box(f64::from(i) / 400.0)).fold(f64::INFINITY, f64::min);
        let distance = sampled - c.radius - 0.05;
        assert!(bound <= distance, "{bound} {distance} {c:?} {half:?}");
        tight += usize::from(bound > distance - 0.02 * (1.0 + distance));
        let within = of_box.axis_box();
        for i in 0..8 {
            let sign = |bit: u32| if i & bit == 0 { 1.0 } else { -1.0 };
            let corner = Point::new(sign(1) * half.x, sign(2) * half.y, sign(4) * half.z);
            assert!(holds(&within, &(&pose * corner), 0.0499), "{within:?}");
        }
    }
    assert!(tight > 3_000, "only {tight} bounds are of use");
}

/// Eight capsules in lanes.
#[inline(always)]
fn in_lanes<S: Simd>(simd: S, eight: &[RootCapsule; 8]) -> RootCapsule<f32x8<S>> {
    let lanes = |of: &dyn Fn(&RootCapsule) -> f32| f32x8::from_fn(simd, |lane| of(&eight[lane]));
    let of_segments =
        |of: &dyn Fn(&Segment<f32>) -> [f32; 3]| [0, 1, 2].map(|i| lanes(&|c| of(&c.segment)[i]));
    RootCapsule {
        segment: Segment { centre: of_segments(&|s| s.centre), half: of_segments(&|s| s.half) },
        over_square: lanes(&|c| c.over_square),
        radius: lanes(&|c| c.radius),
        size: lanes(&|c| c.size),
    }
}

#[test]
fn eight_are_near_what_each_is_near_alone() {
    let mut random = Random::new(33);
    let mut near = 0;
    for round in 0..2_000 {
        let capsules: [RootCapsule; 8] = std::array::from_fn(|_| {
            let mut c = random_pair(&mut random).0;
            if round % 50 == 0 && random.below(4) == 0 {
                c.a.x = f64::NAN;
            }
            seen_from(random.vector(1.0), &c)
        });
        let half = random.vector(0.3).abs();
        let volume = PieceVolume::Box {
            centre: Point::from(random.vector(1.0)),
            axes: nalgebra::one(),
            half_extents: half,
        };
        let of_box = RootVolume::of_piece(&volume, &MatrixPose::from(&random.pose(1.0)), 0.01);
        let of_capsule = RootVolume::Capsule(RootCapsule::of_reach(&reach(&random_pair(&mut random).1), 0.0));
        for volume in [of_box, of_capsule] {
            let limit = [0.0, 1e-9, 0.3][random.below(3)];
            let alone = |lane: usize| volume.lower_bound(&capsules[lane]) <= limit;
            let expected = (0..8).fold(0, |bits, lane| bits | u8::from(alone(lane)) << lane);
            for level in levels() {
                let (found, boxes) = dispatch!(level, simd => {
                    let eight = in_lanes(simd, &capsules);
                    (volume.near(simd, &eight, limit), eight.axis_boxes(limit))
                });
                assert_eq!(found, expected, "{level:?} {volume:?} {capsules:?}");
                for (lane, capsule) in capsules.iter().enumerate() {
                    assert_eq!(format!("{:?}", boxes.lane(lane)), format!("{:?}", capsule.axis_box(limit)));
                }
            }
            near += expected.count_ones();
        }
    }
    assert!((4_000..28_000).contains(&near), "{near}");
}

#[test]
fn bounds_of_eight_boxes_are_never_above_distances_and_tight() {
    let mut random = Random::new(34);
    let mut tight = 0;
    for _ in 0..1_000 {
        let mut boxes = EightBoxes::EMPTY;
        let corners: [[Point; 2]; 8] = std::array::from_fn(|lane| {
            let (centre, half) = (Point::from(random.vector(2.0)), random.vector(0.4).abs());
            let bounds = AxisBox::around([centre - half, centre + half], 0.0);
            boxes.set(lane, &bounds);
            [bounds.lo, bounds.hi].map(|c| Point::from(c.map(f64::from)))
        });
        let (c, _) = random_pair(&mut random);
        let capsule = seen_from(random.vector(1.0), &c);
        for level in levels() {
            let bounds = dispatch!(level, simd => capsule.bounds_of_boxes(simd, &boxes));
            for ([lo, hi], bound) in corners.iter().zip(bounds.map(f64::from)) {
                let to_box = |s: f64| {
                    let p = c.a + (c.b - c.a) * s;
                    (lo - p).sup(&(p - hi)).sup(&Vector::zeros()).norm()
                };
                let sampled = (0..=400).map(|i| to_box(f64::from(i) / 400.0)).fold(f64::INFINITY, f64::min);
                let distance = sampled - c.radius;
                assert!(bound <= distance, "{level:?} {bound} {distance} {c:?} {lo} {hi}");
                tight += usize::from(bound > distance - 0.02 * (1.0 + distance));
            }
        }
    }
    assert!(tight > 8_000, "only {tight} bounds are of use");
}

#[test]
fn nothing_is_beyond_a_box_without_end() {
    let far = Reach { ends: [Vector::new(9.0, 0.0, 0.0); 2], radius: 0.1 };
    let mut boxes = EightBoxes::EMPTY;
    boxes.set(3, &AxisBox::ALL);
    let capsule = RootCapsule::of_reach(&far, 0.0);
    let bounds =
        dispatch!(clearance_geometry::simd::Level::new(), simd => capsule.bounds_of_boxes(simd, &boxes));
    assert!(bounds[3].is_nan() || bounds[3] <= 0.0, "{bounds:?}");
}

#[test]
fn what_is_no_number_is_near_everything() {
    let nowhere = LinkCapsule { a: Point::new(f64::NAN, 0.0, 0.0), b: Point::origin(), radius: 0.1 };
    let far = LinkCapsule { a: Point::new(9.0, 0.0, 0.0), b: Point::new(9.0, 1.0, 0.0), radius: 0.1 };
    let endless = Reach { radius: f64::INFINITY, ..reach(&far) };
    let near = RootCapsule::of_reach(&reach(&far), 0.0);
    for other in [RootCapsule::of_reach(&reach(&nowhere), 0.0), RootCapsule::of_reach(&endless, 0.0)] {
        let bound = RootVolume::Capsule(other).lower_bound(&near);
        assert!(bound <= 0.0, "{bound}");
    }
}
