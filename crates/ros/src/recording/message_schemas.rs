//! Message schemas (`ros2msg`) that are stored in a recording for its readers.

use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Definitions of common messages: `==== package/msg/Name`, followed by the fields.
const COMMON: &str = include_str!("message_schemas.txt");

macro_rules! ours {
    ($($name:literal)*) => {
        [$((
            concat!("clearance_msgs/msg/", $name),
            include_str!(concat!("../../../../interfaces/clearance_msgs/msg/", $name, ".msg")),
        )),*]
    };
}

const OURS: [(&str, &str); 9] = ours! {
    "BodyPair" "CollisionState" "Contact" "ObstacleState" "ObstacleStates" "PairDistance" "PassedThrough" "SinceHeartbeat"
    "SkippedPairs"
};

/// Definition of each message, by its full name.
static DECLARATIONS: LazyLock<BTreeMap<&'static str, &'static str>> = LazyLock::new(|| {
    let common = COMMON.split("==== ").skip(1).filter_map(|section| section.split_once('\n'));
    common.map(|(name, text)| (name, text.trim_end())).chain(OURS).collect()
});

/// Separator between two messages of a schema.
const RULE: &str = "================================================================================";

/// A `ros2msg` schema: the definition of the message, then the definitions of all messages that it contains.
#[must_use]
pub fn schema(name: &str) -> String {
    let mut names = vec![name.to_owned()];
    let mut text = String::new();
    let mut done = 0;
    while let Some(name) = names.get(done).cloned() {
        let declarations = DECLARATIONS.get(name.as_str()).copied().unwrap_or_default();
        if done > 0 {
            text.extend([RULE, "\nMSG: ", &name.replace("/msg/", "/"), "\n"]);
        }
        text.push_str(declarations);
        text.push('\n');
        for contained in contained(&name, declarations) {
            if !names.contains(&contained) {
                names.push(contained);
            }
        }
        done += 1;
    }
    text
}

/// Full names of the message types of a message's fields.
fn contained(name: &str, declarations: &str) -> Vec<String> {
    let package = name.split('/').next().unwrap_or_default();
    let kinds = declarations.lines().filter_map(|line| line.split('#').next()?.split_whitespace().next());
    let kinds = kinds.map(|kind| kind.split(['[', '<']).next().unwrap_or(kind));
    let full = kinds.map(|kind| match kind.split_once('/') {
        Some((package, kind)) => format!("{package}/msg/{kind}"),
        None => format!("{package}/msg/{kind}"),
    });
    full.filter(|full| DECLARATIONS.contains_key(full.as_str())).collect()
}

#[cfg(test)]
mod tests {
    use ros2_interfaces_jazzy_serde::{moveit_msgs, octomap_msgs, sensor_msgs, std_msgs, tf2_msgs};

    use super::*;
    use crate::messages::clearance_msgs::{CollisionState, ObstacleStates};
    use crate::messages::interface_text::{fields_in_rust, fields_in_text};

    #[test]
    fn a_schema_begins_with_the_message_and_holds_all_that_it_contains() {
        macro_rules! same {
            ($($kind:ty => $name:literal),* $(,)?) => {$(
                let text = schema($name);
                let first = text.split(RULE).next().unwrap();
                assert_eq!(fields_in_rust::<$kind>().replace("type_", "type"), fields_in_text(first), $name);
            )*};
        }
        same! {
            CollisionState => "clearance_msgs/msg/CollisionState",
            ObstacleStates => "clearance_msgs/msg/ObstacleStates",
            sensor_msgs::msg::JointState => "sensor_msgs/msg/JointState",
            sensor_msgs::msg::PointCloud2 => "sensor_msgs/msg/PointCloud2",
            std_msgs::msg::Header => "std_msgs/msg/Header",
            tf2_msgs::msg::TFMessage => "tf2_msgs/msg/TFMessage",
            octomap_msgs::msg::Octomap => "octomap_msgs/msg/Octomap",
            moveit_msgs::msg::CollisionObject => "moveit_msgs/msg/CollisionObject",
            moveit_msgs::msg::AttachedCollisionObject => "moveit_msgs/msg/AttachedCollisionObject",
            moveit_msgs::msg::PlanningScene => "moveit_msgs/msg/PlanningScene",
            moveit_msgs::msg::PlanningSceneWorld => "moveit_msgs/msg/PlanningSceneWorld",
            moveit_msgs::msg::RobotState => "moveit_msgs/msg/RobotState",
        }
        let scene = schema("moveit_msgs/msg/PlanningScene");
        for contained in [
            "sensor_msgs/JointState",
            "octomap_msgs/Octomap",
            "builtin_interfaces/Time",
            "std_msgs/ColorRGBA",
        ] {
            assert_eq!(scene.matches(&format!("\nMSG: {contained}\n")).count(), 1, "{contained}");
        }
    }
}
