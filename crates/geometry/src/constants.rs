//! Shared numeric constants: tolerances, rounding slacks and limits, each with its unit, reason and source.

/// Distance (m) at or below which two solids count as touching: f64 rounding at robot scale is about 1e-14 m, GJK on
/// curved primitives stops near 1e-10 m, and the shared truth files define contact as a distance of at most 1e-9 m.
pub const CONTACT_DISTANCE: f64 = 1e-9;

/// Slack of a test of two bounding volumes in f32, relative to the coordinates that enter it: 64 units in the last place,
/// about 4 µm a metre (derived at `Relative::of_trees` of clearance-proximity).
pub const VOLUME_SLACK: f64 = 64.0 / 16_777_216.0;

/// Rounding of f64 when one tree is placed in the frame of another, relative to the coordinates used, times four: a test of triangles
/// gets a quarter of the slack.
pub const PLACEMENT_SLACK: f64 = 4.0 * 16.0 * f64::EPSILON;

/// Error of kinematics, per metre of coordinates and per radian of angles used: 45 roundings of f64.
pub const KINEMATICS_ROUNDING: f64 = 1e-14;

/// Allowance (m, and relative) for the rounding of kinematics, motion bounds and distances in the proof that a motion is free: the error
/// of kinematics is 1e-14 m per metre, and that of distances a few roundings, so this is many times larger.
pub const MOTION_SLACK: f64 = 1e-9;

/// The fraction of a volume test's slack allowed as error of a triangle's f32 coordinate: 16 units in the last place of the coordinates
/// used, about 1 µm per metre. Cases that f32 cannot decide within this error are decided in f64.
pub const TRIANGLE_SHARE: f32 = 0.25;

/// Relative margin by which bounding spheres of bodies are enlarged, so that f64 rounding never leaves a point outside.
pub const FIT_SLACK: f64 = 1e-12;

/// Largest coordinate (m) of a model: there the resolution of f64 is 15 nanometres, and products of four coordinates stay far from
/// overflow. Models far from their origin occur (a mesh in geographic coordinates); they cause a warning and are accepted.
pub const LARGEST_COORDINATE: f64 = 1e8;

/// Longest name (bytes) of a robot, link, joint, frame or object.
pub const LONGEST_NAME: usize = 1024;

/// Extent (m) of a mesh above which its unit is probably wrong (millimetres without a scale).
pub const SUSPICIOUS_EXTENT: f64 = 50.0;

/// Distance (m) of a mesh from its origin above which the 32-bit floats of most mesh files have a rounding error of half a millimetre or
/// more.
pub const SUSPICIOUS_DISTANCE: f64 = 8192.0;

/// Deviation of a joint axis' length from 1 above which a warning is issued: files round to four digits.
pub const AXIS_LENGTH_SLACK: f64 = 1e-3;
