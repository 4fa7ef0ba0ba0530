//! Approach rate of two bodies: finite difference of the positions of their witness points.
//!
//! The rate is an estimate, not a bound.
use clearance_checker::{CollisionChecker, PairDistance};
use clearance_geometry::math::{Extremes, Point, Pose, Vector, without_whole_turns};
use clearance_robot::{Configuration, JointKind, LinkId, LinkPoses, Reach, RobotModel};
use clearance_scene::BodyId;

use super::CheckedState;
use super::obstacle_motion::ObstacleMotion;
use super::predicted_distances::Reached;

/// Time step (s) over which links are moved by their velocities: far above rounding errors, short enough for a straight
/// motion.
pub(super) const STEP: f64 = 1e-5;

/// Below this distance (m) the direction between two points is undefined.
const LEAST_DISTANCE: f64 = 1e-9;

/// Link poses at another time.
#[derive(Clone, Debug)]
pub(super) struct PosesAtOtherTime {
    pub poses: LinkPoses,
    /// Time difference (s): positive if later, negative if earlier.
    pub after: f64,
    /// Velocities of the positions (rad/s, m/s); `None` where they are not the derivatives of the positions.
    pub rates: Option<Vec<f64>>,
}

/// Conditions of an approach rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct ApproachTerms {
    /// Time (s) in which other points than the nearest ones count; 0 for the nearest ones alone.
    pub within: f64,
    /// The least distance of the pair in this time, if the robot moves on at its joint velocities and its root stands;
    /// `None` if it is not known.
    pub reached: Option<Reached>,
    /// Angle (rad) by which the obstacle may lie in another direction than the one from its pose.
    pub turned: f64,
}

/// Link poses `STEP` later, from the rates of all positions; `None` if these are unknown or are not derivatives of the
/// positions.
pub(super) fn poses_after_step(robot: &RobotModel, checked_state: &CheckedState) -> Option<PosesAtOtherTime> {
    if floats(robot) {
        return None;
    }
    let rates = checked_state.rates.as_ref()?;
    let velocities = rates.iter();
    let moved: Vec<f64> =
        (checked_state.configuration.positions().iter()).zip(velocities).map(|(q, v)| q + STEP * v).collect();
    let moved: Configuration = robot.configuration(&moved).ok()?;
    let mut poses = LinkPoses::new(robot);
    robot.forward_kinematics(&moved, &mut poses);
    Some(PosesAtOtherTime { poses, after: STEP, rates: Some(rates.clone()) })
}

/// The link poses of an earlier state, `after` seconds from this one.
pub(super) fn poses_before(
    robot: &RobotModel,
    checked_state: &CheckedState,
    before: &CheckedState,
    after: f64,
) -> PosesAtOtherTime {
    let positions = [checked_state, before].map(|state| state.configuration.positions());
    let turns = robot.whole_turns();
    let rate = |i: usize| {
        let way = positions[1][i] - positions[0][i];
        (if turns[i] { without_whole_turns(way) } else { way }) / after
    };
    let rates = (!floats(robot)).then(|| (0..turns.len()).map(rate).collect());
    PosesAtOtherTime { poses: before.poses.clone(), after, rates }
}

/// Whether the robot has a floating joint, whose velocity is not the derivative of its positions.
fn floats(robot: &RobotModel) -> bool {
    robot.joints().iter().any(|joint| joint.kind == JointKind::Floating)
}

/// Rate (m/s) at which the distance of a pair shrinks; negative when it grows, `None` when the bodies touch. It is that of
/// the nearest points, unless other points come nearer in the time that counts.
///
/// Obstacles are at rest in the frames that they are placed in; motion of their own is not that of the robot. If there are
/// several such frames, the fastest approach counts.
pub(super) fn approach_rate(
    checker: &CollisionChecker,
    pair: &PairDistance,
    checked_state: &CheckedState,
    other: &PosesAtOtherTime,
    terms: ApproachTerms,
) -> Option<f64> {
    let rate = |obstacle_motion| {
        let moved = RelativeMotion { checker, pair, poses: (&checked_state.poses, other), obstacle_motion };
        moved.rate(terms)
    };
    let is_of_world = [pair.a, pair.b].iter().any(|body| matches!(body, BodyId::Obstacle(_)));
    if !is_of_world || checked_state.obstacle_motions.is_empty() {
        return rate(None);
    }
    checked_state
        .obstacle_motions
        .iter()
        .map(|obstacle_motion| rate(Some(obstacle_motion)))
        .collect::<Option<Vec<f64>>>()?
        .into_iter()
        .reduce(f64::greater)
}

/// Motion of the bodies of a pair, relative to each other.
struct RelativeMotion<'m> {
    checker: &'m CollisionChecker,
    pair: &'m PairDistance,
    /// Now, and at another time.
    poses: (&'m LinkPoses, &'m PosesAtOtherTime),
    /// Motion of the frame of an obstacle.
    obstacle_motion: Option<&'m ObstacleMotion>,
}

impl RelativeMotion<'_> {
    /// Approach rate (m/s): the relative velocity of the nearest points along the line between them, or, if that is more,
    /// the mean rate in the time that counts. `None` if they touch.
    fn rate(&self, ApproachTerms { within, reached, turned }: ApproachTerms) -> Option<f64> {
        let [a, b] = self.pair.witness_points;
        let way = b - a;
        if way.norm() < LEAST_DISTANCE || self.pair.distance <= 0.0 {
            return None;
        }
        let (direction, after) = (way.normalize(), self.poses.1.after);
        let moved = self.moved(self.pair.a, &a) - self.moved(self.pair.b, &b);
        let rate = if turned > 0.0 {
            largest_component(&(moved / after), &direction, turned)
        } else {
            direction.dot(&moved) / after
        };
        if within <= 0.0 || !rate.is_finite() {
            return rate.is_finite().then_some(rate);
        }
        let root_stands = self.obstacle_motion.is_none_or(ObstacleMotion::is_none);
        if let Some(reached) = reached.filter(|_| root_stands) {
            let straight = self.pair.distance - rate.greater(0.0) * within;
            let of_others = (self.pair.distance - reached.distance) / within;
            return Some(if reached.is_nearer_than(straight) { of_others } else { rate });
        }
        // seen from each body, the other one moves: the smaller of both rates is enough
        let bodies = [(self.pair.a, self.pair.b, direction), (self.pair.b, self.pair.a, -direction)];
        let robot_bodies = bodies.into_iter().filter(|(body, ..)| carrier(self.checker, *body).is_some());
        let of_others = robot_bodies.map(|(body, other, towards)| {
            let reached = self.distance_after([body, other], &towards, within);
            (self.pair.distance - reached) / within
        });
        let of_others = of_others.filter(|rate| rate.is_finite()).reduce(f64::lesser);
        Some(of_others.map_or(rate, |of_others| rate.greater(of_others)))
    }

    /// Estimate of the distance (m) of a body from the other one after the time `within` (s): the least of points on the axes of
    /// its capsules, which move at constant velocities. A point may come near in the direction of the nearest points
    /// only, and no faster than it moves.
    fn distance_after(&self, [body, other]: [BodyId; 2], towards: &Vector, within: f64) -> f64 {
        let sign = if body == self.pair.a { 1.0 } else { -1.0 };
        let [own, others] = [body, other].map(|body| self.checker.bounding_capsules(body, self.poses.0));
        let points: Vec<(Point, f64)> = own.iter().flat_map(points_on_axis).collect();
        let front = points.iter().map(|(p, radius)| towards.dot(&p.coords) + radius);
        let front = front.fold(f64::NEG_INFINITY, f64::greater);
        let distances = points.iter().map(|(point, radius)| {
            let moved = (self.moved(self.pair.a, point) - self.moved(self.pair.b, point)) * sign;
            let motion = moved * (within / self.poses.1.after);
            let behind = front - towards.dot(&point.coords) - radius;
            let along = self.pair.distance + behind - towards.dot(&motion);
            let gaps = others.iter().map(|capsule| distance_to(capsule, point) - radius - motion.norm());
            along.greater(gaps.fold(f64::INFINITY, f64::lesser))
        });
        distances.fold(f64::INFINITY, f64::lesser)
    }

    /// Displacement of a point of a body.
    fn moved(&self, body: BodyId, point: &Point) -> Vector {
        let (now, other) = self.poses;
        match carrier(self.checker, body) {
            Some(link) => displacement(point, now.pose(link), other.poses.pose(link)),
            None => self.obstacle_motion.map_or_else(Vector::zeros, |obstacle_motion| {
                obstacle_motion.displacement(point, other.after)
            }),
        }
    }
}

/// Upper bound (m/s) on the rate at which any point of a robot body approaches any point of an obstacle; `None` where
/// there is none: the joint velocities are not measured, the obstacle or the body is too large for their distance, or
/// the root moves.
pub(super) fn largest_approach_rate(
    checker: &CollisionChecker,
    pair: &PairDistance,
    checked_state: &CheckedState,
    other: &PosesAtOtherTime,
    turned: f64,
) -> Option<f64> {
    let is_measured = checked_state.velocities.is_some() && other.after > 0.0;
    if !is_measured || !checked_state.obstacle_motions.iter().all(ObstacleMotion::is_none) {
        return None;
    }
    let (body, obstacle) = match pair.b {
        BodyId::Obstacle(_) => (pair.a, pair.b),
        _ => (pair.b, pair.a),
    };
    let link = carrier(checker, body)?;
    let poses = [&checked_state.poses, &other.poses].map(|poses| poses.pose(link));
    let [around] = <[Reach; 1]>::try_from(checker.bounding_capsules(obstacle, &checked_state.poses)).ok()?;
    let moving = checker.bounding_capsules(body, &checked_state.poses);
    let rates = moving.iter().map(|reach| largest_rate_towards(&around, reach, (poses, other.after), turned));
    rates.reduce(|a, b| Some(a?.greater(b?)))?
}

/// Largest component of a velocity along the directions that are at most an angle (rad) apart from the given one.
fn largest_component(velocity: &Vector, direction: &Vector, turned: f64) -> f64 {
    velocity.norm() * (velocity.angle(direction) - turned).greater(0.0).cos()
}

/// The same for a moving capsule and an obstacle in a capsule. All directions from one to the other are within a cone, which is wider
/// by an angle (rad) where the obstacle may have moved.
fn largest_rate_towards(
    around: &Reach,
    moving: &Reach,
    ([now, then], after): ([&Pose; 2], f64),
    turned: f64,
) -> Option<f64> {
    let middle = |reach: &Reach| (reach.ends[0] + reach.ends[1]) * 0.5;
    let size = |reach: &Reach| (reach.ends[1] - reach.ends[0]).norm() * 0.5 + reach.radius;
    let way = middle(around) - middle(moving);
    let share = (size(around) + size(moving)) / way.norm();
    // also without a number there is no cone
    let half_angle = if share < 1.0 { share.asin() + turned } else { return None };
    let towards = |end: Vector| {
        let velocity = displacement(&Point::from(end), now, then) / after;
        largest_component(&velocity, &way, half_angle)
    };
    let turning = (then.rotation * now.rotation.inverse()).angle() / after;
    Some(towards(moving.ends[0]).greater(towards(moving.ends[1])) + turning * moving.radius)
}

/// Points on the axis of a capsule, with its radius.
fn points_on_axis(capsule: &Reach) -> impl Iterator<Item = (Point, f64)> {
    const PARTS: u8 = 8;
    let [start, end] = capsule.ends;
    let radius = capsule.radius;
    (0..=PARTS).map(move |k| (Point::from(start + (end - start) * (f64::from(k) / f64::from(PARTS))), radius))
}

/// Distance (m) of a point from a capsule; negative inside it.
fn distance_to(capsule: &Reach, point: &Point) -> f64 {
    let [start, end] = capsule.ends;
    let axis = end - start;
    let length = axis.norm_squared();
    let share = if length > 0.0 { (point.coords - start).dot(&axis) / length } else { 0.0 };
    (point.coords - start - axis * share.clamp(0.0, 1.0)).norm() - capsule.radius
}

/// Displacement of a link's point between two poses.
fn displacement(point_r: &Point, now: &Pose, then: &Pose) -> Vector {
    let point_l = now.inverse_transform_point(point_r);
    // both terms start from the point in the link frame, so that they have the same rounding errors
    then * point_l - now * point_l
}

/// The link that a body is attached to.
pub(super) fn carrier(checker: &CollisionChecker, body: BodyId) -> Option<LinkId> {
    match body {
        BodyId::Link(link) => Some(link),
        BodyId::Attached(id) => checker.robot().link_by_name(&checker.world().attached_object(id).link),
        BodyId::Obstacle(_) => None,
    }
}
