//! Declarations of all parameters, and their lookup by name.

use std::sync::LazyLock;

use crate::parameters::declaration::{Access, Declaration, Range, TOPICS};
use crate::parameters::parameter_set::{
    CONTINUOUS_DIRECTIONS, Parameters, SPEED_MODES, STALE_SOURCE_POLICIES, UNKNOWN_OR_WARN, UNKNOWN_SPACES,
};

/// Declaration of the parameter with this name.
#[must_use]
pub fn declaration_of(name: &str) -> Option<&'static Declaration> {
    DECLARATIONS.iter().find(|d| d.name == name)
}

/// Declaration of the parameter with the most similar name, for misspelled names.
#[must_use]
pub fn similar(name: &str) -> Option<&'static str> {
    const ALIKE: f64 = 0.85;
    let of = |d: &Declaration| (strsim::jaro_winkler(name, d.name), d.name);
    let best = DECLARATIONS.iter().map(of).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > ALIKE).then_some(best.1)
}

pub(super) fn unknown(name: &str) -> String {
    let meant = similar(name).map_or_else(
        || "ros2 param list shows those that it has".to_owned(),
        |known| format!("did you mean '{known}'?"),
    );
    format!("this node has no parameter '{name}'; {meant}")
}

/// All parameters, by name. `config/clearance.yaml` documents the same parameters in more detail; a test compares both.
pub static DECLARATIONS: LazyLock<Vec<Declaration>> = LazyLock::new(|| {
    vec![
        double(
            "between_states_acceleration",
            "rad/s2",
            (0.0, 10000.0),
            |p| &mut p.between_states_acceleration,
            "Largest acceleration (m/s2 for prismatic joints) of the joints between two states; 0: they move along straight lines.",
        ),
        unknown_or_warn(
            "blind_cloud",
            |p| &mut p.blind_cloud,
            "Reaction to a cloud or octomap that contains nothing of the environment: the state is unknown, or a warning.",
        ),
        boolean(
            "check_between_states",
            |p| &mut p.check_between_states,
            "Whether the motion from each evaluated joint state to the next one is checked.",
        ),
        double(
            "check_deadline",
            "s",
            (0.0, 10.0),
            |p| &mut p.check_deadline,
            "Time limit of one check; if it passes with undecided pairs, the state is unknown. 0: no limit.",
        ),
        Declaration {
            range: Range::Point,
            access: Access::Point(|p| &mut p.cloud_crop_max),
            ..described(
                "cloud_crop_max",
                "m",
                "Upper corner of the crop box: points of clouds beyond it are removed.",
            )
        },
        Declaration {
            range: Range::Point,
            access: Access::Point(|p| &mut p.cloud_crop_min),
            ..described(
                "cloud_crop_min",
                "m",
                "Lower corner of the crop box: points of clouds below it are removed.",
            )
        },
        double(
            "cloud_voxel_size",
            "m",
            (0.0, 1.0),
            |p| &mut p.cloud_voxel_size,
            "Edge of the voxels to which clouds are reduced; 0 turns it off.",
        ),
        integer(
            "contacts_per_pair",
            (0, 100),
            |p| &mut p.contacts_per_pair,
            "Largest number of contacts of each colliding pair in ~/state; 0: none. Contacts delay the result: by a few queries of distances for each pair, tens of milliseconds for large meshes, and more for the first contact of a mesh.",
        ),
        Declaration {
            range: Range::Word(CONTINUOUS_DIRECTIONS),
            access: Access::Word(|p| &mut p.continuous_joint_direction),
            ..described(
                "continuous_joint_direction",
                "",
                "Direction in which continuous joints move from the current state in ~/check_motion.",
            )
        },
        double(
            "distance_absolute_tolerance",
            "m",
            (0.0, 1.0),
            |p| &mut p.distance_absolute_tolerance,
            "Largest amount by which reported distances may be too small, for faster checks; 0: exact. The larger of this and distance_relative_tolerance counts.",
        ),
        double(
            "distance_limit",
            "m",
            (0.0, 100.0),
            |p| &mut p.distance_limit,
            "Distance beyond which the least distance is not computed; it is then reported as infinite.",
        ),
        double(
            "distance_relative_tolerance",
            "m/m",
            (0.0, 0.9),
            |p| &mut p.distance_relative_tolerance,
            "The same as a share of the distance; the larger of this and distance_absolute_tolerance counts.",
        ),
        double(
            "exact_distance_share",
            "s/s",
            (0.0, 1.0),
            |p| &mut p.exact_distance_share,
            "Share of the time between joint states that exact distances may take; beyond it, distances have a tolerance of a tenth or a millimetre. 0: no limit.",
        ),
        double(
            "heartbeat_rate",
            "Hz",
            (0.1, 1000.0),
            |p| &mut p.heartbeat_rate,
            "Lowest rate at which the state is published, also without joint states.",
        ),
        double(
            "influence_distance",
            "m",
            (0.0, 10.0),
            |p| &mut p.influence_distance,
            "Distance up to which every pair is reported with its distance and nearest points.",
        ),
        double(
            "joint_noise",
            "rad",
            (0.0, 0.1),
            |p| &mut p.joint_noise,
            "Largest error (m for prismatic joints) of a reported position, in the check between states.",
        ),
        Declaration {
            range: Range::Prefix,
            access: Access::Text(|p| &mut p.joint_prefix),
            ..described(
                "joint_prefix",
                "",
                "Prefix of the names of this robot's joints, before the names of its URDF.",
            )
        },
        Declaration {
            range: Range::Prefix,
            access: Access::Text(|p| &mut p.link_prefix),
            ..described(
                "link_prefix",
                "",
                "Prefix of the names of this robot's links, before the names of its URDF.",
            )
        },
        integer(
            "link_volume_level",
            (-1, 20),
            |p| &mut p.link_volume_level,
            "Level of the bounding volume hierarchies whose volumes ~/link_volumes shows; -1 shows none.",
        ),
        double(
            "look_ahead_acceleration",
            "rad/s2",
            (0.0, 10000.0),
            |p| &mut p.look_ahead_acceleration,
            "Acceleration limit (m/s2 for prismatic joints) of joints without their own limit.",
        ),
        double(
            "look_ahead_horizon",
            "s",
            (0.0, 10.0),
            |p| &mut p.look_ahead_horizon,
            "Time ahead in which contacts are searched from the joint velocities; 0 turns it off.",
        ),
        double(
            "look_ahead_root_acceleration",
            "m/s2",
            (0.0, 1000.0),
            |p| &mut p.look_ahead_root_acceleration,
            "Largest acceleration of the robot's root in tf; 0: no time to contact is known while it moves.",
        ),
        double(
            "look_ahead_root_angular_acceleration",
            "rad/s2",
            (0.0, 1000.0),
            |p| &mut p.look_ahead_root_angular_acceleration,
            "Largest angular acceleration of the robot's root in tf; 0: no time to contact is known while it moves.",
        ),
        unknown_or_warn(
            "lost_messages",
            |p| &mut p.lost_messages,
            "Reaction to lost scene messages: the state is unknown until a whole scene is received, or a warning.",
        ),
        double(
            "marker_rate",
            "Hz",
            (0.1, 1000.0),
            |p| &mut p.marker_rate,
            "Highest rate at which markers are published; a change of status publishes them at once.",
        ),
        double(
            "memory_limit",
            "MiB",
            (0.0, 1e9),
            |p| &mut p.memory_limit,
            "Resident memory of the process above which the state is unknown and the node ends with exit code 5; 0: the least of 2048, a quarter of the machine's memory and 90 % of the container's.",
        ),
        unknown_or_warn(
            "mimic_contradiction",
            |p| &mut p.mimic_contradiction,
            "Reaction to a mimic joint whose reported position differs from the position that its leader implies: the state is unknown, or a warning.",
        ),
        double(
            "obstacle_acceleration",
            "m/s2",
            (0.0, 1000.0),
            |p| &mut p.obstacle_acceleration,
            "Largest acceleration of any point of an obstacle, for ~/time_to_contact and ~/speed_scale; obstacle_limits has limits of single ones.",
        ),
        double(
            "obstacle_latency",
            "s",
            (0.0, 10.0),
            |p| &mut p.obstacle_latency,
            "Time by which the poses of obstacles are older than the joint states.",
        ),
        Declaration {
            range: Range::ObstacleLimits,
            access: Access::Texts(|p| &mut p.obstacle_limits),
            ..described(
                "obstacle_limits",
                "",
                "Limits of single obstacles instead of obstacle_speed and obstacle_acceleration, each as 'NAME SPEED ACCELERATION' in m/s and m/s2.",
            )
        },
        double(
            "obstacle_speed",
            "m/s",
            (0.0, 100.0),
            |p| &mut p.obstacle_speed,
            "Largest speed of any point of an obstacle at the time of the joint state, for ~/time_to_contact, ~/speed_scale and check_between_states; 0 and no acceleration: obstacles stand.",
        ),
        double(
            "obstacle_state_ttl",
            "s",
            (0.01, 86400.0),
            |p| &mut p.obstacle_state_ttl,
            "Age beyond which the last message of ~/obstacle_states about an obstacle that moves is out of date.",
        ),
        double(
            "octomap_ttl",
            "s",
            (0.0, 86400.0),
            |p| &mut p.octomap_ttl,
            "Age beyond which an octomap is out of date; 0: never.",
        ),
        boolean(
            "pad_self",
            |p| &mut p.pad_self,
            "Whether padding also applies between links of the robot, or only between links and obstacles.",
        ),
        double(
            "padding",
            "m",
            (0.0, 1.0),
            |p| &mut p.padding,
            "Safety distance by which every link is enlarged.",
        ),
        Declaration {
            range: Range::Service,
            access: Access::Text(|p| &mut p.planning_scene_service),
            ..described(
                "planning_scene_service",
                "",
                "Service of another node, such as move_group, from which the whole planning scene is requested; none if empty.",
            )
        },
        double(
            "point_cloud_ttl",
            "s",
            (0.01, 86400.0),
            |p| &mut p.point_cloud_ttl,
            "Age beyond which a point cloud is out of date.",
        ),
        Declaration {
            range: Range::Names(TOPICS),
            access: Access::Texts(|p| &mut p.point_cloud_topics),
            ..described("point_cloud_topics", "", "Topics of point clouds that are obstacles.")
        },
        double(
            "point_radius",
            "m",
            (0.0, 1.0),
            |p| &mut p.point_radius,
            "Radius of the ball around each point of a cloud.",
        ),
        boolean("publish_markers", |p| &mut p.publish_markers, "Whether markers are published for RViz."),
        Declaration {
            range: Range::Text,
            access: Access::Text(|p| &mut p.record_file),
            ..described(
                "record_file",
                "",
                "MCAP file to which inputs and results are recorded; none if empty.",
            )
        },
        double(
            "record_max_duration",
            "s",
            (0.0, 1e9),
            |p| &mut p.record_max_duration,
            "Time after which a recording ends; 0: never.",
        ),
        double(
            "record_max_size",
            "MB",
            (0.0, 1e9),
            |p| &mut p.record_max_size,
            "Size at which a recording ends; 0: never.",
        ),
        unknown_or_warn(
            "rejected_obstacle",
            |p| &mut p.rejected_obstacle,
            "Reaction to an obstacle that was received and rejected: the state is unknown, or a warning.",
        ),
        boolean(
            "require_planning_scene",
            |p| &mut p.require_planning_scene,
            "Whether the world is unknown until a whole planning scene is received.",
        ),
        double(
            "retreat_rate",
            "Hz",
            (0.0, 100.0),
            |p| &mut p.retreat_rate,
            "Highest rate at which ~/retreat_direction is computed while the robot collides; 0 turns it off.",
        ),
        double(
            "self_filter_padding",
            "m",
            (0.0, 1.0),
            |p| &mut p.self_filter_padding,
            "Points of clouds nearer than this to the robot or its attached objects are treated as points of the robot.",
        ),
        double(
            "slowdown_distance_self",
            "m",
            (0.0, 10.0),
            |p| &mut p.slowdown_distance_self,
            "Distance between links below which ~/speed_scale is less than 1; 0: only in contact.",
        ),
        double(
            "slowdown_distance_world",
            "m",
            (0.0, 10.0),
            |p| &mut p.slowdown_distance_world,
            "Distance to an obstacle below which ~/speed_scale is less than 1; 0: only in contact.",
        ),
        double(
            "slowdown_reaction_time",
            "s",
            (0.0, 10.0),
            |p| &mut p.slowdown_reaction_time,
            "Time that the robot needs to slow down: the distance of an approaching pair is reduced by its motion in this time.",
        ),
        integer(
            "slowdown_release_count",
            (1, 1000),
            |p| &mut p.slowdown_release_count,
            "Number of successive states that must request more speed before ~/speed_scale rises.",
        ),
        integer(
            "slowdown_trigger_count",
            (1, 1000),
            |p| &mut p.slowdown_trigger_count,
            "Number of successive states that must request less speed before ~/speed_scale falls.",
        ),
        Declaration {
            range: Range::Word(SPEED_MODES),
            access: Access::Word(|p| &mut p.speed_mode),
            ..described(
                "speed_mode",
                "",
                "Rule of ~/speed_scale for obstacles: slow-down and stop distance, or speed and separation monitoring (ISO/TS 15066).",
            )
        },
        double(
            "ssm_acceleration",
            "m/s2",
            (0.0, 1000.0),
            |p| &mut p.ssm_acceleration,
            "Largest acceleration of any point of the robot that commands may cause; 0: unknown, and motion away counts as rest.",
        ),
        double(
            "ssm_deceleration",
            "m/s2",
            (0.0, 1000.0),
            |p| &mut p.ssm_deceleration,
            "Deceleration that every point of the robot reaches when it brakes; must be above 0 for speed_mode ssm.",
        ),
        double(
            "ssm_human_speed",
            "m/s",
            (0.0, 10.0),
            |p| &mut p.ssm_human_speed,
            "Speed at which a person may approach the robot.",
        ),
        double(
            "ssm_human_uncertainty",
            "m",
            (0.0, 10.0),
            |p| &mut p.ssm_human_uncertainty,
            "Position uncertainty of the person, Z_d.",
        ),
        double(
            "ssm_intrusion_distance",
            "m",
            (0.0, 10.0),
            |p| &mut p.ssm_intrusion_distance,
            "Intrusion distance, C: how far a body part reaches into the sensing field before it is detected.",
        ),
        double(
            "ssm_reaction_time",
            "s",
            (0.0, 10.0),
            |p| &mut p.ssm_reaction_time,
            "Time from a motion in the environment until the robot begins to brake; must be above 0 for speed_mode ssm.",
        ),
        Declaration {
            range: Range::ObstacleSpeeds,
            access: Access::Texts(|p| &mut p.ssm_obstacle_speeds),
            ..described(
                "ssm_obstacle_speeds",
                "",
                "Speeds at which single obstacles may approach instead of ssm_human_speed, each as 'NAME SPEED' in m/s. A * at the end of a name stands for any text.",
            )
        },
        Declaration {
            range: Range::Names("obstacles"),
            access: Access::Texts(|p| &mut p.ssm_resting_obstacles),
            ..described(
                "ssm_resting_obstacles",
                "",
                "Obstacles that are no persons: slow-down and stop distance apply to them in speed_mode ssm. A * at the end stands for any text.",
            )
        },
        double(
            "ssm_robot_speed",
            "m/s",
            (0.0, 20.0),
            |p| &mut p.ssm_robot_speed,
            "Largest speed of any point of the robot that commands may request before they are scaled; must be above 0 for speed_mode ssm.",
        ),
        double(
            "ssm_robot_uncertainty",
            "m",
            (0.0, 10.0),
            |p| &mut p.ssm_robot_uncertainty,
            "Position uncertainty of the robot, Z_r.",
        ),
        double(
            "stale_after",
            "s",
            (0.001, 3600.0),
            |p| &mut p.stale_after,
            "Age beyond which a joint state is out of date.",
        ),
        Declaration {
            range: Range::Word(STALE_SOURCE_POLICIES),
            access: Access::Word(|p| &mut p.stale_source_policy),
            ..described("stale_source_policy", "", "Reaction to a cloud or octomap that is out of date.")
        },
        Declaration {
            range: Range::Names("joints"),
            access: Access::Texts(|p| &mut p.transform_joints),
            ..described(
                "transform_joints",
                "",
                "Planar and floating joints whose positions come from tf, instead of joint states.",
            )
        },
        double(
            "stop_distance_self",
            "m",
            (0.0, 10.0),
            |p| &mut p.stop_distance_self,
            "Distance between links up to which ~/speed_scale is 0.",
        ),
        double(
            "stop_distance_world",
            "m",
            (0.0, 10.0),
            |p| &mut p.stop_distance_world,
            "Distance to an obstacle up to which ~/speed_scale is 0.",
        ),
        double(
            "transform_ttl",
            "s",
            (0.001, 3600.0),
            |p| &mut p.transform_ttl,
            "Age beyond which a transform on tf is out of date.",
        ),
        Declaration {
            range: Range::Word(UNKNOWN_SPACES),
            access: Access::Word(|p| &mut p.unknown_space),
            ..described("unknown_space", "", "Treatment of the unknown space of an octomap.")
        },
        boolean(
            "use_realtime_priority",
            |p| &mut p.use_realtime_priority,
            "Whether the threads that receive, check and publish joint states have realtime priority; read at the start only.",
        ),
        boolean(
            "use_sim_time",
            |p| &mut p.use_sim_time,
            "Whether time is read from /clock instead of the system clock.",
        ),
        Declaration {
            range: Range::Volumes,
            access: Access::Text(|p| &mut p.volumes),
            ..described(
                "volumes",
                "",
                "Kind of bounding volumes of all bodies, and of individual links as LINK=KIND, separated by commas: obb, rss, lss, pss, aabb, kdop18 or kios. No result depends on them.",
            )
        },
    ]
});

/// Declaration with only name, unit and meaning.
fn described(name: &'static str, unit: &'static str, description: &'static str) -> Declaration {
    boolean(name, |p| &mut p.use_sim_time, description).in_unit(unit)
}

fn double(
    name: &'static str,
    unit: &'static str,
    (from, to): (f64, f64),
    field: fn(&mut Parameters) -> &mut f64,
    description: &'static str,
) -> Declaration {
    Declaration { name, unit, description, range: Range::Double { from, to }, access: Access::Double(field) }
}

fn integer(
    name: &'static str,
    (from, to): (i64, i64),
    field: fn(&mut Parameters) -> &mut i64,
    description: &'static str,
) -> Declaration {
    Declaration {
        name,
        unit: "",
        description,
        range: Range::Integer { from, to },
        access: Access::Integer(field),
    }
}

fn unknown_or_warn(
    name: &'static str,
    field: fn(&mut Parameters) -> &mut &'static str,
    description: &'static str,
) -> Declaration {
    let range = Range::Word(UNKNOWN_OR_WARN);
    Declaration { name, unit: "", description, range, access: Access::Word(field) }
}

fn boolean(
    name: &'static str,
    field: fn(&mut Parameters) -> &mut bool,
    description: &'static str,
) -> Declaration {
    Declaration { name, unit: "", description, range: Range::Bool, access: Access::Bool(field) }
}
