//! Log lines on stderr.

use log::LevelFilter;

/// Sets up the log. The DDS library is heard only when something is wrong: it warns of every datagram over 1500 bytes, and
/// on an interface without multicast of every message.
pub fn start(level: LevelFilter) {
    let quiet = level.min(LevelFilter::Warn);
    let very_quiet = level.min(LevelFilter::Error);
    let started = env_logger::Builder::new()
        .filter_level(level)
        .filter_module("rustdds", very_quiet)
        .filter_module("ros2_client", quiet)
        // it misses ROS_DISTRO, which says nothing about the peers
        .filter_module("ros2_client::distributions", very_quiet)
        .format_timestamp_millis()
        .format_target(false)
        .try_init();
    if started.is_err() {
        log::debug!("the log was set up before");
    }
}
