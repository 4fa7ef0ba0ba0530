//! Every tolerance: its unit, its reason, its source.

/// Distance (m) at or below which two solids count as touching: f64 rounding at robot scale is about 1e-14 m, GJK on
/// curved primitives stops near 1e-10 m, and the shared truth files define contact as a distance of at most 1e-9 m.
pub const CONTACT_DISTANCE: f64 = 1e-9;

/// Slack of a test of two bounding volumes in f32, relative to the coordinates that enter it: 64 units in the last place,
/// about 4 µm a metre (derived at `Relative::of_trees` of clearance-proximity).
pub const VOLUME_SLACK: f64 = 64.0 / 16_777_216.0;

/// Rounding of f64 in placing one tree in the frame of another, relative to the coordinates that enter, four times over:
/// a test of triangles gets a quarter of the slack.
pub const PLACEMENT_SLACK: f64 = 4.0 * 16.0 * f64::EPSILON;

/// What kinematics may be off by, for every metre of coordinates and every radian of angles that enter: 45 roundings of f64.
pub const KINEMATICS_ROUNDING: f64 = 1e-14;

/// Room (m, and relative) for the rounding of kinematics, motion bounds and distances when a motion is proven free: kinematics are
/// good to 1e-14 m a metre, distances to a few roundings, so this is many times over.
pub const MOTION_SLACK: f64 = 1e-9;

/// The share of a volume test's slack that a triangle's f32 coordinate may be off by: 16 units in the last place of the
/// coordinates that enter, about 1 µm a metre. What f32 cannot decide within this is decided in f64.
pub const TRIANGLE_SHARE: f32 = 0.25;

/// Relative slack by which spheres around bodies are widened, so that f64 rounding never leaves a point outside.
pub const FIT_SLACK: f64 = 1e-12;

/// Largest coordinate (m) that a model may hold: there f64 still tells 15 nanometres apart, and products of four
/// coordinates stay far from overflow. Models far from their origin are met (a mesh in geographic coordinates); they
/// are told, not refused.
pub const LARGEST_COORDINATE: f64 = 1e8;

/// Longest name (bytes) of a robot, link, joint, frame or object.
pub const LONGEST_NAME: usize = 1024;

/// Extent (m) of a mesh beyond which its unit is probably wrong (millimetres without a scale).
pub const SUSPICIOUS_EXTENT: f64 = 50.0;

/// Distance (m) of a mesh from its origin beyond which the 32-bit floats of most mesh files round to half a millimetre
/// or more.
pub const SUSPICIOUS_DISTANCE: f64 = 8192.0;

/// How far from 1 the length of a joint's axis may be before that is told: files round to four digits.
pub const AXIS_LENGTH_SLACK: f64 = 1e-3;
