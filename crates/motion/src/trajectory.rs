//! Trajectory: consecutive motion segments with times, as in a ROS joint trajectory.

mod parts;

pub(crate) use parts::Part;

use std::sync::Arc;

use clearance_robot::{Configuration, ConfigurationError, NamedJoints, RobotModel};
use clearance_scene::World;

use super::{
    ContinuousDirection, HeldTurn, JoinError, LimitError, MotionSegment, ObstacleLimits, ObstacleUncertainty,
    SegmentError, floating, join, shortest_turns,
};

/// Largest difference (m, or of a component of a quaternion, relative to the size of the value) that rounding explains between two
/// points in which a floating joint rests.
const LARGEST_ROUNDING: f64 = 1e-12;

/// Segments, with their start and end times (s).
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    segments: Vec<MotionSegment>,
    /// One more than segments; empty if no times were given.
    times: Vec<f64>,
    /// By segment, the original segment it is a part of; empty if none was split.
    parts: Vec<Part>,
}

/// One point of a trajectory, as in `trajectory_msgs/JointTrajectoryPoint`: velocities and accelerations may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrajectoryPoint {
    /// Positions (rad, m) in the order of the joint names.
    pub positions: Vec<f64>,
    /// Velocities (rad/s, m/s); may be empty.
    pub velocities: Vec<f64>,
    /// Accelerations (rad/s², m/s²); may be empty.
    pub accelerations: Vec<f64>,
    /// Time (s) from the start.
    pub time_from_start: f64,
}

impl TrajectoryPoint {
    /// Seconds of a ROS duration, correctly rounded: 300,000,000 ns are 0.3.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "more than a hundred days are rounded to nanoseconds")]
    pub fn seconds(sec: i32, nanosec: i64) -> f64 {
        (i64::from(sec) * 1_000_000_000 + nanosec) as f64 / 1e9
    }
}

/// Reason why points are not a valid trajectory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum TrajectoryError {
    #[error("a trajectory needs at least two points, but it has {0}")]
    TooShort(usize),
    #[error("point {point}: {error}")]
    Point { point: usize, error: ConfigurationError },
    #[error("point {point}: {given} {what} for {expected} joints")]
    Length { point: usize, what: &'static str, given: usize, expected: usize },
    #[error("point {point}: its {what} of joint '{joint}' is not finite")]
    NotFinite { point: usize, what: &'static str, joint: String },
    #[error("joint_names: {0}")]
    Names(ConfigurationError),
    #[error("point {point}: time_from_start {time} s does not come after {previous} s")]
    Time { point: usize, time: f64, previous: f64 },
    #[error("point {point}: time_from_start {time} s is negative")]
    NegativeTime { point: usize, time: f64 },
    #[error("point {point}: time_from_start {time} s is not finite")]
    TimeNotFinite { point: usize, time: f64 },
    #[error("times have to be set before moving obstacles")]
    ObstaclesBeforeTimes,
    #[error(
        "{pieces} pieces of motions of obstacles are more than {most}: each pose of an obstacle splits the motion of all"
    )]
    TooManyPieces { pieces: usize, most: usize },
    #[error("{given} times for {expected} points")]
    TimeCount { given: usize, expected: usize },
    #[error("point {0} has velocities but the trajectory has no times")]
    NoTimes(usize),
    #[error("segment {segment} begins {jump} rad or m off where the last one ends")]
    Jump { segment: usize, jump: f64 },
    #[error("obstacle '{name}' is not at the start of segment {segment} where it was at the end of the last")]
    ObstacleJump { segment: usize, name: String },
    #[error("obstacles are to move, but the trajectory has no times: give its points time_from_start")]
    NoClock,
    #[error("how far obstacles may have moved in segment {0} does not continue from the segment before")]
    ObstacleLimits(usize),
    #[error(
        "obstacle '{name}' has poses from time {} to {}, but the motion lasts from {} to {}", poses[0], poses[1], motion[0], motion[1]
    )]
    ObstacleTimes { name: String, poses: [f64; 2], motion: [f64; 2] },
    #[error("the shortest way: {0}")]
    ShortestWay(ConfigurationError),
    #[error(transparent)]
    Held(HeldTurn),
    #[error("segment {segment}: {error}")]
    Segment { segment: usize, error: SegmentError },
}

impl TrajectoryError {
    /// A segment does not start where the previous one ends.
    fn at_join(segment: usize, error: JoinError) -> Self {
        match error {
            JoinError::Length { before, after } => {
                let error = SegmentError::WrongLength { given: after, expected: before };
                Self::Segment { segment, error }
            }
            JoinError::Position { from, to, .. } => Self::Jump { segment, jump: (to - from).abs() },
            JoinError::Obstacle { name, .. } => Self::ObstacleJump { segment, name },
            JoinError::ObstacleLimits => Self::ObstacleLimits(segment),
        }
    }
}

impl Trajectory {
    /// Segments without times; each must begin where the last ends, for robot and obstacles.
    pub fn of_segments(segments: Vec<MotionSegment>) -> Result<Self, TrajectoryError> {
        if segments.is_empty() {
            return Err(TrajectoryError::TooShort(0));
        }
        for (i, two) in segments.windows(2).enumerate() {
            join(&two[0], &two[1]).map_err(|error| TrajectoryError::at_join(i + 1, error))?;
        }
        Ok(Self { segments, times: Vec::new(), parts: Vec::new() })
    }

    /// Interpolation of `trajectory_msgs/JointTrajectory`: between two points positions are linear, or cubic polynomials if both have
    /// velocities, or quintic ones if both also have accelerations. Joints that are not named keep their positions of `rest`.
    ///
    /// Either all times are zero, or each is later than the previous one.
    pub fn from_points(
        robot: &RobotModel,
        joints: &[String],
        points: &[TrajectoryPoint],
        rest: &Configuration,
    ) -> Result<Self, TrajectoryError> {
        Self::from_points_with_direction(robot, joints, points, rest, ContinuousDirection::AsGiven)
    }

    /// As above, with the given direction of continuous joints between points.
    pub fn from_points_with_direction(
        robot: &RobotModel,
        joints: &[String],
        points: &[TrajectoryPoint],
        rest: &Configuration,
        direction: ContinuousDirection,
    ) -> Result<Self, TrajectoryError> {
        if points.len() < 2 {
            return Err(TrajectoryError::TooShort(points.len()));
        }
        let timed = check_times(points)?;
        let named = robot.named_joints(joints.iter().map(String::as_str)).map_err(TrajectoryError::Names)?;
        let configurations = (points.iter().enumerate())
            .map(|(point, p)| {
                check_numbers(points, point, joints)?;
                let refuse = |error| TrajectoryError::Point { point, error };
                check_rates(&named, p).map_err(refuse)?;
                named.configuration(rest, &p.positions).map_err(refuse)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let configurations = directed(robot, configurations, direction)?;
        let segments = (0..points.len() - 1)
            .map(|i| {
                let ends = [&points[i], &points[i + 1]];
                if ends.iter().any(|p| p.velocities.is_empty()) {
                    return Ok(MotionSegment::straight(robot, &configurations[i], &configurations[i + 1]));
                }
                if !timed {
                    return Err(TrajectoryError::NoTimes(i));
                }
                let [from, to] = [&configurations[i], &configurations[i + 1]];
                let bent = polynomials(&named, i, ends, [from, &with_resting_joints(robot, from, to)])?;
                MotionSegment::polynomial(robot, bent)
                    .map_err(|error| TrajectoryError::Segment { segment: i, error })
            })
            .collect::<Result<_, _>>()?;
        let times = if timed { points.iter().map(|p| p.time_from_start).collect() } else { Vec::new() };
        Ok(Self { segments, times, parts: Vec::new() })
    }

    /// The segments, in order.
    #[must_use]
    pub fn segments(&self) -> &[MotionSegment] {
        &self.segments
    }

    /// The same trajectory with each segment changed. For obstacles that move over several segments use [`Self::with_obstacles`].
    pub fn map<E>(self, change: impl FnMut(MotionSegment) -> Result<MotionSegment, E>) -> Result<Self, E> {
        let segments = self.segments.into_iter().map(change).collect::<Result<_, _>>()?;
        Ok(Self { segments, times: self.times, parts: self.parts })
    }

    /// The same trajectory with the times (s) of its points: from 0 on, each later than the one before.
    ///
    /// # Errors
    /// If the times are not so, or obstacles move already: they would move at other times.
    pub fn with_times(self, times: Vec<f64>) -> Result<Self, TrajectoryError> {
        let has_moving =
            |segment: &MotionSegment| !segment.obstacles().is_empty() || segment.uncertainty().is_some();
        if self.segments.iter().any(has_moving) {
            return Err(TrajectoryError::ObstaclesBeforeTimes);
        }
        let (given, expected) = (times.len(), self.segments.len() + 1);
        if given != expected {
            return Err(TrajectoryError::TimeCount { given, expected });
        }
        let previous = std::iter::once(None).chain(times.iter().copied().map(Some));
        for (point, (previous, &time)) in previous.zip(&times).enumerate() {
            check_time(point, time)?;
            if let Some(previous) = previous.filter(|previous| time <= *previous) {
                return Err(TrajectoryError::Time { point, time, previous });
            }
        }
        Ok(Self { times, ..self })
    }

    /// Obstacles of `world` may move as their limits allow, in addition to [`Self::with_obstacles`]. Their poses are those of
    /// the world at `latency` (s) before the time 0 of the trajectory.
    ///
    /// # Errors
    /// If the trajectory has no times, the world has no obstacle of a name in the limits, or a number is negative or not
    /// finite.
    pub fn with_obstacle_limits(
        self,
        world: &World,
        limits: &Arc<ObstacleLimits>,
        latency: f64,
    ) -> Result<Self, TrajectoryError> {
        if self.times.is_empty() {
            return Err(TrajectoryError::NoClock);
        }
        if let Some(name) = limits.by_name.keys().find(|name| world.id(name).is_none()) {
            let error = SegmentError::UnknownObstacle(name.clone());
            return Err(TrajectoryError::Segment { segment: 0, error });
        }
        let limited = |(segment, motion): (usize, MotionSegment)| {
            let time = [segment, segment + 1].map(|point| latency + self.times[point]);
            let uncertainty = ObstacleUncertainty::new(Arc::clone(limits), time);
            let of_segment = |error: LimitError| TrajectoryError::Segment { segment, error: error.into() };
            Ok(motion.with_uncertainty(uncertainty.map_err(of_segment)?))
        };
        let segments = self.segments.into_iter().enumerate().map(limited).collect::<Result<_, _>>()?;
        Ok(Self { segments, times: self.times, parts: self.parts })
    }

    /// A remark if the first point is later than the start of the trajectory.
    #[must_use]
    pub fn late_start_note(&self) -> Option<String> {
        let first = *self.times.first().filter(|time| **time > 0.0)?;
        Some(format!(
            "the first point is at {first} s: how the robot gets there from where it stands is not checked; \
             add that as a point with time_from_start 0"
        ))
    }

    /// Start and end times of segments; a single one without times goes from 0 to 1.
    pub(super) fn clock(&self) -> Result<Vec<f64>, TrajectoryError> {
        match (self.times.as_slice(), self.segments.len()) {
            ([], 1) => Ok(vec![0.0, 1.0]),
            ([], _) => Err(TrajectoryError::NoClock),
            (times, _) => Ok(times.to_vec()),
        }
    }

    /// Seconds from the start at a fraction of a segment; `None` if no times were given.
    #[must_use]
    pub fn time(&self, segment: usize, t: f64) -> Option<f64> {
        let [from, to] = [*self.times.get(segment)?, *self.times.get(segment + 1)?];
        Some(from + t * (to - from))
    }
}

/// Adjusts points so that continuous joints move between them in the given direction.
fn directed(
    robot: &RobotModel,
    points: Vec<Configuration>,
    direction: ContinuousDirection,
) -> Result<Vec<Configuration>, TrajectoryError> {
    if direction == ContinuousDirection::AsGiven {
        return Ok(points);
    }
    let (points, held) = shortest_turns(robot, points).map_err(TrajectoryError::ShortestWay)?;
    match held.into_iter().next() {
        Some(held) => Err(TrajectoryError::Held(held)),
        None => Ok(points),
    }
}

/// The configuration `to`, in which floating joints that rest have the numbers of `from`: their points may differ by rounding, and a
/// quaternion and its negative are the same rotation.
fn with_resting_joints(robot: &RobotModel, from: &Configuration, to: &Configuration) -> Configuration {
    let mut positions = to.positions().to_vec();
    for (_, first) in floating(robot) {
        let places = first..first + 7;
        let start = &from.positions()[places.clone()];
        if is_same_pose(start, &positions[places.clone()]) {
            positions[places].copy_from_slice(start);
        }
    }
    Configuration::trusted(positions)
}

/// True if two poses of a floating joint, three coordinates and a unit quaternion each, differ by no more than rounding.
fn is_same_pose(a: &[f64], b: &[f64]) -> bool {
    let dot: f64 = a[3..].iter().zip(&b[3..]).map(|(a, b)| a * b).sum();
    let sign = 1.0_f64.copysign(dot);
    let is_near = |(i, (a, b)): (usize, (&f64, &f64))| {
        let b = if i < 3 { *b } else { sign * b };
        (a - b).abs() <= LARGEST_ROUNDING * (1.0 + a.abs())
    };
    a.iter().zip(b).enumerate().all(is_near)
}

fn check_time(point: usize, time: f64) -> Result<(), TrajectoryError> {
    if !time.is_finite() {
        return Err(TrajectoryError::TimeNotFinite { point, time });
    }
    if time < 0.0 { Err(TrajectoryError::NegativeTime { point, time }) } else { Ok(()) }
}

/// True if there are times.
fn check_times(points: &[TrajectoryPoint]) -> Result<bool, TrajectoryError> {
    if points.iter().all(|p| p.time_from_start == 0.0) {
        return Ok(false);
    }
    for (point, time) in points.iter().map(|p| p.time_from_start).enumerate() {
        check_time(point, time)?;
    }
    for (i, pair) in points.windows(2).enumerate() {
        let [previous, time] = [pair[0].time_from_start, pair[1].time_from_start];
        if time <= previous {
            return Err(TrajectoryError::Time { point: i + 1, time, previous });
        }
    }
    Ok(true)
}

/// Checks how many numbers a point has, and that those that the motion depends on are finite.
fn check_numbers(points: &[TrajectoryPoint], point: usize, joints: &[String]) -> Result<(), TrajectoryError> {
    let p = &points[point];
    let [uses_velocities, uses_accelerations] = used_rates(points, point);
    let given = [
        ("positions", &p.positions, true),
        ("velocities", &p.velocities, uses_velocities),
        ("accelerations", &p.accelerations, uses_accelerations),
    ];
    for (what, numbers, is_used) in given {
        let needed = what == "positions" || !numbers.is_empty();
        if needed && numbers.len() != joints.len() {
            let (given, expected) = (numbers.len(), joints.len());
            return Err(TrajectoryError::Length { point, what, given, expected });
        }
        if is_used && let Some(i) = numbers.iter().position(|x| !x.is_finite()) {
            return Err(TrajectoryError::NotFinite { point, what, joint: joints[i].clone() });
        }
    }
    Ok(())
}

/// Whether the motion depends on the velocities and on the accelerations of a point: a neighbour must have them, too.
fn used_rates(points: &[TrajectoryPoint], point: usize) -> [bool; 2] {
    let p = &points[point];
    let neighbours = points[..point].last().into_iter().chain(points.get(point + 1));
    let bent: Vec<_> = neighbours.filter(|q| !(p.velocities.is_empty() || q.velocities.is_empty())).collect();
    let is_quintic = |q: &&TrajectoryPoint| !(p.accelerations.is_empty() || q.accelerations.is_empty());
    [!bent.is_empty(), bent.iter().any(is_quintic)]
}

/// Rejects velocities and accelerations of mimic joints that disagree with their leaders, even if they are not used. Drivers that do not
/// know them write NaN.
fn check_rates(named: &NamedJoints, p: &TrajectoryPoint) -> Result<(), ConfigurationError> {
    for (what, values) in [("velocity", &p.velocities), ("acceleration", &p.accelerations)] {
        if !values.is_empty() && values.iter().all(|value| value.is_finite()) {
            named.rates(what, values, 1.0)?;
        }
    }
    Ok(())
}

/// Cubic or quintic polynomials from point `first` to the next, both with velocities, for t from 0 to 1.
fn polynomials(
    named: &NamedJoints,
    first: usize,
    [p, q]: [&TrajectoryPoint; 2],
    [from, to]: [&Configuration; 2],
) -> Result<Vec<[f64; 6]>, TrajectoryError> {
    let seconds = q.time_from_start - p.time_from_start;
    let per_t = |what: &'static str, [a, b]: [&[f64]; 2], scale: f64| {
        let of_point = |point: usize, values: &[f64]| {
            let rates = named.rates(what, values, scale);
            rates.map_err(|error| TrajectoryError::Point { point, error })
        };
        Ok([of_point(first, a)?, of_point(first + 1, b)?])
    };
    let velocities = per_t("velocity", [&p.velocities, &q.velocities], seconds)?;
    let is_cubic = p.accelerations.is_empty() || q.accelerations.is_empty();
    let accelerations = [&p.accelerations[..], &q.accelerations];
    let accelerations = (!is_cubic).then(|| per_t("acceleration", accelerations, seconds * seconds));
    let accelerations = accelerations.transpose()?;
    let piece = |index: usize| {
        let ends = [from.positions()[index], to.positions()[index]];
        // joints that are not named keep their positions
        let at = |rates: &[Vec<Option<f64>>; 2], scale: f64| {
            Some([rates[0][index]? * scale, rates[1][index]? * scale])
        };
        let Some(velocities) = at(&velocities, seconds) else {
            return [ends[0], ends[1] - ends[0], 0.0, 0.0, 0.0, 0.0];
        };
        match accelerations.as_ref().and_then(|rates| at(rates, seconds * seconds)) {
            None => cubic(ends, velocities),
            Some(accelerations) => quintic(ends, velocities, accelerations),
        }
    };
    Ok((0..from.positions().len()).map(piece).collect())
}

/// The cubic polynomial with these ends and slopes at 0 and 1.
fn cubic([a, b]: [f64; 2], [v, w]: [f64; 2]) -> [f64; 6] {
    let d = b - a;
    [a, v, 3.0 * d - 2.0 * v - w, v + w - 2.0 * d, 0.0, 0.0]
}

/// The quintic polynomial with these ends, slopes and second derivatives at 0 and 1.
fn quintic([a, b]: [f64; 2], [v, w]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 6] {
    let d = b - a;
    [
        a,
        v,
        0.5 * x,
        10.0 * d - 6.0 * v - 4.0 * w - 1.5 * x + 0.5 * y,
        -15.0 * d + 8.0 * v + 7.0 * w + 1.5 * x - y,
        6.0 * d - 3.0 * (v + w) - 0.5 * (x - y),
    ]
}

#[cfg(test)]
mod tests {
    use clearance_robot::MeshFiles;
    use proptest::prelude::*;

    use super::*;

    const FLOATING: &str = "<robot name='r'><link name='root'/><link name='body'/><link name='tip'/>
        <joint name='fly' type='floating'><parent link='root'/><child link='body'/></joint>
        <joint name='wheel' type='continuous'><parent link='body'/><child link='tip'/><axis xyz='0 0 1'/></joint>
        </robot>";

    /// The motion through points of a floating joint and a wheel, one second apart, with velocities of zero.
    fn stopping_at(
        points: &[[f64; 8]],
        is_quintic: bool,
        direction: ContinuousDirection,
    ) -> Result<Trajectory, TrajectoryError> {
        let robot = RobotModel::from_urdf(FLOATING, &MeshFiles::default()).unwrap();
        let point = |(positions, time): (&[f64; 8], i32)| TrajectoryPoint {
            positions: positions.to_vec(),
            velocities: vec![0.0; 8],
            accelerations: if is_quintic { vec![0.0; 8] } else { Vec::new() },
            time_from_start: f64::from(time),
        };
        let points: Vec<TrajectoryPoint> = points.iter().zip(0..).map(point).collect();
        let rest = robot.default_configuration();
        Trajectory::from_points_with_direction(&robot, robot.position_names(), &points, &rest, direction)
    }

    proptest! {
        #[test]
        fn floating_joints_may_rest_while_others_move(
            numbers in proptest::array::uniform4(-1.0..1.0_f64),
            scale in 0.9995..1.0005_f64,
            is_quintic in any::<bool>(),
        ) {
            let length = numbers.iter().map(|c| c * c).sum::<f64>().sqrt();
            prop_assume!(length > 0.1);
            let at = |sign: f64, wheel: f64| {
                let [x, y, z, w] = numbers.map(|c| sign * c / length);
                [0.1, -7.0, 3e3, x, y, z, w, wheel]
            };
            let points = [at(1.0, 3.0), at(scale, -3.0), at(-1.0, 2.0), at(-scale, 2.5), at(1.0, 3.0)];
            for direction in [ContinuousDirection::AsGiven, ContinuousDirection::Shortest] {
                let motion = stopping_at(&points, is_quintic, direction).unwrap();
                prop_assert!(Trajectory::of_segments(motion.segments().to_vec()).is_ok());
                for segment in motion.segments() {
                    let [start, later] = [0.0, 0.7].map(|t| segment.at(t));
                    prop_assert_eq!(&start.positions()[..7], &later.positions()[..7]);
                }
                let mut moved = points;
                moved[2][0] += 1e-9;
                let moved = stopping_at(&moved, is_quintic, direction).unwrap_err();
                prop_assert!(moved.to_string().contains("segment 1: floating joint 'fly'"), "{moved}");
            }
        }
    }

    /// Values, slopes and second derivatives at both ends.
    fn ends(p: &[f64; 6]) -> [[f64; 2]; 3] {
        let at_one = [0, 1, 2].map(|order: i32| {
            (p.iter().zip(0..))
                .map(|(c, i)| c * (0..order).map(|k| f64::from(i - k)).product::<f64>())
                .sum::<f64>()
        });
        [[p[0], at_one[0]], [p[1], at_one[1]], [2.0 * p[2], at_one[2]]]
    }

    #[test]
    fn polynomials_meet_their_ends() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let [positions, velocities, _] = ends(&cubic([0.3, -1.1], [2.0, -0.7]));
        assert!(near(positions[1], -1.1) && near(velocities[0], 2.0) && near(velocities[1], -0.7));
        let [positions, velocities, accelerations] = ends(&quintic([0.3, -1.1], [2.0, -0.7], [5.0, -3.0]));
        assert!(near(positions[0], 0.3) && near(positions[1], -1.1));
        assert!(near(velocities[0], 2.0) && near(velocities[1], -0.7));
        assert!(near(accelerations[0], 5.0) && near(accelerations[1], -3.0));
    }
}
