//! Declarations of all parameters, and their lookup by name.

use std::sync::LazyLock;

use crate::parameters::declaration::{Access, Declaration, Range, TOPICS};
use crate::parameters::parameter_set::{
    CONTINUOUS_DIRECTIONS, Parameters, STALE_SOURCE_POLICIES, UNKNOWN_OR_WARN, UNKNOWN_SPACES,
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
        || "ros2 param list tells those that it has".to_owned(),
        |known| format!("did you mean '{known}'?"),
    );
    format!("this node has no parameter '{name}'; {meant}")
}

/// All parameters, by name. `config/clearance.yaml` documents the same parameters in more detail; a test compares both.
pub static DECLARATIONS: LazyLock<Vec<Declaration>> = LazyLock::new(|| {
    vec![
        unknown_or_warn(
            "blind_cloud",
            |p| &mut p.blind_cloud,
            "What a cloud or octomap does that shows nothing of the room: it makes the state unknown, or is a warning.",
        ),
        double(
            "check_deadline",
            "s",
            (0.0, 10.0),
            |p| &mut p.check_deadline,
            "Time that one answer may take, beyond which undecided pairs make the state unknown; 0 means as long as it takes.",
        ),
        Declaration {
            range: Range::Point,
            access: Access::Point(|p| &mut p.cloud_crop_max),
            ..described("cloud_crop_max", "m", "Points of clouds beyond this corner are left out.")
        },
        Declaration {
            range: Range::Point,
            access: Access::Point(|p| &mut p.cloud_crop_min),
            ..described("cloud_crop_min", "m", "Points of clouds before this corner are left out.")
        },
        double(
            "cloud_voxel_size",
            "m",
            (0.0, 1.0),
            |p| &mut p.cloud_voxel_size,
            "Edge of the cubes to which clouds are thinned out; 0 turns it off.",
        ),
        Declaration {
            range: Range::Word(CONTINUOUS_DIRECTIONS),
            access: Access::Word(|p| &mut p.continuous_joint_direction),
            ..described(
                "continuous_joint_direction",
                "",
                "Which way round continuous joints go from the current state in ~/check_motion.",
            )
        },
        double(
            "distance_absolute_tolerance",
            "m",
            (0.0, 1.0),
            |p| &mut p.distance_absolute_tolerance,
            "By how much distances may be told too small, for answers in a fraction of the time; 0 means exactly. The larger of this and distance_relative_tolerance counts.",
        ),
        double(
            "distance_limit",
            "m",
            (0.0, 100.0),
            |p| &mut p.distance_limit,
            "Distance beyond which the least distance is not looked for; it is then reported as infinite.",
        ),
        double(
            "distance_relative_tolerance",
            "m/m",
            (0.0, 0.9),
            |p| &mut p.distance_relative_tolerance,
            "By which share of themselves distances may be told too small; the larger of this and distance_absolute_tolerance counts.",
        ),
        double(
            "exact_distance_share",
            "s/s",
            (0.0, 1.0),
            |p| &mut p.exact_distance_share,
            "The share of the time between joint states that exact distances may take; beyond it they are told within a tenth or a millimetre. 0: as long as they take.",
        ),
        double(
            "heartbeat_rate",
            "Hz",
            (0.1, 1000.0),
            |p| &mut p.heartbeat_rate,
            "How often the state is published at least, also when no joint state arrives.",
        ),
        double(
            "influence_distance",
            "m",
            (0.0, 10.0),
            |p| &mut p.influence_distance,
            "Distance up to which every pair is reported with its distance and nearest points.",
        ),
        Declaration {
            range: Range::Prefix,
            access: Access::Text(|p| &mut p.joint_prefix),
            ..described(
                "joint_prefix",
                "",
                "What the names of this robot's joints begin with, before those of its URDF.",
            )
        },
        Declaration {
            range: Range::Prefix,
            access: Access::Text(|p| &mut p.link_prefix),
            ..described(
                "link_prefix",
                "",
                "What the names of this robot's links begin with, before those of its URDF.",
            )
        },
        integer(
            "link_volume_level",
            (-1, 20),
            |p| &mut p.link_volume_level,
            "Level of the hierarchies of which ~/link_volumes shows the boxes; -1 shows none.",
        ),
        double(
            "look_ahead_acceleration",
            "rad/s2",
            (0.0, 10000.0),
            |p| &mut p.look_ahead_acceleration,
            "Acceleration (m/s2 of sliding joints) that joints without a limit of their own are thought capable of.",
        ),
        double(
            "look_ahead_horizon",
            "s",
            (0.0, 10.0),
            |p| &mut p.look_ahead_horizon,
            "How far ahead contacts are looked for from the joint velocities; 0 turns it off.",
        ),
        unknown_or_warn(
            "lost_messages",
            |p| &mut p.lost_messages,
            "What lost messages about the world do: they make the state unknown until a whole scene comes, or are a warning.",
        ),
        double(
            "marker_rate",
            "Hz",
            (0.1, 1000.0),
            |p| &mut p.marker_rate,
            "How often markers are published at most; a change of status publishes them at once.",
        ),
        double(
            "memory_limit",
            "MiB",
            (0.0, 1e9),
            |p| &mut p.memory_limit,
            "Resident memory of the process above which the state is unknown and the node ends with exit code 5; 0 means 2048, a quarter of the machine's or 90 % of the container's, whichever is least.",
        ),
        unknown_or_warn(
            "mimic_contradiction",
            |p| &mut p.mimic_contradiction,
            "What a mimic joint does that is reported elsewhere than its leader takes it: it makes the state unknown, or is a warning.",
        ),
        double(
            "octomap_ttl",
            "s",
            (0.0, 86400.0),
            |p| &mut p.octomap_ttl,
            "Age of an octomap beyond which it says nothing about the world any more; 0 means never.",
        ),
        boolean(
            "pad_self",
            |p| &mut p.pad_self,
            "Whether padding counts between links of the robot too, or against the world only.",
        ),
        double(
            "padding",
            "m",
            (0.0, 1.0),
            |p| &mut p.padding,
            "Safety distance by which every link counts as larger.",
        ),
        Declaration {
            range: Range::Service,
            access: Access::Text(|p| &mut p.planning_scene_service),
            ..described(
                "planning_scene_service",
                "",
                "The service of another node, such as move_group, that is asked for its whole planning scene; none if empty.",
            )
        },
        double(
            "point_cloud_ttl",
            "s",
            (0.01, 86400.0),
            |p| &mut p.point_cloud_ttl,
            "Age of a point cloud beyond which it says nothing about the world any more.",
        ),
        Declaration {
            range: Range::Names(TOPICS),
            access: Access::Texts(|p| &mut p.point_cloud_topics),
            ..described("point_cloud_topics", "", "Topics of point clouds that have to be avoided.")
        },
        double(
            "point_radius",
            "m",
            (0.0, 1.0),
            |p| &mut p.point_radius,
            "Radius of the balls that the points of clouds are.",
        ),
        boolean("publish_markers", |p| &mut p.publish_markers, "Whether markers are published for RViz."),
        Declaration {
            range: Range::Text,
            access: Access::Text(|p| &mut p.record_file),
            ..described(
                "record_file",
                "",
                "The MCAP file to which inputs and answers are recorded; none if empty.",
            )
        },
        double(
            "record_max_duration",
            "s",
            (0.0, 1e9),
            |p| &mut p.record_max_duration,
            "Time after which a recording ends; 0 means never.",
        ),
        double(
            "record_max_size",
            "MB",
            (0.0, 1e9),
            |p| &mut p.record_max_size,
            "Size at which a recording ends; 0 means never.",
        ),
        unknown_or_warn(
            "rejected_obstacle",
            |p| &mut p.rejected_obstacle,
            "What an obstacle that was announced and rejected does: it makes the state unknown, or is a warning.",
        ),
        boolean(
            "require_planning_scene",
            |p| &mut p.require_planning_scene,
            "Whether nothing is known of the world until a message has brought a whole planning scene.",
        ),
        double(
            "self_filter_padding",
            "m",
            (0.0, 1.0),
            |p| &mut p.self_filter_padding,
            "Points of clouds nearer than this to the robot, or to what it holds, are taken for the robot.",
        ),
        double(
            "slowdown_distance_self",
            "m",
            (0.0, 10.0),
            |p| &mut p.slowdown_distance_self,
            "Distance between links below which ~/speed_scale is less than 1; 0 means only when they touch.",
        ),
        double(
            "slowdown_distance_world",
            "m",
            (0.0, 10.0),
            |p| &mut p.slowdown_distance_world,
            "Distance to an obstacle below which ~/speed_scale is less than 1; 0 means only when it is touched.",
        ),
        double(
            "slowdown_reaction_time",
            "s",
            (0.0, 10.0),
            |p| &mut p.slowdown_reaction_time,
            "Time that the robot needs to slow down: what approaches counts as nearer by its way in this time.",
        ),
        integer(
            "slowdown_release_count",
            (1, 1000),
            |p| &mut p.slowdown_release_count,
            "States in a row that have to ask for more speed before ~/speed_scale rises.",
        ),
        integer(
            "slowdown_trigger_count",
            (1, 1000),
            |p| &mut p.slowdown_trigger_count,
            "States in a row that have to ask for less speed before ~/speed_scale falls.",
        ),
        double(
            "stale_after",
            "s",
            (0.001, 3600.0),
            |p| &mut p.stale_after,
            "Age of a joint state beyond which it says nothing about the robot any more.",
        ),
        Declaration {
            range: Range::Word(STALE_SOURCE_POLICIES),
            access: Access::Word(|p| &mut p.stale_source_policy),
            ..described(
                "stale_source_policy",
                "",
                "What becomes of a cloud or octomap that has grown too old.",
            )
        },
        Declaration {
            range: Range::Names("joints"),
            access: Access::Texts(|p| &mut p.transform_joints),
            ..described(
                "transform_joints",
                "",
                "Planar and floating joints whose positions tf tells, instead of joint states.",
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
            "Age of a transform on tf beyond which it says nothing any more.",
        ),
        Declaration {
            range: Range::Word(UNKNOWN_SPACES),
            access: Access::Word(|p| &mut p.unknown_space),
            ..described("unknown_space", "", "What the space that an octomap does not know counts as.")
        },
        boolean(
            "use_realtime_priority",
            |p| &mut p.use_realtime_priority,
            "Whether the threads from joint states to answers run before all others of the machine; counts at the start only.",
        ),
        boolean(
            "use_sim_time",
            |p| &mut p.use_sim_time,
            "Whether time is read from /clock instead of the system's clock.",
        ),
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
