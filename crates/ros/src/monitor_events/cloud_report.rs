//! Report on the last point cloud of a topic, for the diagnostics.

use std::time::Duration;

/// Diagnostics about the last cloud of one topic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CloudReport {
    /// Number of points that are avoided.
    pub points: usize,
    /// Number of points without a usable position: NaN, infinite, far away, or several at the sensor itself.
    pub not_finite: usize,
    pub cropped: usize,
    pub of_robot: usize,
    /// Time from the reception of the message until a checker contains it.
    pub latency: Duration,
    /// Why the last cloud was rejected, if it was.
    pub fault: Option<String>,
    /// Why the last cloud contains no point of the surroundings, if it contains none.
    pub blind: Option<String>,
}

/// Reports on the point clouds, by topic.
pub type CloudReports = Vec<(String, CloudReport)>;
