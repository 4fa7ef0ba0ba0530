//! Collision test of a placed robot with obstacles, in lanes: eight parts in one state, or one part in eight states.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::simd::{LANES, Simd, f32x8};
use clearance_proximity::Scratch;
use clearance_robot::Frame;

use super::capsules::{PlacedSegment, up};
use super::collision_checker::CollisionChecker;
use super::nearby::NearbyScratch;
use super::root_volume::RootCapsule;
use super::within_reach::PartOrder;

/// Search options and scratch memory of a search of obstacles.
pub(super) type WorldScratch<'w> = (&'w mut Scratch, &'w mut NearbyScratch, &'w mut PartOrder);

impl CollisionChecker {
    /// True if a part touches an obstacle in a state, which may be expected or not; `segments` are relative to `origin`.
    #[inline(always)]
    pub(super) fn hits_obstacle<S: Simd>(
        &self,
        simd: S,
        (segments, is_as_expected): ((&[PlacedSegment], [f32; 3]), bool),
        frame: &impl Fn(usize) -> Frame<f64>,
        (scratch, nearby, part_order): WorldScratch<'_>,
    ) -> bool {
        if self.pairs().world_len() == 0 {
            return false;
        }
        let within_reach = self.within_reach(scratch, nearby);
        if within_reach.fixed_contact {
            return true;
        }
        part_order.suit(self.revision, within_reach);
        let parts = if is_as_expected { &part_order.parts } else { &within_reach.moving };
        for first in (0..parts.len()).step_by(LANES) {
            let eight = &parts[first..parts.len().min(first + LANES)];
            let capsules = self.eight_capsules(simd, eight, segments);
            let checks = |place, asked: u8| {
                let (mut checked, mut left) = (0, asked);
                while left != 0 {
                    let lane = left.trailing_zeros() as usize;
                    left &= left - 1;
                    checked |= u8::from(self.pairs().checks(eight[lane], place)) << lane;
                }
                checked
            };
            let all = u8::MAX >> (LANES - eight.len());
            self.find_near_eight(
                simd,
                (&capsules, all, is_as_expected),
                (up(CONTACT_DISTANCE), checks),
                nearby,
                &mut scratch.work,
            );
            let mut left = nearby.lanes_near();
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                if self.touches_near(eight[lane], lane, frame, (scratch, nearby)) {
                    if is_as_expected {
                        part_order.step_forward(first + lane);
                    }
                    return true;
                }
            }
        }
        false
    }

    /// Bit mask of the states among eight, selected by `among`, in which a part touches an obstacle. Either all of them are expected, or
    /// at least one is not.
    #[inline(always)]
    pub(super) fn states_that_hit<S: Simd>(
        &self,
        simd: S,
        (among, are_as_expected): (u8, bool),
        capsules: impl Fn(usize) -> RootCapsule<f32x8<S>>,
        frame: &impl Fn(usize, usize) -> Frame<f64>,
        (scratch, nearby, part_order): WorldScratch<'_>,
    ) -> u8 {
        if self.pairs().world_len() == 0 {
            return 0;
        }
        let within_reach = self.within_reach(scratch, nearby);
        if within_reach.fixed_contact {
            return among;
        }
        part_order.suit(self.revision, within_reach);
        let mut hit = 0;
        let parts = if are_as_expected { part_order.parts.len() } else { within_reach.moving.len() };
        for rank in 0..parts {
            let left = among & !hit;
            if left == 0 {
                break;
            }
            let part = if are_as_expected { part_order.parts[rank] } else { within_reach.moving[rank] };
            let checks = |place, asked| if self.pairs().checks(part, place) { asked } else { 0 };
            self.find_near_eight(
                simd,
                (&capsules(part), left, are_as_expected),
                (up(CONTACT_DISTANCE), checks),
                nearby,
                &mut scratch.work,
            );
            let (mut found, mut left) = (0, nearby.lanes_near());
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let touches = self.touches_near(part, lane, &|body| frame(body, lane), (scratch, nearby));
                found |= u8::from(touches) << lane;
            }
            hit |= found;
            if found != 0 && are_as_expected {
                part_order.step_forward(rank);
            }
        }
        hit
    }

    /// True if a part touches one of the pieces found near it, in its lane of eight.
    #[inline(always)]
    fn touches_near(
        &self,
        part: usize,
        lane: usize,
        frame: &impl Fn(usize) -> Frame<f64>,
        (scratch, nearby): (&mut Scratch, &mut NearbyScratch),
    ) -> bool {
        let NearbyScratch { near_eight, pieces, .. } = nearby;
        near_eight.chunk_by(|a, b| a.place == b.place).any(|of_one| {
            pieces.clear();
            pieces.extend(of_one.iter().filter(|near| near.lanes & (1 << lane) != 0).map(|near| near.piece));
            let index = self.world_pair(part, of_one[0].place as usize);
            !pieces.is_empty() && self.pair_with(index, frame).pieces_touch(pieces, scratch)
        })
    }
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
    fn a_world_that_is_refused_changes_nothing() {
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
