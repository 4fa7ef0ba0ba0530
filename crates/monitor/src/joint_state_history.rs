//! History of joint states. Places and self-filters a point cloud with the robot pose at the cloud's stamp.

use std::collections::VecDeque;
use std::sync::{Arc, Weak};

use clearance_geometry::math::without_whole_turns;
use clearance_robot::{Configuration, JointKind, RobotModel};

use super::{Evaluation, JointStateInput, Monitor, Time};

/// Length of the history (s).
const LONGEST: f64 = 3.0;

/// Shortest time (s) between two stored values.
const STEP: f64 = 0.002;

/// Positions of one robot by the stamps of their joint states. Each position has its own history, since drivers measure
/// at different times.
#[derive(Debug, Default)]
pub struct JointStateHistory {
    /// Weak reference: a replaced robot model is not kept in memory for the history.
    robot: Weak<RobotModel>,
    positions: Vec<PositionHistory>,
    /// The clock at the last evaluation.
    clock: Option<Time>,
}

/// History of one position.
#[derive(Debug, Default)]
struct PositionHistory {
    values: VecDeque<(Time, f64)>,
    /// Whether positions that differ by a full turn are equivalent.
    turns: bool,
    /// Whether values must not be interpolated, as for the quaternion of a floating joint.
    is_stepped: bool,
}

impl JointStateHistory {
    /// Stores the configuration of an evaluation that was made at a time of the clock. A clock that is set back begins another history.
    pub fn note(&mut self, evaluation: &Evaluation, ros: Option<Time>) {
        if self.clock.zip(ros).is_some_and(|(before, ros)| before.seconds_since(ros) > STEP) {
            *self = Self::default();
        }
        self.clock = ros;
        let Evaluation {
            stamp: Some(stamp), robot_state: Some(robot_state), revision: Some(revision), ..
        } = evaluation
        else {
            return;
        };
        let robot = revision.checker.robot();
        if self.robot.as_ptr() != Arc::as_ptr(robot) {
            *self = Self { robot: Arc::downgrade(robot), positions: PositionHistory::of(robot), clock: ros };
        }
        let placed_at = |index: &usize| robot_state.placed_at.iter().find(|at| at.positions.contains(index));
        let values = robot_state.configuration.positions().iter().zip(&robot_state.measured).enumerate();
        for (history, (index, (position, measured))) in self.positions.iter_mut().zip(values) {
            let stamp_of = measured.or_else(|| Some(placed_at(&index)?.stamp));
            history.note(stamp_of.unwrap_or(*stamp), *position);
        }
    }

    /// Stores the measured positions of a joint state that is received at a time of the clock, but not evaluated. A joint state with a stamp
    /// in the future is left out, and so are mimic joints: their leaders count, if they are given.
    pub fn note_received(&mut self, input: &JointStateInput, monitor: &Monitor, ros: Option<Time>) {
        let Some((robot, positions)) = monitor.measured_positions(input) else { return };
        let is_of_the_past = ros.is_some_and(|ros| input.stamp <= ros) && input.stamp > Time::default();
        if !is_of_the_past || self.robot.as_ptr() != Arc::as_ptr(robot) {
            return;
        }
        for (index, position) in positions {
            self.positions[index].note(input.stamp, position);
        }
    }

    /// The robot and its configuration at a time. Each position is interpolated linearly between the values before and
    /// after it; before the first and after the last value it is constant. `None` where nothing is known.
    #[must_use]
    pub fn at(&self, time: Time) -> Option<(Arc<RobotModel>, Configuration)> {
        let robot = self.robot.upgrade()?;
        let positions: Option<Vec<f64>> = self.positions.iter().map(|history| history.at(time)).collect();
        Some((robot, Configuration::trusted(positions?)))
    }

    /// Whether the configuration at a time is known. Nothing is known about the motion between values more than `longest_gap` (s) apart.
    #[must_use]
    pub fn coverage(&self, time: Time, longest_gap: f64) -> Coverage {
        let each = self.positions.iter().map(|history| history.coverage(time, longest_gap));
        each.max().unwrap_or(Coverage::Known)
    }
}

/// Coverage of a time by the history of joint states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Coverage {
    /// The configuration is known.
    Known,
    /// The history begins later.
    Before,
    /// Some position was not evaluated for too long.
    Gap,
}

impl PositionHistory {
    fn of(robot: &RobotModel) -> Vec<Self> {
        let new = |turns| Self { turns, ..Self::default() };
        let mut positions: Vec<Self> = robot.whole_turns().into_iter().map(new).collect();
        for id in robot.joint_ids().filter(|id| robot.joint(*id).kind == JointKind::Floating) {
            let count = robot.joint(id).kind.position_suffixes().len();
            if let Some(first) = robot.first_position(id) {
                positions[first..first + count].iter_mut().for_each(|history| history.is_stepped = true);
            }
        }
        positions
    }

    fn note(&mut self, stamp: Time, value: f64) {
        let since = self.values.back().map(|(last, _)| stamp.seconds_since(*last));
        if since.is_some_and(|since| since < -LONGEST) {
            // the clock was set back; the values of a publisher that lags slightly behind another add nothing
            self.values.clear();
        } else if since.is_some_and(|since| since < STEP) {
            return;
        }
        self.values.push_back((stamp, value));
        // the last value before the kept time remains: it shows that what follows is a pause
        while self.values.get(1).is_some_and(|(second, _)| stamp.seconds_since(*second) > LONGEST) {
            self.values.pop_front();
        }
    }

    fn at(&self, time: Time) -> Option<f64> {
        let after = self.values.partition_point(|(stamp, _)| *stamp <= time);
        let before = after.checked_sub(1).and_then(|before| self.values.get(before));
        match (before, self.values.get(after)) {
            (Some((from, a)), Some((to, b))) => {
                Some(self.between((*a, *b), time.seconds_since(*from) / to.seconds_since(*from)))
            }
            (Some((_, only)), None) | (None, Some((_, only))) => Some(*only),
            (None, None) => None,
        }
    }

    fn coverage(&self, time: Time, longest_gap: f64) -> Coverage {
        let after = self.values.partition_point(|(stamp, _)| *stamp <= time);
        let Some((before, _)) = after.checked_sub(1).and_then(|before| self.values.get(before)) else {
            return Coverage::Before;
        };
        let next = self.values.get(after).map_or(time, |(next, _)| *next);
        if next.seconds_since(*before) <= longest_gap { Coverage::Known } else { Coverage::Gap }
    }

    /// Interpolates linearly between two values.
    fn between(&self, (a, b): (f64, f64), share: f64) -> f64 {
        if self.is_stepped {
            return if share < 0.5 { a } else { b };
        }
        let way = if self.turns { without_whole_turns(b - a) } else { b - a };
        a + share * way
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::time::Duration;

    use super::*;
    use crate::{MonitorSettings, Now, Revision, SourceId};
    use clearance_checker::CollisionChecker;
    use clearance_robot::MeshFiles;
    use clearance_scene::Settings;
    use clearance_scene::World;

    /// A continuous joint and a prismatic joint.
    const URDF: &str = "<robot name='r'><link name='a'/><link name='b'/><link name='c'><collision><geometry><sphere radius='1'/></geometry></collision></link>
        <joint name='turn' type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint>
        <joint name='slide' type='prismatic'><parent link='b'/><child link='c'/><axis xyz='1 0 0'/><limit lower='-9' upper='9' effort='1' velocity='1'/></joint></robot>";

    fn revision() -> Arc<Revision> {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
        Arc::new(Revision::new(checker, 1, 0))
    }

    /// A time 1 s and some milliseconds after the epoch.
    fn time(milliseconds: i64) -> Time {
        Time::from_nanoseconds((1000 + milliseconds) * 1_000_000)
    }

    fn monitor(revision: &Arc<Revision>) -> Monitor {
        let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
        monitor.set_checker(Arc::clone(revision));
        monitor
    }

    fn received(monitor: &mut Monitor, milliseconds: i64, joints: &[(&str, f64)]) -> Evaluation {
        let stamp = time(milliseconds);
        let (names, positions) =
            joints.iter().map(|(name, position)| ((*name).to_owned(), *position)).unzip();
        let source = SourceId([u8::try_from(joints.len()).unwrap() + u8::from(joints[0].0 == "turn"); 16]);
        let input = JointStateInput { source, stamp, names, positions, velocities: Vec::new() };
        monitor.on_joint_state(input, Now { ros: Some(stamp), steady: Duration::ZERO })
    }

    fn evaluated(revision: &Arc<Revision>, milliseconds: i64, [turn, slide]: [f64; 2]) -> Evaluation {
        received(&mut monitor(revision), milliseconds, &[("turn", turn), ("slide", slide)])
    }

    #[test]
    fn joint_states_that_are_passed_over_count() {
        let (revision, mut history) = (revision(), JointStateHistory::default());
        let mut monitor = monitor(&revision);
        let both = |turn: f64| [("turn", turn), ("slide", 0.0)];
        history.note(&received(&mut monitor, 0, &both(0.0)), None);
        for (milliseconds, turn) in [(100, 1.0), (200, 1.0), (250, f64::NAN), (5000, 7.0)] {
            let names = vec!["turn".to_owned(), "none".to_owned()];
            let (source, stamp) = (SourceId([3; 16]), time(milliseconds));
            let input =
                JointStateInput { source, stamp, names, positions: vec![turn, 0.0], velocities: Vec::new() };
            history.note_received(&input, &monitor, Some(time(300)));
        }
        history.note(&received(&mut monitor, 300, &both(0.0)), None);
        let turn = |milliseconds| history.at(time(milliseconds)).unwrap().1.positions()[0];
        assert_eq!([0, 50, 100, 150, 200, 250, 300].map(turn), [0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0]);
    }

    #[test]
    fn nothing_is_known_in_a_long_gap() {
        use Coverage::{Before, Gap, Known};
        let (revision, mut joint_state_history) = (revision(), JointStateHistory::default());
        let mut monitor = monitor(&revision);
        for milliseconds in [0, 100, 700, 800] {
            let joints = [("turn", 0.0), ("slide", 0.0)];
            joint_state_history.note(&received(&mut monitor, milliseconds, &joints), None);
        }
        let coverage = |milliseconds| joint_state_history.coverage(time(milliseconds), 0.5);
        let found = [-1, 50, 101, 400, 699, 700, 1300, 1301].map(coverage);
        assert_eq!(found, [Before, Known, Gap, Gap, Gap, Known, Known, Gap]);
        assert_eq!(joint_state_history.coverage(time(400), 0.61), Known);
        // a pause longer than the history is kept
        for milliseconds in [8000, 8100] {
            let joints = [("turn", 0.0), ("slide", 0.0)];
            joint_state_history.note(&received(&mut monitor, milliseconds, &joints), None);
        }
        let found = [700, 801, 7999, 8050].map(|at| joint_state_history.coverage(time(at), 0.5));
        assert_eq!(found, [Before, Gap, Gap, Known]);
    }

    #[test]
    fn each_driver_has_times_of_its_own() {
        let (revision, mut joint_state_history) = (revision(), JointStateHistory::default());
        let mut monitor = monitor(&revision);
        for i in 0..100 {
            let milliseconds = 10 * i;
            #[expect(clippy::cast_precision_loss, reason = "few")]
            let position = 1e-3 * milliseconds as f64;
            if i % 40 == 0 {
                joint_state_history.note(&received(&mut monitor, milliseconds, &[("slide", position)]), None);
            }
            joint_state_history.note(&received(&mut monitor, milliseconds, &[("turn", position)]), None);
        }
        let (_, told) = joint_state_history.at(time(605)).unwrap();
        let apart = told.positions().iter().map(|position| (position - 0.605).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-12, "{told:?}");
    }

    #[test]
    fn the_robot_was_between_where_it_was_before_and_after() {
        let (revision, mut joint_state_history) = (revision(), JointStateHistory::default());
        let robot = Arc::clone(revision.checker.robot());
        assert!(joint_state_history.at(time(0)).is_none());
        // past half a turn, where an encoder wraps around
        for (milliseconds, positions) in [(0, [3.0, 0.0]), (100, [3.2 - TAU, 1.0]), (200, [3.4 - TAU, 1.0])] {
            joint_state_history.note(&evaluated(&revision, milliseconds, positions), None);
        }
        for (milliseconds, expected) in [
            (-500, [3.0, 0.0]),
            (0, [3.0, 0.0]),
            (25, [3.05, 0.25]),
            (75, [3.15, 0.75]),
            (150, [3.3 - TAU, 1.0]),
            (200, [3.4 - TAU, 1.0]),
            (900, [3.4 - TAU, 1.0]),
        ] {
            let (of, told) = joint_state_history.at(time(milliseconds)).unwrap();
            assert!(Arc::ptr_eq(&of, &robot));
            let apart = told.positions().iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-12, "{told:?} at {milliseconds} ms");
        }
    }

    #[test]
    fn it_has_an_end_and_begins_anew_when_the_clock_is_set_back() {
        let (revision, mut joint_state_history) = (revision(), JointStateHistory::default());
        for milliseconds in 0..10_000 {
            joint_state_history.note(&evaluated(&revision, milliseconds, [0.0, 0.0]), None);
        }
        let counts = |joint_state_history: &JointStateHistory| {
            joint_state_history.positions.iter().map(|history| history.values.len()).collect::<Vec<_>>()
        };
        assert!(
            counts(&joint_state_history).iter().all(|count| (1400..1600).contains(count)),
            "{:?}",
            counts(&joint_state_history)
        );
        let before = counts(&joint_state_history);
        joint_state_history.note(&evaluated(&revision, 9_900, [0.0, 1.0]), None);
        assert_eq!(counts(&joint_state_history), before, "who lags behind");
        joint_state_history.note(&evaluated(&revision, 0, [0.0, 1.0]), None);
        assert_eq!(counts(&joint_state_history), [1, 1]);
        joint_state_history.note(&evaluated(&self::revision(), 100, [0.0, 1.0]), None);
        assert_eq!(counts(&joint_state_history), [1, 1], "another robot");
    }
}
