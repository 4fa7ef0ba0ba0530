//! Tests of the look-ahead with moving obstacles: before its time, nothing touches.

use std::sync::Arc;

use clearance_geometry::math::{Pose, Rotation};
use clearance_geometry::testing::Random;
use clearance_motion::{MotionSegment, MovingObstacle};
use clearance_scene::World;

use crate::random_scenes::{checker, state, with_uncertainty};
use crate::{CollisionChecker, LookAheadState};

/// Known motions of about half of the obstacles, which have begun before.
fn motions_of_some(world: &World, random: &mut Random) -> Vec<MovingObstacle> {
    let mut motions = Vec::new();
    for obstacle in world.obstacles() {
        if random.below(2) == 0 {
            let mut vector = |size: f64| [0, 1, 2].map(|_| random.within(size));
            let (centre, linear, angular) = (vector(1.0), vector(0.5), vector(1.0));
            let name = obstacle.name.clone();
            let motion = MovingObstacle { name, centre, linear, angular, start: None };
            let begin = random.within(0.2);
            motions.push(motion.part([begin, begin + 1.0]));
        }
    }
    motions
}

/// Robot and obstacles accelerate at random within their limits; before the time of the look-ahead nothing touches. Returns
/// the number of motions that touched later, of at least so many that ended before.
fn touched_after_the_look_ahead(motions: u32, random: &mut Random) -> u32 {
    let (mut placed, mut touched) = (0, 0);
    while placed < motions {
        let checker = checker(random);
        let from = state(checker.robot(), random);
        let still = MotionSegment::straight(checker.robot(), &from, &from);
        let loose = with_uncertainty(still, random);
        let Some(text) = loose.text().obstacle_uncertainty else { continue };
        let limits = Arc::new(text.limits);
        let velocities: Vec<f64> = from.positions().iter().map(|_| random.within(1.0)).collect();
        let accelerations: Vec<f64> = from.positions().iter().map(|_| random.within(2.0).abs()).collect();
        let horizon = 1.0;
        let moving_obstacles = motions_of_some(checker.world(), random);
        let now = LookAheadState {
            q: &from,
            velocities: &velocities,
            accelerations: &accelerations,
            moving_obstacles: &moving_obstacles,
            obstacle_limits: Some(&limits),
            obstacle_latency: text.time[0],
            only_moving_obstacles: false,
        };
        let found = checker.look_ahead(now, horizon, &mut checker.workspace()).unwrap();
        for _ in 0..5 {
            let time = random.within(0.5) + 0.5;
            let uncertainty = |name: &str| limits.of(name).displacement(text.time[0] + time);
            let mut world = checker.world().clone();
            for obstacle in checker.world().obstacles() {
                let way = random.direction().into_inner() * uncertainty(&obstacle.name);
                let deviation = Pose::from_parts(way.into(), Rotation::identity());
                let known = moving_obstacles.iter().find(|mover| mover.name == obstacle.name);
                let moved = known.map_or_else(Pose::identity, |mover| mover.displacement(time / horizon));
                world.move_to(&obstacle.name, deviation * moved * obstacle.pose_ro).unwrap();
            }
            let later = (0..velocities.len()).map(|i| {
                let acceleration = [-1.0, 1.0, random.within(1.0)][random.below(3)] * accelerations[i];
                from.positions()[i] + velocities[i] * time + 0.5 * acceleration * time * time
            });
            let later: Vec<f64> = later.collect();
            let settings = checker.settings().clone();
            let elsewhere = CollisionChecker::new(Arc::clone(checker.robot()), &world, settings).unwrap();
            let later = checker.robot().configuration(&later).unwrap();
            let is_apart = elsewhere.is_free(&later, &mut elsewhere.workspace());
            assert!(is_apart || time >= found.free_for, "{found:?}, but a contact at {time}");
            placed += u32::from(time < found.free_for);
            touched += u32::from(!is_apart);
        }
    }
    touched
}

#[test]
fn nothing_touches_before_the_look_ahead_with_moving_obstacles() {
    let touched = touched_after_the_look_ahead(3000, &mut Random::new(92));
    assert!(touched > 100, "{touched}");
}

/// By hand: `cargo test --release -p clearance-checker -- --ignored --nocapture many_obstacle_motions`.
#[test]
#[ignore = "takes many minutes"]
fn many_obstacle_motions() {
    for thousands in 1..=1000 {
        let touched = touched_after_the_look_ahead(1000, &mut Random::new(92_000 + thousands));
        println!("{} motions: {touched} touched later", 1000 * thousands);
    }
}
