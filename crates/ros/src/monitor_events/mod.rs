//! Data between the monitor thread and the other threads.

pub mod cloud_report; // report on the last point cloud of a topic
pub mod current_evaluation; // the last evaluation
pub mod monitor_event; // events that the monitor thread receives
pub mod world_update; // progress of scene messages
