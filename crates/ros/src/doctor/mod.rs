//! `clearance doctor`: receives from the ROS network for a limited time, and reports the causes that keep the node from
//! working.

pub mod examination; // order of the checks
pub mod finding; // result of one check
pub mod network_checks; // checks of the network
pub mod received_topics; // reception of the topics
pub mod topic_checks; // checks of the received topics
pub mod unread_topics; // topics of which only the type and quality matter
