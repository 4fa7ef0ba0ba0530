//! Where the robot was lately: what a sensor has seen, it saw from where its link was at that time, and of the robot as it stood then.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::Arc;

use super::{Judgement, Time};
use crate::robot::{Configuration, JointKind, RobotModel};

/// Time (s) that is remembered.
const LONGEST: f64 = 3.0;

/// Time (s) between two places that are remembered, at least.
const STEP: f64 = 0.002;

/// Configurations of one robot by the stamps of its joint states. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Trail {
    robot: Option<Arc<RobotModel>>,
    places: VecDeque<(Time, Arc<Configuration>)>,
}

impl Trail {
    /// Takes note of where the robot was judged to be.
    pub fn note(&mut self, judgement: &Judgement) {
        let Judgement { stamp: Some(stamp), placement: Some(placement), revision: Some(revision), .. } =
            judgement
        else {
            return;
        };
        let robot = revision.checker.robot();
        if !self.is_of(robot) {
            *self = Self { robot: Some(Arc::clone(robot)), places: VecDeque::new() };
        }
        let since = self.places.back().map(|(last, _)| stamp.seconds_since(*last));
        if since.is_some_and(|since| since < -STEP) {
            // the clock was set back
            self.places.clear();
        } else if since.is_some_and(|since| since < STEP) {
            return;
        }
        self.places.push_back((*stamp, Arc::new(placement.configuration.clone())));
        while self.places.front().is_some_and(|(first, _)| stamp.seconds_since(*first) > LONGEST) {
            self.places.pop_front();
        }
    }

    fn is_of(&self, robot: &Arc<RobotModel>) -> bool {
        self.robot.as_ref().is_some_and(|known| Arc::ptr_eq(known, robot))
    }

    /// Where the robot was at a time: on the straight way between the places before and after it, or at the first or last one; `None` where
    /// nothing is known of this robot.
    #[must_use]
    pub fn at(&self, robot: &Arc<RobotModel>, time: Time) -> Option<Configuration> {
        if !self.is_of(robot) {
            return None;
        }
        let after = self.places.partition_point(|(stamp, _)| *stamp <= time);
        let before = after.checked_sub(1).and_then(|before| self.places.get(before));
        match (before, self.places.get(after)) {
            (Some((from, a)), Some((to, b))) => {
                Some(between(robot, (a, b), time.seconds_since(*from) / to.seconds_since(*from)))
            }
            (Some((_, only)), None) | (None, Some((_, only))) => Some(Configuration::clone(only)),
            (None, None) => None,
        }
    }
}

/// Where a share of the straight way between two configurations leads; of a floating joint, the nearer of the two.
fn between(robot: &RobotModel, (a, b): (&Configuration, &Configuration), share: f64) -> Configuration {
    let nearer = if share < 0.5 { a } else { b };
    let mut positions = nearer.positions().to_vec();
    for id in robot.joint_ids() {
        let joint = robot.joint(id);
        let Some(first) = robot.first_position(id).filter(|_| joint.kind != JointKind::Floating) else {
            continue;
        };
        for (i, name) in joint.kind.position_suffixes().iter().enumerate() {
            let (from, to) = (a.positions()[first + i], b.positions()[first + i]);
            let mut way = to - from;
            if matches!(joint.kind, JointKind::Continuous(_)) || name.ends_with("theta") {
                // whole turns change nothing
                way -= TAU * (way / TAU).round();
            }
            positions[first + i] = from + share * way;
        }
    }
    Configuration::trusted(positions)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::checker::{CollisionChecker, Settings};
    use crate::monitor::{JointStateInput, Monitor, MonitorSettings, Now, Revision, SourceId};
    use crate::robot::MeshFiles;
    use crate::world::World;

    /// A joint that turns without end, and one that slides.
    const URDF: &str = "<robot name='r'><link name='a'/><link name='b'/><link name='c'><collision><geometry><sphere radius='1'/></geometry></collision></link>
        <joint name='turn' type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint>
        <joint name='slide' type='prismatic'><parent link='b'/><child link='c'/><axis xyz='1 0 0'/><limit lower='-9' upper='9' effort='1' velocity='1'/></joint></robot>";

    fn revision() -> Arc<Revision> {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
        Arc::new(Revision::new(checker, 1, 0))
    }

    /// A second and some after the epoch.
    fn time(milliseconds: i64) -> Time {
        Time::from_nanoseconds((1000 + milliseconds) * 1_000_000)
    }

    fn judged(revision: &Arc<Revision>, milliseconds: i64, positions: [f64; 2]) -> Judgement {
        let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
        monitor.set_checker(Arc::clone(revision));
        let (stamp, names) = (time(milliseconds), ["turn", "slide"].map(str::to_owned).to_vec());
        let (source, positions) = (SourceId([1; 16]), positions.to_vec());
        let input = JointStateInput { source, stamp, names, positions, velocities: Vec::new() };
        monitor.on_joint_state(input, Now { ros: Some(stamp), steady: Duration::ZERO })
    }

    #[test]
    fn the_robot_was_between_where_it_was_before_and_after() {
        let (revision, mut trail) = (revision(), Trail::default());
        let robot = Arc::clone(revision.checker.robot());
        assert_eq!(trail.at(&robot, time(0)), None);
        // past half a turn, where an encoder begins anew
        for (milliseconds, positions) in [(0, [3.0, 0.0]), (100, [3.2 - TAU, 1.0]), (200, [3.4 - TAU, 1.0])] {
            trail.note(&judged(&revision, milliseconds, positions));
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
            let told = trail.at(&robot, time(milliseconds)).unwrap();
            let apart = told.positions().iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-12, "{told:?} at {milliseconds} ms");
        }
        assert_eq!(trail.at(self::revision().checker.robot(), time(0)), None, "another robot");
    }

    #[test]
    fn it_has_an_end_and_begins_anew_when_the_clock_is_set_back() {
        let (revision, mut trail) = (revision(), Trail::default());
        for milliseconds in 0..10_000 {
            trail.note(&judged(&revision, milliseconds, [0.0, 0.0]));
        }
        assert!((1400..1600).contains(&trail.places.len()), "{}", trail.places.len());
        trail.note(&judged(&revision, 0, [0.0, 1.0]));
        assert_eq!(trail.places.len(), 1);
    }
}
