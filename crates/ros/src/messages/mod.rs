//! ROS messages as structs, and conversions that several topics and services use. No I/O.

pub mod clearance_msgs; // the messages of clearance_msgs
pub mod clearance_srvs; // the services and the action of clearance_msgs
pub mod collision_state; // evaluation to `~/state`, pairs and distances to messages
pub mod contact; // contacts to messages
pub mod joint_state; // joint state message to monitor input
pub mod separation; // result of speed and separation monitoring to its message
pub mod time_and_geometry; // times, points, vectors and poses

#[cfg(test)]
pub mod interface_text; // fields of interface files, for tests
