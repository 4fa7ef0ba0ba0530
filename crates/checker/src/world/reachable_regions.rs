//! Regions that the robot's moving parts can reach, computed once. Obstacles outside them are skipped in every expected
//! state.

use std::ops::RangeInclusive;

use clearance_geometry::constants::{CONTACT_DISTANCE, MOTION_SLACK};
use clearance_geometry::math::Vector;
use clearance_robot::{Chain, Reach, ReachableRegion, RobotModel};

use crate::capsules::{RootCapsule, RootVolume, round_up};
use crate::robot::{RobotBody, RobotGeometry};

/// Tolerance (m) beyond the limits of sliding joints: encoders are noisy, and drivers round.
const LIMIT_TOLERANCE: f64 = 0.01;

/// Bounding balls (root frame) of the parts with their paddings over all expected states. A state is expected if its
/// sliding joints are within their limits and a tolerance.
#[derive(Clone, Debug, Default)]
pub struct ReachableRegions {
    /// Indices of positions of sliding joints, and the expected range of each.
    expected: Vec<(usize, RangeInclusive<f64>)>,
    /// By part; `None` where the reach is not bounded.
    balls: Vec<Option<Ball>>,
    /// Bounding ball of all moving parts; `None` where one of them is not bounded.
    all: Option<Vec<RootCapsule>>,
}

#[derive(Clone, Copy, Debug)]
struct Ball {
    centre: Vector,
    radius: f64,
}

impl ReachableRegions {
    pub fn new(robot: &RobotGeometry) -> Self {
        let (model, chain, parts) = (robot.model(), robot.chain(), robot.parts());
        let expected: Vec<_> =
            chain.sliding_positions().filter_map(|q| Some((q, expected_range(model, q)?))).collect();
        let range_of = |position| {
            let known = expected.iter().find(|(other, _)| *other == position);
            known.map(|(_, range)| range.clone())
        };
        let regions = chain.territories(range_of);
        let balls: Vec<_> =
            parts.iter().map(|robot_body| Ball::of(robot_body, &regions[robot_body.chain_body()])).collect();
        let moving =
            parts.iter().zip(&balls).filter(|(robot_body, _)| robot_body.chain_body() != Chain::ROOT);
        let moving: Option<Vec<Ball>> = moving.map(|(_, ball)| *ball).collect();
        let all = moving.map(|moving| outermost(&moving).iter().map(Ball::capsule).collect());
        Self { expected, balls, all }
    }

    /// True if all sliding joints are in their expected ranges.
    #[inline(always)]
    pub fn is_expected(&self, positions: &[f64]) -> bool {
        self.expected.iter().all(|(q, range)| range.contains(&positions[*q]))
    }

    /// Bounding ball of a part's motion, if it is bounded.
    pub fn ball_of_part(&self, part: usize) -> Option<RootCapsule> {
        self.balls[part].as_ref().map(Ball::capsule)
    }

    /// True if a moving part may touch a volume in an expected state.
    pub fn may_touch(&self, volume: &RootVolume) -> bool {
        let Some(balls) = &self.all else { return true };
        // NaN is no bound
        let is_beyond = |ball: &RootCapsule| volume.lower_bound(ball) > round_up(CONTACT_DISTANCE);
        !balls.iter().all(is_beyond)
    }
}

impl Ball {
    /// Ball that a part with its padding can reach, given the ball of its body's origin.
    fn of(robot_body: &RobotBody, region: &ReachableRegion) -> Option<Self> {
        let farther = robot_body.farther_end() + robot_body.capsule().radius + robot_body.padding();
        let radius = (region.radius + farther) * (1.0 + MOTION_SLACK) + MOTION_SLACK;
        radius.is_finite().then_some(Self { centre: region.centre, radius })
    }

    fn contains(&self, other: &Self) -> bool {
        (self.centre - other.centre).norm() + other.radius <= self.radius
    }

    fn capsule(&self) -> RootCapsule {
        RootCapsule::of_reach(&Reach { ends: [self.centre; 2], radius: self.radius }, 0.0)
    }
}

/// The balls that are contained in no other one.
fn outermost(balls: &[Ball]) -> Vec<Ball> {
    let mut kept: Vec<Ball> = Vec::new();
    for ball in balls {
        if !kept.iter().any(|other| other.contains(ball)) {
            kept.retain(|other| !ball.contains(other));
            kept.push(*ball);
        }
    }
    kept
}

/// Expected range of a position that belongs to one joint only and has limits.
fn expected_range(robot: &RobotModel, position: usize) -> Option<RangeInclusive<f64>> {
    let joint = robot.joint_ids().find(|joint| robot.first_position(*joint) == Some(position))?;
    let joint = robot.joint(joint);
    let limits = joint.limits.filter(|_| joint.kind.position_suffixes().len() == 1)?;
    Some(limits.lower - LIMIT_TOLERANCE..=limits.upper + LIMIT_TOLERANCE)
}

#[cfg(test)]
mod tests {
    use crate::{CollisionChecker, Question};
    use clearance_geometry::testing::Random;
    use clearance_geometry::{Primitive, Shape};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::Settings;
    use clearance_scene::{Obstacle, World};
    use std::sync::Arc;

    /// A mast that slides by 0.5 m and an arm on it, of which a gripper's finger follows another finger.
    const URDF: &str = "<robot name='r'><link name='base'/>
        <link name='mast'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>
        <link name='arm'><collision><origin xyz='0.2 0 0'/><geometry><box size='0.4 0.1 0.1'/></geometry></collision></link>
        <link name='left'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>
        <link name='right'><collision><geometry><sphere radius='0.05'/></geometry></collision></link>
        <joint name='lift' type='prismatic'><parent link='base'/><child link='mast'/><axis xyz='0 0 1'/>
          <limit lower='0' upper='0.5' effort='1' velocity='1'/></joint>
        <joint name='turn' type='continuous'><parent link='mast'/><child link='arm'/><axis xyz='0 0 1'/></joint>
        <joint name='open' type='prismatic'><parent link='arm'/><child link='left'/><origin xyz='0.4 0 0'/><axis xyz='0 1 0'/>
          <limit lower='0' upper='0.1' effort='1' velocity='1'/></joint>
        <joint name='follow' type='prismatic'><parent link='arm'/><child link='right'/><origin xyz='0.4 0 0'/><axis xyz='0 1 0'/>
          <limit lower='-0.1' upper='0' effort='1' velocity='1'/><mimic joint='open' multiplier='-1'/></joint></robot>";

    fn scattered(random: &mut Random, name: &str, by: f64) -> Obstacle {
        let shape = match random.below(2) {
            0 => Primitive::Sphere { radius: 0.3 },
            _ => Primitive::Box { half_extents: [0.2, 0.4, 0.2] },
        };
        Obstacle::of_shape(name.to_owned(), random.pose(by), Shape::Primitive(shape))
    }

    #[test]
    fn states_beyond_the_limits_of_joints_that_slide_are_checked_against_all_there_is() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let mut random = Random::new(17);
        let [mut free, mut far, mut hit_beyond] = [0; 3];
        for round in 0..60 {
            let mut world = World::default();
            let names: Vec<String> = (0..20).map(|i| format!("o{i}")).collect();
            for name in &names {
                world.add(scattered(&mut random, name, 2.0)).unwrap();
            }
            let settings = Settings { check_self: false, ..Settings::default() };
            let mut checker = CollisionChecker::new(Arc::clone(&robot), &world, settings).unwrap();
            for _ in 0..4 {
                let moved = names[random.below(names.len())].as_str();
                world.remove(moved).unwrap();
                let by = [1.0, 4.0][random.below(2)];
                world.add(scattered(&mut random, moved, by)).unwrap();
                checker.set_world(&world).unwrap();
                let mut workspace = checker.workspace();
                let states: Vec<_> = (0..24)
                    .map(|_| {
                        let farther = if random.below(4) == 0 { 5.0 } else { 1.0 };
                        let (lift, open) = (0.25 + random.within(0.25), 0.05 + random.within(0.05));
                        robot.configuration(&[lift * farther, random.within(3.0), open * farther]).unwrap()
                    })
                    .collect();
                let alone: Vec<bool> = (states.iter())
                    .map(|q| checker.check(q, Question::Pairs, &mut workspace).is_free())
                    .collect();
                let one_by_one: Vec<bool> =
                    states.iter().map(|q| checker.is_free(q, &mut workspace)).collect();
                assert_eq!(one_by_one, alone, "round {round}");
                assert_eq!(checker.are_free(&states), alone, "round {round}");
                free += alone.iter().filter(|free| **free).count();
                let beyond = states
                    .iter()
                    .map(|q| !checker.checked_pairs().world().reachable().is_expected(q.positions()));
                hit_beyond += beyond.zip(&alone).filter(|(beyond, free)| *beyond && !**free).count();
                far += checker.checked_pairs().world().obstacles().pieces().unreachable_count();
                let all = checker.world_boxes().len();
                assert_eq!(all, 20);
            }
        }
        assert!((1000..5600).contains(&free) && far > 1000 && hit_beyond > 70, "{free} {far} {hit_beyond}");
    }
}
