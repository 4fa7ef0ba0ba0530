//! The DDS network: participant, topics, services and actions.
//!
//! Other folders use no endpoints of the libraries `ros2_client` and `rustdds`, only message types: `Message`, and the
//! messages of the parameter services.

pub mod action_server; // action server: goals, cancellations, results, feedback
pub mod announcement; // announcement of the participant before its endpoints
pub mod cdr; // CDR encoding and decoding
pub mod client; // service client
pub mod decode_error_log; // rate limiter of log messages about messages that cannot be decoded
pub mod discovery_probe; // probe that learns local Fast DDS participants early
pub mod first_request; // requests of samples that were sent before discovery was complete
pub mod lock; // locks that survive a panic of their holder
pub mod log_line; // lines of the log as messages for `/rosout`
pub mod middleware; // the node on the network; creates all endpoints
pub mod middleware_error; // error of the client library
pub mod peers; // discovery of other nodes
pub mod publisher; // publisher of one topic
pub mod quality; // quality of service
pub mod receive_thread_watch; // detection of receive threads that have ended
pub mod response_fragments; // fragments of long service responses
pub mod response_sender; // service responses of any length
pub mod rtps; // RTPS messages beside the DDS library
pub mod sequence_gaps; // lost messages, by sequence number
pub mod server; // service server
pub mod subscription; // subscription to one topic
pub mod type_name; // names of message, service and action types
pub mod wakeup; // wake-ups of endpoints with data

pub use ros2_client::Message;
pub use ros2_client::builtin_interfaces::Time as Stamp;
