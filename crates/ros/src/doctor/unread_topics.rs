//! Scene topics of which `clearance doctor` checks only the type and quality of service.

use crate::dds::middleware::Middleware;
use crate::dds::quality::Quality;
use crate::dds::subscription::Subscription;
use crate::dds::type_name::TypeName;
use crate::names::Names;
use crate::node_error::NodeError;

/// The node's topics of obstacles, but for point clouds.
const TOPICS: [(&str, &str, &str, Quality); 7] = [
    ("planning_scene", "moveit_msgs", "PlanningScene", Quality::Reliable),
    ("planning_scene_world", "moveit_msgs", "PlanningSceneWorld", Quality::Reliable),
    ("collision_object", "moveit_msgs", "CollisionObject", Quality::Reliable),
    ("attached_collision_object", "moveit_msgs", "AttachedCollisionObject", Quality::Reliable),
    ("~/obstacle_states", "clearance_msgs", "ObstacleStates", Quality::BestEffort),
    ("octomap_binary", "octomap_msgs", "Octomap", Quality::ReliableBulk),
    ("octomap_full", "octomap_msgs", "Octomap", Quality::ReliableBulk),
];

/// Subscribes as the node does: while the subscriptions exist, the middleware warns of publishers of another type or of
/// an incompatible quality. Their messages are never decoded.
pub fn subscribe(
    middleware: &Middleware,
    names: &Names,
    point_cloud_topics: &[String],
) -> Result<Vec<Subscription<()>>, NodeError> {
    let clouds =
        point_cloud_topics.iter().map(|name| (name.as_str(), "sensor_msgs", "PointCloud2", Quality::Bulk));
    let open = |(name, package, kind, quality): (&str, &'static str, &'static str, Quality)| {
        let name = names.resolve(name)?;
        Ok(middleware.subscription(&name, TypeName::new(package, kind), quality)?)
    };
    TOPICS.into_iter().chain(clouds).map(open).collect()
}
