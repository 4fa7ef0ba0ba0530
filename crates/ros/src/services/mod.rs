//! Services and the action of the node. Requests are handled here; the decisions are made by the monitor and the
//! checker.

pub mod action_goals; // goals of an action
pub mod batch_distances; // distances along the motions of a batch
pub mod body_list; // names of bodies in the response to a batch
pub mod enable_service; // `~/enable`
pub mod gradient_rows; // signed distances and derivatives of `~/get_distances`
pub mod motion_batches; // evaluation of `~/check_motions` requests
pub mod motion_distances; // least distances along motions, and the first time within a distance
pub mod motion_requests; // evaluation of motion requests
pub mod motion_services; // `~/check_motion`, `~/check_motions` and `~/check_trajectory`
pub mod parameter_services; // the standard parameter services
pub mod recovery_requests; // evaluation of requests for free states
pub mod request_context; // robot, world and configuration for a request
pub mod request_fields; // validation of single fields of requests
pub mod request_rejection; // reasons for which requests are rejected
mod requested_obstacles; // moving obstacles in motion requests
pub mod scene_services; // `get_planning_scene`, `apply_planning_scene`, `clear_octomap`, `check_state_validity`
pub mod state_requests; // evaluation of state requests
pub mod state_services; // `~/check_states`, `~/get_distances` and `~/find_free_state`
pub mod state_validity; // evaluation of `check_state_validity` requests
pub mod trajectory_action; // `~/check_trajectory` as an action
pub mod validity_contacts; // contacts of `check_state_validity`
