//! Tests of recordings with moving obstacles: the replay moves them again.

use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Twist, Vector3};

use super::*;
use crate::messages::clearance_msgs::{ObstacleState, ObstacleStates};
use crate::scene::command_conversion::states_command;

impl Cell {
    /// The ball is at x and moves along x.
    fn states(&mut self, x: f64, speed: f64) {
        let received_at = self.tick();
        let linear = Vector3 { x: speed, ..Vector3::default() };
        let state = ObstacleState {
            name: "ball".to_owned(),
            pose: ball(x).primitive_poses.remove(0),
            twist: Twist { linear, ..Twist::default() },
        };
        let mut message = ObstacleStates { obstacles: vec![state], ..ObstacleStates::default() };
        message.header.frame_id = "base".to_owned();
        let step = RecordedCommand::Scene {
            by: SceneSource::ObstacleStates,
            received_at: received_at.into(),
            unknown_is_occupied: false,
            lost: 0,
            is_shared: false,
        };
        let command = LoaderCommand::Scene(Box::new(states_command(&message, received_at)));
        self.process(vec![(command, step, Some(OriginalMessage::States(Box::new(message))))], None);
    }

    fn turn_at_rest(&mut self, angle: f64) -> Evaluation {
        let now = self.tick();
        let message = JointState { velocity: vec![0.0], ..joint_state(angle, now) };
        let evaluation = self.monitor.on_joint_state(joint_state_input(message.clone(), SOURCE), now);
        self.monitor.prepare();
        self.publish(evaluation, now, Some(message))
    }
}

/// The ball approaches, rests, and is not seen any more.
#[test]
fn obstacles_move_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    cell.change(|p| (p.look_ahead_horizon, p.look_ahead_acceleration) = (5.0, 0.0));
    cell.transform();
    cell.turn_at_rest(0.3);
    cell.cloud();
    cell.ball(1.9);
    assert!(cell.turn_at_rest(0.3).time_to_contact() >= 5.0);
    let mut times = Vec::new();
    for i in 0..5 {
        cell.states(1.9 - 0.02 * f64::from(i), -1.0);
        times.push(cell.turn_at_rest(0.3).time_to_contact());
    }
    assert!(times.is_sorted_by(|a, b| a > b) && times[0] < 1.0 && times[4] > 0.3, "{times:?}");
    cell.states(1.8, 0.0);
    assert!(cell.turn_at_rest(0.3).time_to_contact() >= 5.0);
    cell.states(1.8, -1.0);
    cell.milliseconds += 1100;
    let evaluation = cell.turn_at_rest(0.3);
    let Status::Unknown(Reason::StaleWorld { source, ttl, .. }) = &evaluation.status else {
        panic!("{:?}", evaluation.status);
    };
    assert_eq!((source.as_str(), *ttl), ("~/obstacle_states of ball", 1.0));
    assert_eq!(evaluation.time_to_contact(), 0.0);
    cell.states(1.8, -1.0);
    assert_eq!(cell.turn_at_rest(0.3).status, Status::Free);
    cell.end();
    let outcome = again(&folder.path().join("record.mcap")).unwrap();
    assert_eq!((outcome.same, outcome.late, outcome.difference), (10, 0, None));
}
