//! Contacts of a placed robot with obstacles, in lanes: eight parts in one state, or one part in eight states.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::simd::{LANES, Simd, dispatch, f32x8};
use clearance_proximity::Scratch;
use clearance_robot::{Chain, Frame};

use super::checked_pairs::CheckedPairs;
use super::inside_search::{InsideSearch, SearchedBodies};
use crate::capsules::{RootCapsule, round_up};
use crate::robot::PlacedSegments;
use crate::world::{BodiesInReach, BodyOrder, BroadPhaseScratch, EightQuery, PartQuery, WorldPair};

/// Scratch memory of searches among obstacles.
#[derive(Clone, Debug, Default)]
pub struct ObstacleScratch {
    pub broad_phase: BroadPhaseScratch,
    order: BodyOrder,
}

/// Search for contacts of robot parts with obstacles.
pub struct ObstacleContacts<'w> {
    pub pairs: &'w CheckedPairs,
    pub obstacles: &'w mut ObstacleScratch,
    pub scratch: &'w mut Scratch,
}

/// States of a batch that are searched, as bits of eight.
#[derive(Clone, Copy, Debug)]
pub struct StatesInLanes {
    pub among: u8,
    /// True if all states are expected; false if at least one is not.
    pub are_expected: bool,
}

impl ObstacleContacts<'_> {
    /// True if a part touches an obstacle in a state, which may be expected or not.
    #[inline(always)]
    pub fn any_in_state<S: Simd>(
        &mut self,
        simd: S,
        segments: PlacedSegments,
        is_expected: bool,
        frame: &impl Fn(usize) -> Frame<f64>,
    ) -> bool {
        let Self { pairs, obstacles: ObstacleScratch { broad_phase, order }, scratch } = self;
        let world = pairs.world();
        if world.is_empty() {
            return false;
        }
        let in_reach = bodies_in_reach(pairs, broad_phase, scratch);
        if in_reach.fixed_contact {
            return true;
        }
        order.update(world.revision(), in_reach);
        let parts = if is_expected { order.parts() } else { &in_reach.moving };
        for first in (0..parts.len()).step_by(LANES) {
            let eight = &parts[first..parts.len().min(first + LANES)];
            let capsules = pairs.self_pairs().padded_capsules_of_eight(simd, eight, segments);
            let checks = |place, among: u8| {
                let (mut checked, mut left) = (0, among);
                while left != 0 {
                    let lane = left.trailing_zeros() as usize;
                    left &= left - 1;
                    checked |= u8::from(world.pair_list().checks(eight[lane], place)) << lane;
                }
                checked
            };
            let among = u8::MAX >> (LANES - eight.len());
            let query = EightQuery {
                capsules: &capsules,
                among,
                are_expected: is_expected,
                limit: round_up(CONTACT_DISTANCE),
                checks,
            };
            world.find_near_eight(simd, query, broad_phase, &mut scratch.work);
            let mut left = broad_phase.lanes_near();
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                if touches_near(pairs, PartInLane { part: eight[lane], lane }, frame, broad_phase, scratch) {
                    if is_expected {
                        order.step_forward(first + lane);
                    }
                    return true;
                }
            }
        }
        InsideSearch { pairs, bodies: SearchedBodies::Moving, scratch }.in_state(simd, frame, |_| true)
    }

    /// Bit mask of the states in which a part touches an obstacle.
    #[inline(always)]
    pub fn states_in_contact<S: Simd>(
        &mut self,
        simd: S,
        StatesInLanes { among, are_expected }: StatesInLanes,
        capsules: impl Fn(usize) -> RootCapsule<f32x8<S>>,
        frame: &impl Fn(usize, usize) -> Frame<f64>,
    ) -> u8 {
        let Self { pairs, obstacles: ObstacleScratch { broad_phase, order }, scratch } = self;
        let world = pairs.world();
        if world.is_empty() {
            return 0;
        }
        let in_reach = bodies_in_reach(pairs, broad_phase, scratch);
        if in_reach.fixed_contact {
            return among;
        }
        order.update(world.revision(), in_reach);
        let mut hit = 0;
        let parts = if are_expected { order.parts().len() } else { in_reach.moving.len() };
        for rank in 0..parts {
            let left = among & !hit;
            if left == 0 {
                break;
            }
            let part = if are_expected { order.parts()[rank] } else { in_reach.moving[rank] };
            let checks = |place, among| if world.pair_list().checks(part, place) { among } else { 0 };
            let query = EightQuery {
                capsules: &capsules(part),
                among: left,
                are_expected,
                limit: round_up(CONTACT_DISTANCE),
                checks,
            };
            world.find_near_eight(simd, query, broad_phase, &mut scratch.work);
            let (mut found, mut left) = (0, broad_phase.lanes_near());
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let in_lane = PartInLane { part, lane };
                let touches = touches_near(pairs, in_lane, &|body| frame(body, lane), broad_phase, scratch);
                found |= u8::from(touches) << lane;
            }
            hit |= found;
            if found != 0 && are_expected {
                order.step_forward(rank);
            }
        }
        let mut inside = 0;
        let mut search = InsideSearch { pairs, bodies: SearchedBodies::Moving, scratch };
        search.in_eight_states(simd, among & !hit, frame, |_, lane| {
            inside |= 1 << lane;
            false
        });
        hit | inside
    }
}

/// A part in its lane of eight.
#[derive(Clone, Copy)]
struct PartInLane {
    part: usize,
    lane: usize,
}

/// True if a part touches one of the pieces found near it.
#[inline(always)]
fn touches_near(
    pairs: &CheckedPairs,
    PartInLane { part, lane }: PartInLane,
    frame: &impl Fn(usize) -> Frame<f64>,
    broad_phase: &mut BroadPhaseScratch,
    scratch: &mut Scratch,
) -> bool {
    let BroadPhaseScratch { near_eight, pieces, .. } = broad_phase;
    near_eight.chunk_by(|a, b| a.place == b.place).any(|of_one| {
        pieces.clear();
        pieces.extend(of_one.iter().filter(|near| near.lanes & (1 << lane) != 0).map(|near| near.piece));
        let index = pairs.world().number(WorldPair { part, place: of_one[0].place as usize });
        !pieces.is_empty() && pairs.pair_with(index, frame).pieces_touch(pieces, scratch)
    })
}

/// Parts that are to be tested against obstacles; computed at the first call.
#[inline(always)]
fn bodies_in_reach<'p>(
    pairs: &'p CheckedPairs,
    broad_phase: &mut BroadPhaseScratch,
    scratch: &mut Scratch,
) -> &'p BodiesInReach {
    let known = &pairs.state_independent().bodies_in_reach;
    loop {
        if let Some(known) = known.get() {
            return known;
        }
        // two threads may both compute it, with the same result; neither waits for the other
        let _ = known.set(find_bodies_in_reach(pairs, broad_phase, scratch));
    }
}

#[cold]
fn find_bodies_in_reach(
    pairs: &CheckedPairs,
    broad_phase: &mut BroadPhaseScratch,
    scratch: &mut Scratch,
) -> BodiesInReach {
    let (robot, world) = (pairs.robot(), pairs.world());
    let mut fixed = robot.parts_on(|body| body == Chain::ROOT);
    let fixed_contact = fixed.any(|part| fixed_part_touches(pairs, part, broad_phase, scratch))
        || dispatch!(scratch.level(), simd => {
            let mut search = InsideSearch { pairs, bodies: SearchedBodies::Fixed, scratch };
            search.in_state(simd, &|_| Frame::IDENTITY, |_| true)
        });
    let moving: Vec<usize> = robot.parts_on(|body| body != Chain::ROOT).rev().collect();
    let comes_near = |part: &usize| {
        let Some(ball) = world.reachable().ball_of_part(*part) else { return true };
        world.anything_near(PartQuery::new(*part, &ball, CONTACT_DISTANCE), broad_phase, scratch)
    };
    let parts = moving.iter().copied().filter(comes_near).collect();
    BodiesInReach { fixed_contact, moving, parts }
}

/// True if a part that no joint moves touches an obstacle.
fn fixed_part_touches(
    pairs: &CheckedPairs,
    part: usize,
    broad_phase: &mut BroadPhaseScratch,
    scratch: &mut Scratch,
) -> bool {
    let capsule = pairs.robot()[part].padded_capsule(&Frame::IDENTITY);
    let query = PartQuery::new(part, &capsule, CONTACT_DISTANCE);
    let (level, work) = (scratch.level(), &mut scratch.work);
    dispatch!(level, simd => pairs.world().find_near(simd, query, broad_phase, work));
    let BroadPhaseScratch { near, pieces, .. } = broad_phase;
    near.chunk_by(|a, b| a.place == b.place).any(|of_one| {
        pieces.clear();
        pieces.extend(of_one.iter().map(|near| near.piece));
        let index = pairs.world().number(WorldPair { part, place: of_one[0].place as usize });
        pairs.pair_with(index, |_| Frame::IDENTITY).pieces_touch(pieces, scratch)
    })
}

#[cfg(test)]
mod tests {
    use crate::{CollisionChecker, Question};
    use clearance_geometry::math::Pose;
    use clearance_geometry::testing::Random;
    use clearance_geometry::{Primitive, Shape};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::AllowedCollisionMatrix;
    use clearance_scene::Settings;
    use clearance_scene::{Obstacle, World};
    use std::fmt::Write;
    use std::sync::Arc;

    /// A chain of `n` balls, each turning about another axis than the one before.
    fn chain(links: usize) -> Arc<RobotModel> {
        let ball = "<collision><geometry><sphere radius='0.06'/></geometry></collision>";
        let mut urdf = format!("<robot name='r'><link name='l0'>{ball}</link>");
        for i in 1..links {
            let axis = ["1 0 0", "0 1 0", "0 0 1"][i % 3];
            let _ = write!(
                urdf,
                "<link name='l{i}'>{ball}</link><joint name='j{i}' type='continuous'><parent link='l{}'/>
                 <child link='l{i}'/><origin xyz='0.1 0.03 0.05'/><axis xyz='{axis}'/></joint>",
                i - 1
            );
        }
        Arc::new(RobotModel::from_urdf(&(urdf + "</robot>"), &MeshFiles::default()).unwrap())
    }

    #[test]
    fn more_parts_and_states_than_lanes_hit_what_every_pair_alone_hits() {
        let mut random = Random::new(91);
        let robot = chain(21);
        let mut free = 0;
        for round in 0..12 {
            let mut world = World::default();
            let mut matrix = AllowedCollisionMatrix::of_robot(&robot);
            for i in 0..30 {
                let shape = match random.below(2) {
                    0 => Primitive::Sphere { radius: 0.04 },
                    _ => Primitive::Box { half_extents: [0.02, 0.05, 0.03] },
                };
                let pose = random.pose(0.7);
                world.add(Obstacle::of_shape(format!("o{i}"), pose, Shape::Primitive(shape))).unwrap();
                for link in 0..21 {
                    if random.below(4) == 0 {
                        matrix.set(&format!("l{link}"), &format!("o{i}"), true);
                    }
                }
            }
            let settings = Settings { check_self: false, ..Settings::default() };
            let checker =
                CollisionChecker::with_matrix(Arc::clone(&robot), &world, settings, Some(&matrix)).unwrap();
            let mut workspace = checker.workspace();
            let states: Vec<_> = (0..16 + round)
                .map(|_| {
                    let q: Vec<f64> = (0..20).map(|_| random.within(3.0)).collect();
                    robot.configuration(&q).unwrap()
                })
                .collect();
            let alone: Vec<bool> =
                states.iter().map(|q| checker.check(q, Question::Pairs, &mut workspace).is_free()).collect();
            let one_by_one: Vec<bool> = states.iter().map(|q| checker.is_free(q, &mut workspace)).collect();
            assert_eq!(one_by_one, alone);
            assert_eq!(checker.are_free(&states), alone);
            free += alone.iter().filter(|free| **free).count();
        }
        assert!((50..220).contains(&free), "{free}");
    }

    #[test]
    fn a_world_that_is_rejected_changes_nothing() {
        let robot = chain(4);
        let ball = |name: &str, x: f64| {
            let shape = Shape::Primitive(Primitive::Sphere { radius: 0.05 });
            Obstacle::of_shape(name, Pose::translation(x, 0.0, 0.0), shape)
        };
        let mut world = World::default();
        world.add(ball("a", 5.0)).unwrap();
        let object_padding = [("b".to_owned(), -0.01)].into();
        let settings = Settings { check_self: false, object_padding, ..Settings::default() };
        let mut checker = CollisionChecker::new(Arc::clone(&robot), &world, settings).unwrap();
        let mut workspace = checker.workspace();
        let zero = robot.configuration(&[0.0; 3]).unwrap();
        assert!(checker.is_free(&zero, &mut workspace));
        let mut nearer = World::default();
        nearer.add(ball("a", 0.1)).unwrap();
        nearer.add(ball("b", 7.0)).unwrap();
        assert!(checker.set_world(&nearer).is_err());
        assert!(checker.is_free(&zero, &mut workspace));
        assert!(checker.check(&zero, Question::Pairs, &mut workspace).is_free());
        let mut harmless = World::default();
        harmless.add(ball("a", 0.1)).unwrap();
        checker.set_world(&harmless).unwrap();
        assert!(!checker.is_free(&zero, &mut workspace));
    }
}
