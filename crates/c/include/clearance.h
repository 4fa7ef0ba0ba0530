/* C interface of clearance: collision and distance queries of robots.
 *
 * Units are metres, radians and seconds. Poses and points are in the frame of the robot's root link.
 *
 * Every function that can fail returns a clearance_status. After every other status than CLEARANCE_STATUS_OK, clearance_last_error() has
 * the reason, and results must not be used. Functions that return a value instead return null, 0 or nothing for a null handle.
 *
 * Pointers are null or valid: handles are of this library and not freed, arrays have as many elements as the count beside them says,
 * texts are UTF-8 and end with NUL. They are used during the call only. A null pointer is an error, unless the function says otherwise.
 *
 * Threads: robots, checkers and certificates are immutable, and any number of threads may share them. Each thread needs a
 * clearance_workspace of its own. While a thread changes a world, no other thread may use it. The last error is one of each thread.
 *
 * Made by cbindgen from crates/c/src: do not edit. */

#ifndef CLEARANCE_H
#define CLEARANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CLEARANCE_VERSION_MAJOR 0
#define CLEARANCE_VERSION_MINOR 1
#define CLEARANCE_VERSION_PATCH 0

// Status of a call. After every status but `CLEARANCE_STATUS_OK`, `clearance_last_error` has the reason, and results must not be used.
typedef enum {
  // The call succeeded. A collision is a result, and no error.
  CLEARANCE_STATUS_OK = 0,
  // An argument is null, has a wrong length, or is used in a way that is not allowed: an error of the program.
  CLEARANCE_STATUS_ARGUMENT = 1,
  // The input is rejected: a faulty file, an unknown name, a number that is not finite or out of its range.
  CLEARANCE_STATUS_REJECTED = 2,
  // An error of this library. Objects that the call was to change must not be used any more.
  CLEARANCE_STATUS_INTERNAL = 3,
} clearance_status;

// Verdict on a motion.
typedef enum {
  // Neither a proof nor a contact was found; there is a reason.
  CLEARANCE_VERDICT_UNDECIDED = -1,
  // A pair touches.
  CLEARANCE_VERDICT_CONTACT = 0,
  // Proven free, at every point of the motion.
  CLEARANCE_VERDICT_FREE = 1,
} clearance_verdict;

// Reason why a motion is undecided.
typedef enum {
  // The motion is not undecided.
  CLEARANCE_REASON_NONE = 0,
  // A pair comes nearer than the tolerance, and no contact was found.
  CLEARANCE_REASON_TOLERANCE = 1,
  // A pair may touch within the tracking tolerance.
  CLEARANCE_REASON_TUBE = 2,
  // The time is over.
  CLEARANCE_REASON_DEADLINE = 3,
  // The check was stopped.
  CLEARANCE_REASON_CANCELED = 4,
  // The budget of evaluations is used up.
  CLEARANCE_REASON_BUDGET = 5,
  // The pair is two planes, for which nothing is proven, or numbers are too large for the computation.
  CLEARANCE_REASON_OVERFLOW = 6,
  // The motion has segments that do not join.
  CLEARANCE_REASON_MISMATCH = 7,
} clearance_reason;

// A proof that a motion is free, for one robot in one world: `clearance_verify` checks it with code that is independent of the checker.
// Immutable: any number of threads may use it.
//
// It is the document that `clearance motion --certificate` writes.
typedef struct clearance_certificate clearance_certificate;

// Checks states and motions of a robot in a world. Immutable: any number of threads may use it, each with its own
// `clearance_workspace`. Queries on one state or motion take no lock.
//
// States have all positions of the robot, or with `clearance_checker_options.group` those of the group, in the order of
// `clearance_checker_joint_name`. Joint limits are not checked.
typedef struct clearance_checker clearance_checker;

// A robot: links and joints from URDF, groups and allowed collisions from SRDF, with the meshes. Immutable: any number of threads may
// use it.
//
// Joint positions are in the order of `clearance_robot_joint_name` (rad, m). Mimic joints have no position of their own: they follow
// their leaders. A floating joint `j` has seven positions, `j/trans_x j/trans_y j/trans_z j/rot_x j/rot_y j/rot_z j/rot_w`, a planar
// one three, `j/x j/y j/theta`. All poses are in the frame of the root link.
typedef struct clearance_robot clearance_robot;

// Memory of queries, and of their results: one for each thread, and only one query at a time. A second query at the same time fails with
// `CLEARANCE_STATUS_ARGUMENT`.
//
// A workspace works with every checker, but is fastest with one. Arrays of a result are valid until the next query with the workspace.
typedef struct clearance_workspace clearance_workspace;

// Obstacles around a robot, by name; lengths in metres.
//
// Poses are in the frame of the robot's root link; a null pose is the origin of that frame. Functions that add something reject a name
// that is taken and invalid shapes, and then change nothing. A checker keeps a copy of its world: later changes need
// `clearance_checker_with_world`.
//
// Any number of threads may read a world. While a thread changes it, no other thread may use it.
typedef struct clearance_world clearance_world;

// A value by name: a position (rad, m), a padding (m), a factor.
typedef struct {
  // The name.
  const char *name;
  // The value.
  double value;
} clearance_named_value;

// A state: `n` joint positions (rad, m), in the order of `clearance_checker_joint_name`, or for functions of a robot in that of
// `clearance_robot_joint_name`.
typedef struct {
  // The positions.
  const double *positions;
  // Number of positions.
  size_t n;
} clearance_state;

// A pose. Where a pointer to a pose is null, the pose is the identity.
typedef struct {
  // x, y, z (m).
  double position[3];
  // Unit quaternion x, y, z, w.
  double orientation[4];
} clearance_pose;

// A triangle mesh.
typedef struct {
  // vertex_count x 3 coordinates (m).
  const double *vertices;
  // Number of vertices.
  size_t vertex_count;
  // triangle_count x 3 indices of vertices, from 0.
  const uint32_t *triangles;
  // Number of triangles.
  size_t triangle_count;
} clearance_mesh;

// Points.
typedef struct {
  // count x 3 coordinates (m).
  const double *xyz;
  // Number of points.
  size_t count;
} clearance_points;

// Names of two bodies: links, attached objects or obstacles. In results, both are null if there is no pair.
typedef struct {
  // A link or an attached object.
  const char *a;
  // A link, an attached object or an obstacle.
  const char *b;
} clearance_pair;

// Options of a checker. Start with `clearance_checker_options_default`: options of zeros are rejected, because they check
// nothing. Flags are 0 or 1. Arrays are copied.
typedef struct {
  // Group of the SRDF whose positions are those of a state, in the order of the robot, which `clearance_checker_joint_name` gives;
  // null for all joints of the robot. A mimic joint of the group has no position; without its leader in the group, it stays in place.
  const char *group;
  // Positions (rad, m) of joints outside of the group; the others are at their defaults: 0, or the middle of limits that exclude 0.
  const clearance_named_value *fixed;
  // Number of fixed positions.
  size_t fixed_count;
  // Safety distance (m) of all links against obstacles.
  double padding;
  // Safety distances (m) of individual links, each once, instead of `padding`.
  const clearance_named_value *link_padding;
  // Number of link paddings.
  size_t link_padding_count;
  // Scale factors of individual links.
  const clearance_named_value *link_scale;
  // Number of link scales.
  size_t link_scale_count;
  // Safety distances (m) of individual objects, in addition to that of the links. Objects that the world of
  // `clearance_checker_with_world` does not have lose theirs, also in checkers that are made from that one.
  const clearance_named_value *object_padding;
  // Number of object paddings.
  size_t object_padding_count;
  // Scale factors of individual objects.
  const clearance_named_value *object_scale;
  // Number of object scales.
  size_t object_scale_count;
  // Pairs that may touch, besides those that the world's file or else the SRDF allows.
  const clearance_pair *allowed_collisions;
  // Number of these pairs.
  size_t allowed_collision_count;
  // Pairs that are checked, whatever the world's file or the SRDF allows. Not an attached object and a link that holds or may touch it,
  // two objects that one link holds, or two obstacles: these cannot be checked.
  const clearance_pair *checked_collisions;
  // Number of these pairs.
  size_t checked_collision_count;
  // Padding applies between links, too. Default 0.
  int pad_self;
  // Links are checked against links. Default 1.
  int check_self;
  // Links are checked against obstacles. Default 1.
  int check_world;
  // A closed mesh includes its inside; otherwise meshes are surfaces. Default 0.
  int solid_meshes;
} clearance_checker_options;

// How a link holds an obstacle.
typedef struct {
  // Name of the obstacle.
  const char *object;
  // Name of the link.
  const char *link;
  // Pose of the object in the frame of the link; if it is null, `state` determines it.
  const clearance_pose *pose;
  // State in which the link grasps the object where it is; not used if there is a pose.
  clearance_state state;
  // Links that may touch the object, besides `link`.
  const char *const *touch_links;
  // Number of these links.
  size_t touch_link_count;
} clearance_grasp;

// Many states: `count` rows of `n` joint positions each (rad, m), row by row.
typedef struct {
  // count x n positions.
  const double *positions;
  // Number of states.
  size_t count;
  // Number of positions of a state.
  size_t n;
} clearance_states;

// Distance of two bodies, padding subtracted.
typedef struct {
  // Names of the bodies, valid as long as the checker; null if no pair is within the largest distance.
  clearance_pair pair;
  // Distance (m): 0 for bodies that touch, infinity if there is no pair.
  double distance;
  // Nearest points of the two bodies (m, root frame), without padding; NaN if there is no pair.
  double points[2][3];
} clearance_pair_distance;

// Least distances in one state.
typedef struct {
  // Of two bodies of the robot.
  clearance_pair_distance self_pair;
  // Of a body of the robot and an obstacle.
  clearance_pair_distance world_pair;
} clearance_distances;

// Extent of a report.
typedef struct {
  // Distances of pairs up to this (m) are reported. Default 0.1.
  double max_distance;
  // Number of contacts of each colliding pair; 0 for none. Default 1.
  size_t max_contacts;
} clearance_report_options;

// A contact of two bodies, paddings included.
typedef struct {
  // Names of the bodies, valid as long as the checker.
  clearance_pair pair;
  // Point of the contact (m, root frame).
  double point[3];
  // Unit vector (root frame) along which the second body separates; NaN if it is not known.
  double normal[3];
  // Length (m) of a translation along the normal after which the bodies are apart: the depth, or an upper bound on it; NaN if it is
  // not known.
  double depth;
  // Lower bound (m) on the depth.
  double depth_lower;
  // True for the deepest contact of its pair, whose depth is that of the pair.
  bool is_deepest;
} clearance_contact;

// Report on one state. Arrays are valid until the next query with the workspace.
typedef struct {
  // True only if every pair is proven apart.
  bool is_free;
  // True if two bodies of the robot collide.
  bool self_collision;
  // True if a body of the robot collides with an obstacle.
  bool world_collision;
  // All colliding pairs.
  const clearance_pair *colliding_pairs;
  // Number of colliding pairs.
  size_t colliding_pair_count;
  // Contacts of the colliding pairs, pair by pair, the deepest of each first.
  const clearance_contact *contacts;
  // Number of contacts.
  size_t contact_count;
  // Distances of all pairs within the largest distance.
  const clearance_pair_distance *distances;
  // Number of distances.
  size_t distance_count;
} clearance_report;

// Signed distance of two bodies.
typedef struct {
  // Names of the bodies, valid as long as the checker.
  clearance_pair pair;
  // Signed distance (m, padding subtracted): minus the penetration depth of bodies that overlap.
  double distance;
  // Lower bound (m) on the signed distance; minus infinity if no translation is known that separates the bodies.
  double lower;
  // Upper bound (m) on the signed distance.
  double upper;
  // Nearest points of the two bodies (m, root frame), without padding.
  double points[2][3];
  // Unit vector (root frame) along which the second body moves away from the first; NaN if it is not known.
  double normal[3];
  // True if the nearest points are unique, so that the signed distance has a derivative.
  bool is_unique;
} clearance_pair_clearance;

// Signed distances of near pairs. Arrays are valid until the next query with the workspace.
typedef struct {
  // All pairs within the influence distance.
  const clearance_pair_clearance *pairs;
  // Number of pairs.
  size_t pair_count;
  // pair_count x n derivatives of the signed distances with respect to the positions of the state (m/rad, m/m), row by row; zeros for a
  // pair without normal.
  const double *gradients;
  // Number of positions of a state.
  size_t n;
} clearance_clearance;

// Options of motion checks. Start with `clearance_motion_options_default`. Flags are 0 or 1.
typedef struct {
  // Pairs that stay farther apart than this (m) are always decided. Default 5e-4.
  double tolerance;
  // Time (s) after which a check ends with its results so far. Default infinity.
  double timeout;
  // Number of evaluations of a pair after which a check ends. Default 10 000 000.
  uint64_t budget;
  // Tracking tolerance (rad, m) of each position of a state: the robot may be anywhere within it. Default null: none.
  const double *tube;
  // Number of tracking tolerances: the number of positions, 1 for the same tolerance of every joint, or 0.
  size_t tube_count;
  // The check ends at any contact, not at the earliest. Default 0.
  int any_contact;
  // A motion that is free gets a certificate. Default 0. The search differs: the time of a contact may be another one than without it,
  // and the verdict, too, if a distance is within the tolerance. Both results are right.
  int certificate;
  // Threads of `clearance_checker_are_motions_free`: 0 for all cores, 1 for the calling thread. Default 0.
  size_t threads;
  // Distance (m) that pairs have to keep, besides their paddings: a pair that is not farther apart counts as touching. The first t
  // of a contact is then the time until which all pairs keep it. Default 0.
  double margin;
} clearance_motion_options;

// A straight motion in joint space between two states of `n` positions (rad, m).
//
// Continuous joints move through all positions in between, also by more than half a turn.
typedef struct {
  // n positions at the start.
  const double *from;
  // n positions at the end.
  const double *to;
  // Number of positions.
  size_t n;
} clearance_edge;

// Straight motions in joint space: the k-th is from row k of `from` to row k of `to`.
//
// Continuous joints move through all positions in between, also by more than half a turn.
typedef struct {
  // count x n positions (rad, m).
  const double *from;
  // count x n positions (rad, m).
  const double *to;
  // Number of motions.
  size_t count;
  // Number of positions of a state.
  size_t n;
} clearance_edges;

// Report on a motion.
typedef struct {
  // The verdict: free, contact or undecided.
  clearance_verdict verdict;
  // Why the motion is undecided.
  clearance_reason reason;
  // Contact: the motion is proven free before the first t, and collides at the second. Undecided: it is proven free before the first
  // and after the second, and a part in between is undecided. Free: NaN. t is 0 at the start and 1 at the end of the motion, or of the
  // segment.
  double t[2];
  // The pair that touches, or that is undecided; its names are valid as long as the checker.
  clearance_pair pair;
  // Undecided: bounds on the distance of the pair (m, padding subtracted); otherwise NaN.
  double distance[2];
  // Contact: a common point (m, root frame) at the second t, NaN if none is known.
  double point[3];
  // Trajectory: index of the segment that the verdict refers to; the last one if all are free.
  size_t segment;
  // Trajectory with times: times (s from the start) of t; NaN if it is free.
  double time[2];
  // Number of evaluations of a pair.
  uint64_t evaluations;
  // The proof, if it was asked for and the motion is free; otherwise null. The caller frees it with `clearance_certificate_free`.
  clearance_certificate *certificate;
} clearance_motion_report;

// A trajectory: `count` points, at least two.
//
// Between two points the motion is linear, cubic if there are velocities, quintic if there are accelerations, too, as in
// `trajectory_msgs/JointTrajectory`.
typedef struct {
  // count x n positions (rad, m), row by row.
  const double *positions;
  // Number of points.
  size_t count;
  // Number of positions of a state.
  size_t n;
  // count times (s from the start), each later than the one before; null for a path without times.
  const double *times;
  // count x n velocities (rad/s, m/s), or null.
  const double *velocities;
  // count x n accelerations (rad/s², m/s²), or null; they need velocities.
  const double *accelerations;
  // If not 0, continuous joints go the shortest way.
  int shortest;
} clearance_trajectory;

// Options of searches for the least distances along a motion. Start with `clearance_along_options_default`.
typedef struct {
  // The search ends when lower and upper bound differ by at most this (m). Default 1e-3.
  double absolute_tolerance;
  // The same, relative to the upper bound; the larger of the two applies. Default 0.01.
  double relative_tolerance;
  // Larger distances (m) do not matter: the search ends when the lower bound has reached it. Default infinity.
  double max_distance;
  // Time (s) after which a search ends with its results so far. Default infinity.
  double timeout;
  // Number of evaluations of a pair after which a search ends. Default 10 000 000.
  uint64_t budget;
  // Tracking tolerance (rad, m) of each position of a state: lower bounds hold anywhere within it. Default null: none.
  const double *tube;
  // Number of tracking tolerances: the number of positions, 1 for the same tolerance of every joint, or 0.
  size_t tube_count;
} clearance_along_options;

// Bounds on the least distance of the pairs of one kind along a motion (m, padding subtracted).
typedef struct {
  // Proven: no pair is nearer at any time; 0 if some pair touches, or if nothing is proven. Infinite if no such pairs are checked.
  double lower;
  // Distance of the pair at t: the least distance is not larger. Infinite if there is no pair.
  double upper;
  // The pair at which `upper` is attained; its names are valid as long as the checker.
  clearance_pair pair;
  // Nearest points of the pair (m, root frame), without padding; NaN if there is no pair.
  double points[2][3];
  // Fraction of the motion, or of the segment, at which `upper` is attained; NaN if there is no pair.
  double t;
  // Trajectory: index of the segment.
  size_t segment;
  // Trajectory with times: time (s) from the start; otherwise NaN.
  double time;
} clearance_least_distance;

// The least distances along a motion.
typedef struct {
  // Of two bodies of the robot.
  clearance_least_distance nearest_self;
  // Of the robot and an obstacle.
  clearance_least_distance nearest_world;
  // Why the bounds differ by more than the tolerance, or none.
  clearance_reason reason;
  // Number of evaluations of a pair.
  uint64_t evaluations;
} clearance_motion_distances;

// Expected content of a certificate: options and motion. Start with `clearance_expectation_default`.
typedef struct {
  // Options of the check: they must be the same, without objects that the world does not have. Null for the defaults.
  const clearance_checker_options *options;
  // The motion; a certificate of another motion is rejected. For a straight motion, a path of two states without times. Its states are
  // those of a checker with these options. If it is null, only the proof is checked: then compare the motion in the certificate with
  // yours.
  const clearance_trajectory *motion;
  // Tracking tolerance (rad, m) of the check: one for each position, 1 for the same of all, or none.
  const double *tube;
  // Number of tracking tolerances.
  size_t tube_count;
  // Tolerance (m) of the check; 0 for any.
  double tolerance;
  // Distance (m) that the proof has to keep at least, besides paddings; 0 for any.
  double margin;
} clearance_expectation;

// Result of a verification.
typedef struct {
  // True only if the certificate proves the motion free.
  bool is_valid;
  // Why the certificate is rejected, or null; valid until the next verification in this thread.
  const char *reason;
  // Number of segments that were verified.
  size_t segments;
  // Number of pairs of bodies.
  size_t pairs;
  // Number of proofs.
  size_t proofs;
} clearance_verification;

// Limits of a search for a path. Start with `clearance_plan_options_default`.
typedef struct {
  // Seed of the random states. Default 1.
  uint64_t seed;
  // Time (s) after which the search ends, and the proof of its path. Default infinity.
  double timeout;
  // Number of edges after which the search ends. Default 200 000.
  uint64_t max_edges;
  // Largest length of an edge of the search: the Euclidean norm of all changes (rad, m). Default 1.
  double range;
  // Number of shortcuts that are tried. Default 64.
  uint32_t shortcuts;
  // If not 0, a path gets a certificate. Default 0.
  int certificate;
} clearance_plan_options;

// Result of a search for a path. The states are valid until the next query with the workspace.
typedef struct {
  // True if there is a path. Nothing is proven if none is found.
  bool is_found;
  // `found`, `found_without_certificate`, `start_not_free`, `goal_not_free`, `most_edges` or `deadline`.
  const char *reason;
  // count x n positions (rad, m), from the start to the goal, row by row. The edges between them are proven free.
  const double *states;
  // Number of states; 0 without a path.
  size_t count;
  // Number of positions of a state.
  size_t n;
  // Sum of the Euclidean norms of the changes along all edges (rad, m); 0 without a path.
  double length;
  // Number of edges that were checked.
  uint64_t edges;
  // The proof of all edges, if it was asked for and there is a path; otherwise null. It is also null if the time was over before the
  // proof was complete: then the reason is `found_without_certificate`. The caller frees it with `clearance_certificate_free`.
  clearance_certificate *certificate;
} clearance_plan;

// Limits of a search for a free state. Start with `clearance_recovery_options_default`.
typedef struct {
  // Largest Euclidean norm of all changes (rad, m). Default 0.5.
  double max_distance;
  // Distance (m) that the free state keeps from every collision. Default 0.0001.
  double clearance;
  // Number of checked states after which the search ends. Default 30 000.
  uint64_t max_checks;
  // Time (s) after which the search ends. Default infinity.
  double timeout;
  // Names of joints that stay where they are.
  const char *const *locked;
  // Number of these joints.
  size_t locked_count;
} clearance_recovery_options;

// Result of a search for a free state. The state is valid until the next query with the workspace.
typedef struct {
  // True if there is a free state.
  bool is_found;
  // `found`, `already_free`, `not_movable`, `unfinished` or `beyond_limits`.
  const char *reason;
  // n positions of the free state (rad, m), or null.
  const double *positions;
  // Number of positions of a state.
  size_t n;
  // Euclidean norm of all changes (rad, m); NaN without a free state.
  double distance;
  // The straight motion to the free state is proven free from this t in [0, 1] on; NaN without a free state.
  double exit;
  // A pair that no movable joint moves apart by the clearance, if the reason is `not_movable`; names are valid as long as the checker.
  clearance_pair pair;
  // Number of states that were checked.
  uint64_t checks;
} clearance_free_state;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Text of the last error in this thread; empty if there was none. It names the element and says what to do.
//
// The text is valid until the next failing call in this thread.
const char *clearance_last_error(void);

// Version of the library, such as `0.1.0`.
const char *clearance_version(void);

// Reads a robot. `urdf` and `srdf` are paths, or XML texts; `srdf` may be null.
//
// `package://NAME/path` is searched in the `package_path_count` folders `package_paths`, then beside the URDF and in its parents, then in
// `AMENT_PREFIX_PATH` and `ROS_PACKAGE_PATH`. A xacro file has to be expanded before.
//
// Rejected: every fault of the files; the text names file, line, link and joint. Unusual content that is accepted is among the warnings
// (`clearance_robot_warning`).
clearance_status clearance_robot_from_urdf(const char *urdf,
                                           const char *srdf,
                                           const char *const *package_paths,
                                           size_t package_path_count,
                                           clearance_robot **robot);

// Frees a robot; null is ignored. Worlds and checkers that were made with it stay valid.
void clearance_robot_free(clearance_robot *robot);

// Name of the robot in the URDF. All texts of a robot are valid as long as the robot.
const char *clearance_robot_name(const clearance_robot *robot);

// Number of joint positions of the robot.
size_t clearance_robot_joint_count(const clearance_robot *robot);

// Name of a joint position; null beyond the last.
const char *clearance_robot_joint_name(const clearance_robot *robot, size_t index);

// Number of links.
size_t clearance_robot_link_count(const clearance_robot *robot);

// Name of a link, in the order of the URDF; null beyond the last.
const char *clearance_robot_link_name(const clearance_robot *robot, size_t index);

// Name of the root link, whose frame is the frame of all poses and points.
const char *clearance_robot_root_link(const clearance_robot *robot);

// Number of warnings about unusual content that was accepted.
size_t clearance_robot_warning_count(const clearance_robot *robot);

// Text of a warning; null beyond the last.
const char *clearance_robot_warning(const clearance_robot *robot, size_t index);

// Number of groups of the SRDF.
size_t clearance_robot_group_count(const clearance_robot *robot);

// Name of a group; null beyond the last.
const char *clearance_robot_group_name(const clearance_robot *robot, size_t group);

// Number of joint positions of a group; 0 beyond the last group.
size_t clearance_robot_group_joint_count(const clearance_robot *robot, size_t group);

// Name of a joint position of a group, in the order of the states of a checker of this group; null beyond the last.
const char *clearance_robot_group_joint_name(const clearance_robot *robot,
                                             size_t group,
                                             size_t index);

// Number of group states of the SRDF.
size_t clearance_robot_group_state_count(const clearance_robot *robot);

// Name of a group state as `GROUP/STATE`; null beyond the last.
const char *clearance_robot_group_state_name(const clearance_robot *robot, size_t index);

// Writes the `n` lower and `n` upper limits (rad, m), also of the joints that mimic these; infinite without limit.
//
// `n` is the number of joint positions. Collisions are checked beyond limits, too.
clearance_status clearance_robot_limits(const clearance_robot *robot,
                                        double *lower,
                                        double *upper,
                                        size_t n);

// Writes a state of `n` positions with `count` joints set by name (rad, m).
//
// The others are at 0, or in the middle of limits that exclude 0. A mimic joint moves its leader. Rejected: unknown names.
clearance_status clearance_robot_state(const clearance_robot *robot,
                                       const clearance_named_value *values,
                                       size_t count,
                                       double *positions,
                                       size_t n);

// Writes a group state of the SRDF as a state of `n` positions, those of the whole robot. `name` is `STATE`, or `GROUP/STATE` where
// several groups have a state of this name. Joints that it does not name are at their defaults.
//
// Rejected: unknown, ambiguous and faulty states.
clearance_status clearance_robot_group_state(const clearance_robot *robot,
                                             const char *name,
                                             double *positions,
                                             size_t n);

// Writes `count` random states of `n` positions each, those of the whole robot, uniform between the limits.
//
// `seed` is the state of the random generator, and is updated: the same number gives the same states. Continuous joints are within half
// a turn; prismatic joints without limits are within half a metre. Planar and floating joints keep their default positions.
clearance_status clearance_robot_random_states(const clearance_robot *robot,
                                               uint64_t *seed,
                                               size_t count,
                                               double *positions,
                                               size_t n);

// Writes the poses of all links in the frame of the root link, in the order of `clearance_robot_link_name`; `count` is their number.
//
// `state` has all positions of the robot. Rejected: positions that are not finite.
clearance_status clearance_robot_forward_kinematics(const clearance_robot *robot,
                                                    clearance_state state,
                                                    clearance_pose *poses,
                                                    size_t count);

// Writes the pose of a link in the frame of the root link. `state` has all positions of the robot.
//
// Rejected: an unknown link, and positions that are not finite.
clearance_status clearance_robot_link_pose(const clearance_robot *robot,
                                           clearance_state state,
                                           const char *link,
                                           clearance_pose *pose);

// Makes a world without obstacles.
clearance_status clearance_world_new(clearance_world **world);

// Reads obstacles, attached objects and allowed collisions of a file: the YAML of a MoveIt planning scene, MoveIt's `.scene` text, an
// octree (`.bt`, `.ot`), or a cloud (PCD, PLY).
//
// `robot` gives the frames of its links and resolves the links of attached objects. If it is null, the only frame is `world`, the robot's
// root. `point_radius` (m) is the radius of the balls around the points of a cloud; 0 if the file is none. Unknown space of an octree
// counts as occupied if `unknown_is_occupied` is not 0. Meshes are searched beside the file, and where those of the robot are.
//
// Rejected: every fault of the file, and a `point_radius` or `unknown_is_occupied` for a file of another kind. Unusual content that is
// accepted is among the warnings (`clearance_world_warning`).
clearance_status clearance_world_from_file(const char *path,
                                           const clearance_robot *robot,
                                           double point_radius,
                                           int unknown_is_occupied,
                                           clearance_world **world);

// Makes a copy, which shares the shapes.
clearance_status clearance_world_copy(const clearance_world *world, clearance_world **copy);

// Frees a world; null is ignored. Checkers that were made with it stay valid.
void clearance_world_free(clearance_world *world);

// Number of obstacles.
size_t clearance_world_obstacle_count(const clearance_world *world);

// Name of an obstacle, valid until the world changes; null beyond the last.
const char *clearance_world_obstacle_name(const clearance_world *world, size_t index);

// Number of warnings about unusual content of files that was accepted; copies have none.
size_t clearance_world_warning_count(const clearance_world *world);

// Text of a warning, valid as long as the world; null beyond the last.
const char *clearance_world_warning(const clearance_world *world, size_t index);

// Adds a box with 3 edges `size` (m) along x, y and z, centred at `pose`.
clearance_status clearance_world_add_box(clearance_world *world,
                                         const char *name,
                                         const double *size,
                                         const clearance_pose *pose);

// Adds a sphere (m), centred at `pose`.
clearance_status clearance_world_add_sphere(clearance_world *world,
                                            const char *name,
                                            double radius,
                                            const clearance_pose *pose);

// Adds a cylinder (m) along z, centred at `pose`.
clearance_status clearance_world_add_cylinder(clearance_world *world,
                                              const char *name,
                                              double radius,
                                              double length,
                                              const clearance_pose *pose);

// Adds a capsule (m) along z, centred at `pose`; `length` does not include its half spheres.
clearance_status clearance_world_add_capsule(clearance_world *world,
                                             const char *name,
                                             double radius,
                                             double length,
                                             const clearance_pose *pose);

// Adds a triangle mesh.
clearance_status clearance_world_add_mesh(clearance_world *world,
                                          const char *name,
                                          clearance_mesh mesh,
                                          const clearance_pose *pose);

// Adds a mesh file (STL, OBJ, COLLADA, PLY, glTF); `scale` has a factor for each axis, or is null.
//
// Unusual content that is accepted is among the warnings (`clearance_world_warning`).
clearance_status clearance_world_add_mesh_file(clearance_world *world,
                                               const char *name,
                                               const char *path,
                                               const double *scale,
                                               const clearance_pose *pose);

// Adds solid balls of one `radius` (m) around points, in the frame at `pose`.
//
// Points are kept as 32-bit floats; the radius grows by the largest rounding, so that nothing is lost.
clearance_status clearance_world_add_points(clearance_world *world,
                                            const char *name,
                                            clearance_points points,
                                            double radius,
                                            const clearance_pose *pose);

// Moves an obstacle. Rejected: an unknown name.
clearance_status clearance_world_move(clearance_world *world, const char *name, const clearance_pose *pose);

// Removes an obstacle. Rejected: an unknown name.
clearance_status clearance_world_remove(clearance_world *world, const char *name);

// Options without group, fixed positions, paddings and pairs, that check everything.
clearance_checker_options clearance_checker_options_default(void);

// Makes a checker. A null `world` is empty, null `options` are the defaults. Takes the time to build hierarchies of all meshes.
//
// Rejected: an unknown group, unknown names of links and objects, names that are given twice, paddings and scales out of their range,
// and pairs of `checked_collisions` that cannot be checked. A checker that has no pair of bodies to check has a warning
// (`clearance_checker_warning`).
clearance_status clearance_checker_new(const clearance_robot *robot,
                                       const clearance_world *world,
                                       const clearance_checker_options *options,
                                       clearance_checker **checker);

// Makes the same checker for another world. Hierarchies of links and of obstacles that do not change are shared.
//
// Paddings, scales and pairs of objects that the world does not have are dropped, also in checkers that are made from that one. Links hold
// what is attached in that world, and nothing else. Rejected: a world in which a pair of `checked_collisions` cannot be checked.
clearance_status clearance_checker_with_world(const clearance_checker *checker,
                                              const clearance_world *world,
                                              clearance_checker **with_world);

// Makes a checker in which an obstacle is attached to a link and moves with it.
//
// Rejected: unknown names, and a pair of `checked_collisions` that cannot be checked any more, such as the object and this link.
clearance_status clearance_checker_attach(const clearance_checker *checker,
                                          const clearance_grasp *grasp,
                                          clearance_checker **attached);

// Makes a checker in which the attached object `name` is an obstacle, where it is in `state`.
//
// Rejected: an object that is not attached, and a pair of `checked_collisions` that cannot be checked any more: of two obstacles.
clearance_status clearance_checker_detach(const clearance_checker *checker,
                                          const char *name,
                                          clearance_state state,
                                          clearance_checker **detached);

// Frees a checker; null is ignored. Names of pairs in results were valid until here.
void clearance_checker_free(clearance_checker *checker);

// Makes a copy of the checker's world.
clearance_status clearance_checker_world(const clearance_checker *checker, clearance_world **world);

// Number of warnings about the checker, such as one that has no pair of bodies to check. Those of the robot and of the world are separate.
size_t clearance_checker_warning_count(const clearance_checker *checker);

// Text of a warning, valid as long as the checker; null beyond the last.
const char *clearance_checker_warning(const clearance_checker *checker, size_t index);

// Number of positions of a state.
size_t clearance_checker_joint_count(const clearance_checker *checker);

// Name of a position of a state, valid as long as the checker; null beyond the last.
const char *clearance_checker_joint_name(const clearance_checker *checker, size_t index);

// True if a whole turn of a position changes nothing: a continuous joint without mimic joints that it moves elsewhere. False beyond the
// last.
bool clearance_checker_joint_is_continuous(const clearance_checker *checker,
                                           size_t index);

// Writes the `n` lower and `n` upper limits of a state (rad, m), also of the joints that mimic these; infinite without limit.
clearance_status clearance_checker_limits(const clearance_checker *checker,
                                          double *lower,
                                          double *upper,
                                          size_t n);

// Writes a state of `n` positions with `count` joints set by name (rad, m); the others are at their defaults.
//
// Rejected: unknown names, and joints outside of the group.
clearance_status clearance_checker_state(const clearance_checker *checker,
                                         const clearance_named_value *values,
                                         size_t count,
                                         double *positions,
                                         size_t n);

// Writes the `count` positions of the whole robot for a state of the checker.
clearance_status clearance_checker_expand(const clearance_checker *checker,
                                          clearance_state state,
                                          double *positions,
                                          size_t count);

// Number of pairs of bodies that are checked.
size_t clearance_checker_pair_count(const clearance_checker *checker);

// Names of a pair of bodies that is checked, valid as long as the checker; null beyond the last.
clearance_pair clearance_checker_pair(const clearance_checker *checker, size_t index);

// Makes a workspace for queries of a checker.
clearance_status clearance_workspace_new(const clearance_checker *checker, clearance_workspace **workspace);

// Frees a workspace; null is ignored.
void clearance_workspace_free(clearance_workspace *workspace);

// Whether a state is free of collision: true is proven, every pair is apart, by more than the padding.
//
// Rejected: positions that are not finite.
clearance_status clearance_checker_is_free(const clearance_checker *checker,
                                           clearance_workspace *workspace,
                                           clearance_state state,
                                           bool *is_free);

// Writes for each of many states 1 if it is free, as `clearance_checker_is_free` does, and otherwise 0: `states.count` results.
//
// `threads` is the number of threads; 0 for all cores, 1 for the calling thread with this workspace. Results do not depend on it.
// Rejected: positions that are not finite; the text names the row.
clearance_status clearance_checker_are_free(const clearance_checker *checker,
                                            clearance_workspace *workspace,
                                            clearance_states states,
                                            size_t threads,
                                            uint8_t *are_free);

// Searches for the least distances within the robot, and between robot and world, up to `max_distance` (m).
//
// Rejected: positions that are not finite, and a negative `max_distance`.
clearance_status clearance_checker_distance(const clearance_checker *checker,
                                            clearance_workspace *workspace,
                                            clearance_state state,
                                            double max_distance,
                                            clearance_distances *distances);

// The default extent of a report.
clearance_report_options clearance_report_options_default(void);

// Full report on a state: all colliding pairs, their contacts, and the distances of near pairs. Null `options` are the defaults.
//
// Rejected: positions that are not finite, and a negative `max_distance`.
clearance_status clearance_checker_check(const clearance_checker *checker,
                                         clearance_workspace *workspace,
                                         clearance_state state,
                                         const clearance_report_options *options,
                                         clearance_report *report);

// Signed distances of all pairs up to `influence_distance` (m), with nearest points, normals and derivatives.
//
// Rejected: positions that are not finite, and an `influence_distance` that is no number. If it is negative, only pairs that overlap at
// least as deep are reported.
clearance_status clearance_checker_clearance(const clearance_checker *checker,
                                             clearance_workspace *workspace,
                                             clearance_state state,
                                             double influence_distance,
                                             clearance_clearance *clearance);

// The default options: no tracking tolerance, no time limit, the earliest contact, no certificate.
clearance_motion_options clearance_motion_options_default(void);

// Whether a straight motion is proven free, at every point: false for a contact, or if undecided. `clearance_checker_check_motion` has
// the reason. Null `options` are the defaults; `any_contact` and `certificate` have no effect.
//
// Rejected: positions that are not finite.
clearance_status clearance_checker_is_motion_free(const clearance_checker *checker,
                                                  clearance_workspace *workspace,
                                                  clearance_edge edge,
                                                  const clearance_motion_options *options,
                                                  bool *is_free);

// Writes for each of many straight motions 1 if it is proven free, and otherwise 0: `edges.count` results.
//
// Options as for `clearance_checker_is_motion_free`; `options.threads` is the number of threads. Results do not depend on it, unless
// there is a timeout. Rejected: positions that are not finite; the text names the row.
clearance_status clearance_checker_are_motions_free(const clearance_checker *checker,
                                                    clearance_workspace *workspace,
                                                    clearance_edges edges,
                                                    const clearance_motion_options *options,
                                                    uint8_t *are_free);

// Checks a straight motion. The verdict FREE is a proof for the whole motion. Null `options` are the defaults.
//
// Rejected: positions, tolerances and times that are not finite or out of their range.
clearance_status clearance_checker_check_motion(const clearance_checker *checker,
                                                clearance_workspace *workspace,
                                                clearance_edge edge,
                                                const clearance_motion_options *options,
                                                clearance_motion_report *report);

// Checks a trajectory: the report is on its first segment that is not free, if there is one. Null `options` are the defaults.
//
// Rejected: numbers that are not finite, times that do not increase, fewer than two points.
clearance_status clearance_checker_check_trajectory(const clearance_checker *checker,
                                                    clearance_workspace *workspace,
                                                    const clearance_trajectory *trajectory,
                                                    const clearance_motion_options *options,
                                                    clearance_motion_report *report);

// The default options: no tracking tolerance, no time limit.
clearance_along_options clearance_along_options_default(void);

// Proven bounds on the least distances along a straight motion. Null `options` are the defaults.
//
// Rejected: positions, tolerances and times that are not finite or out of their range.
clearance_status clearance_checker_clearance_along(const clearance_checker *checker,
                                                   clearance_workspace *workspace,
                                                   clearance_edge edge,
                                                   const clearance_along_options *options,
                                                   clearance_motion_distances *distances);

// Proven bounds on the least distances along a trajectory. Null `options` are the defaults.
//
// Rejected: as for `clearance_checker_check_trajectory`.
clearance_status clearance_checker_clearance_along_trajectory(const clearance_checker *checker,
                                                              clearance_workspace *workspace,
                                                              const clearance_trajectory *trajectory,
                                                              const clearance_along_options *options,
                                                              clearance_motion_distances *distances);

// Reads a certificate from JSON text. Rejected: text that is none, and certificates that were altered.
clearance_status clearance_certificate_from_json(const char *json, clearance_certificate **certificate);

// The certificate as one line of JSON, valid as long as the certificate; null if `certificate` is null.
const char *clearance_certificate_to_json(const clearance_certificate *certificate);

// Number of segments of the motion.
size_t clearance_certificate_segment_count(const clearance_certificate *certificate);

// Number of pairs of bodies that are proven apart.
size_t clearance_certificate_pair_count(const clearance_certificate *certificate);

// Frees a certificate; null is ignored.
void clearance_certificate_free(clearance_certificate *certificate);

// An expectation that any motion meets.
clearance_expectation clearance_expectation_default(void);

// Verifies that a certificate proves a motion of this robot in this world free, with code that is independent of the checker.
//
// A null `world` is empty. A certificate that does not prove it is a result, not an error: `is_valid` is false, with a reason.
// Rejected: options and expected motions that a checker would reject, too.
clearance_status clearance_verify(const clearance_certificate *certificate,
                                  const clearance_robot *robot,
                                  const clearance_world *world,
                                  const clearance_expectation *expectation,
                                  clearance_verification *verification);

// The default limits.
clearance_plan_options clearance_plan_options_default(void);

// Searches for a path of straight edges from `ends.from` to `ends.to` whose edges are proven free. Null `options` are the defaults.
//
// RRT-Connect with shortcuts. Only the joints of the checker's states move, within their limits, without passive joints of the SRDF.
// Without a timeout, the same seed gives the same path. Rejected: a start or goal beyond joint limits, planar and floating joints, and a
// path without the certificate that was asked for, unless the time was over.
clearance_status clearance_checker_plan(const clearance_checker *checker,
                                        clearance_workspace *workspace,
                                        clearance_edge ends,
                                        const clearance_plan_options *options,
                                        clearance_plan *plan);

// The default limits.
clearance_recovery_options clearance_recovery_options_default(void);

// Searches for a free state near `state`. Only the joints of the checker's states move, without the locked ones. Floating joints and
// passive joints of the SRDF never move, planar joints only with a group that has them. Null `options` are the defaults. Nothing proves
// that no free state is nearer.
//
// Rejected: unknown joints, and lengths that are negative or not finite.
clearance_status clearance_checker_find_free_state(const clearance_checker *checker,
                                                   clearance_workspace *workspace,
                                                   clearance_state state,
                                                   const clearance_recovery_options *options,
                                                   clearance_free_state *free_state);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CLEARANCE_H */
