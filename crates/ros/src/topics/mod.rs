//! Topics of the node: publishers, subscriptions, and the content of the messages.

pub mod activity; // counters for the diagnostics
pub mod demo_motion; // demonstration motion on `joint_states`
pub mod diagnostics; // content of `/diagnostics`
pub mod evaluation_publishers; // publishers of the evaluations
pub mod latencies; // distribution of response times for the diagnostics
pub mod link_volumes; // `~/link_volumes`
pub mod marker_topic; // `~/markers`, on its own thread
pub mod markers; // content of `~/markers`
pub mod monitored_scene; // `monitored_planning_scene`
pub mod retreat_topic; // `~/retreat_direction`, on its own thread
pub mod scene_requester; // client of the scene service of `move_group`
pub mod scene_topics; // subscriptions of scenes, octomaps, clouds and transforms
pub mod shared_topic; // detects several publishers on a topic
pub mod simulation_clock; // `/clock`
pub mod swept_volume_markers; // content of `~/swept_volume`
pub mod topic_merger; // messages of several topics in the order of reception
pub mod unreceivable_publishers; // warnings about publishers of another type or quality of service
