/* Errors of the C interface: the status, and a text that names the element. */

#include <clearance.h>
#include <float.h>
#include <stdlib.h>

#include "checks.h"

#define ARGUMENT CLEARANCE_STATUS_ARGUMENT
#define REJECTED CLEARANCE_STATUS_REJECTED
#define N 7

static clearance_robot *robot;
static clearance_world *world;
static clearance_checker *checker;
static clearance_workspace *workspace;

static const char *const URDF = "urdf/demo_arm/demo_arm.urdf";
static const double HOME[N] = {0, -0.5, 0, -2.2, 0, 1.7, 0};

static void check_robots(void) {
  clearance_robot *none = NULL;
  double q[8];
  CHECK_FAILS(clearance_robot_from_urdf(NULL, NULL, NULL, 0, &none), ARGUMENT, "urdf is null");
  CHECK_FAILS(clearance_robot_from_urdf(URDF, NULL, NULL, 0, NULL), ARGUMENT, "robot is null");
  CHECK_FAILS(clearance_robot_from_urdf(URDF, NULL, NULL, 2, &none), ARGUMENT, "package_paths is null");
  CHECK_FAILS(clearance_robot_from_urdf("no/such.urdf", NULL, NULL, 0, &none), REJECTED, "no/such.urdf");
  CHECK_FAILS(clearance_robot_from_urdf("", NULL, NULL, 0, &none), REJECTED, "urdf is empty: give a path or XML text");
  CHECK_FAILS(clearance_robot_from_urdf(URDF, " ", NULL, 0, &none), REJECTED, "srdf is empty: give a path or XML text");
  CHECK_FAILS(clearance_robot_from_urdf(URDF, "no/such.srdf", NULL, 0, &none), REJECTED, "no/such.srdf");
  CHECK_FAILS(clearance_robot_from_urdf("<robot name='r'><link name='l'/><link name='l'/></robot>", NULL, NULL, 0, &none), REJECTED, "'l'");
  CHECK_FAILS(clearance_robot_from_urdf("caf\xe9.urdf", NULL, NULL, 0, &none), ARGUMENT, "urdf is not UTF-8");
  CHECK(none == NULL);
  CHECK_OK(clearance_robot_from_urdf("<robot name='r'><link name='l'/></robot>", NULL, NULL, 0, &none));
  CHECK(none != NULL && clearance_robot_joint_count(none) == 0);
  clearance_robot_free(none);

  CHECK(clearance_robot_name(NULL) == NULL && clearance_robot_joint_count(NULL) == 0 && clearance_robot_link_name(NULL, 0) == NULL);
  CHECK_TEXT(clearance_last_error(), "robot is null");
  const clearance_named_value unknown = {"elbow", 0.0}, nan = {"joint2", NAN}, unnamed = {NULL, 0.0};
  CHECK_FAILS(clearance_robot_state(robot, &unknown, 1, q, 8), REJECTED, "'elbow'");
  CHECK_FAILS(clearance_robot_state(robot, &nan, 1, q, 8), REJECTED, "'joint2'");
  CHECK_FAILS(clearance_robot_state(robot, &unnamed, 1, q, 8), ARGUMENT, "values[0].name is null");
  CHECK_FAILS(clearance_robot_state(robot, NULL, 0, q, 5), ARGUMENT, "positions has room for 5, but must have for 8");
  CHECK_FAILS(clearance_robot_state(robot, NULL, 0, NULL, 8), ARGUMENT, "positions is null");
  CHECK_FAILS(clearance_robot_group_state(robot, "folded", q, 8), REJECTED, "'folded'");
  uint64_t seed = 1;
  CHECK_FAILS(clearance_robot_random_states(robot, &seed, 1, q, 7), ARGUMENT, "n is 7, but the robot has 8");
  CHECK_FAILS(clearance_robot_random_states(robot, NULL, 1, q, 8), ARGUMENT, "seed is null");
  CHECK_FAILS(clearance_robot_random_states(robot, &seed, 1, NULL, 8), ARGUMENT, "positions is null");
  CHECK_FAILS(clearance_robot_random_states(robot, &seed, SIZE_MAX, q, 8), ARGUMENT, "positions can not have");
  CHECK(seed == 1);
  const char *const lost = "<robot name='r'><link name='l'><collision><geometry><mesh filename='package://none/m.stl'/></geometry></collision></link></robot>";
  CHECK_FAILS(clearance_robot_from_urdf(lost, NULL, NULL, 0, &none), REJECTED, "package_paths of clearance_robot_from_urdf");
  CHECK(strstr(clearance_last_error(), "--") == NULL);
  clearance_pose pose;
  const clearance_state state = {q, 8}, short_state = {q, 3};
  memset(q, 0, sizeof q);
  CHECK_FAILS(clearance_robot_link_pose(robot, state, "tail", &pose), REJECTED, "no link 'tail'; it has base");
  CHECK_FAILS(clearance_robot_link_pose(robot, short_state, "hand", &pose), ARGUMENT, "state has 3 positions, but must have 8");
}

static void check_worlds(void) {
  clearance_world *none = NULL;
  const double size[3] = {0.1, 0.1, 0.1}, flat[3] = {0.1, -0.1, 0.1}, scale[3] = {1, NAN, 1};
  const double xyz[6] = {0, 0, 0, 0, NAN, 0};
  const uint32_t triangle[3] = {0, 1, 9};
  const clearance_mesh mesh = {xyz, 2, triangle, 1};
  const clearance_points points = {xyz, 2}, no_points = {NULL, 0}, lost = {NULL, 2}, huge = {xyz, SIZE_MAX};
  const clearance_pose tilted = {{0, 0, 0}, {0, 0, 0, 0.5}}, nowhere = {{INFINITY, 0, 0}, {0, 0, 0, 1}};
  CHECK_FAILS(clearance_world_from_file("no/world.yaml", robot, 0.0, 0, &none), REJECTED, "no/world.yaml");
  CHECK_FAILS(clearance_world_from_file(NULL, robot, 0.0, 0, &none), ARGUMENT, "path is null");
  CHECK_FAILS(clearance_world_from_file("config/demo_world.yaml", NULL, 0.0, 0, &none), REJECTED, "read without a robot");
  CHECK_FAILS(clearance_world_from_file("config/demo_world.yaml", robot, 0.1, 0, &none), REJECTED, "point_radius has no effect");
  CHECK_FAILS(clearance_world_from_file("config/demo_world.yaml", robot, NAN, 0, &none), REJECTED, "point_radius has no effect");
  CHECK_FAILS(clearance_world_from_file("config/demo_world.yaml", robot, 0.0, 1, &none), REJECTED, "unknown_is_occupied has no effect");
  CHECK_FAILS(clearance_world_from_file("tests/worlds/cloud_ascii.pcd", robot, 0.0, 0, &none), REJECTED, "needs a point_radius");
  CHECK_FAILS(clearance_world_from_file("tests/worlds/cloud_ascii.pcd", robot, NAN, 0, &none), REJECTED, "NaN");
  CHECK(none == NULL);
  CHECK_FAILS(clearance_world_add_box(NULL, "b", size, NULL), ARGUMENT, "world is null");
  CHECK_FAILS(clearance_world_add_box(world, NULL, size, NULL), ARGUMENT, "name is null");
  CHECK_FAILS(clearance_world_add_box(world, "b", NULL, NULL), ARGUMENT, "obstacle 'b': size is null");
  CHECK_FAILS(clearance_world_add_box(world, "b", flat, NULL), REJECTED, "obstacle 'b'");
  CHECK_FAILS(clearance_world_add_box(world, "table", size, NULL), REJECTED, "'table'");
  CHECK_FAILS(clearance_world_add_box(world, "b", size, &tilted), REJECTED, "length 0.5");
  CHECK_FAILS(clearance_world_add_box(world, "b", size, &tilted), REJECTED, "obstacle 'b'");
  CHECK_FAILS(clearance_world_move(world, "table", &nowhere), REJECTED, "obstacle 'table'");
  CHECK_FAILS(clearance_world_add_box(world, "b", size, &nowhere), REJECTED, "position");
  CHECK_FAILS(clearance_world_add_sphere(world, "s", NAN, NULL), REJECTED, "obstacle 's'");
  CHECK_FAILS(clearance_world_add_mesh(world, "m", mesh, NULL), REJECTED, "obstacle 'm'");
  CHECK_FAILS(clearance_world_add_mesh_file(world, "m", "no/mesh.stl", NULL, NULL), REJECTED, "no/mesh.stl");
  CHECK(strstr(clearance_last_error(), "--package-path") == NULL);
  CHECK_FAILS(clearance_world_add_mesh_file(world, "m", "urdf/demo_arm/meshes/hand.stl", scale, NULL), REJECTED, "obstacle 'm'");
  CHECK_FAILS(clearance_world_add_points(world, "p", points, 0.1, NULL), REJECTED, "point 1");
  CHECK_FAILS(clearance_world_add_points(world, "p", no_points, 0.1, NULL), REJECTED, "there are no points");
  CHECK_FAILS(clearance_world_add_points(world, "p", lost, 0.1, NULL), ARGUMENT, "points.xyz is null");
  CHECK_FAILS(clearance_world_add_points(world, "p", huge, 0.1, NULL), ARGUMENT, "points.xyz can not have");
  CHECK_FAILS(clearance_world_move(world, "chair", NULL), REJECTED, "'chair'");
  CHECK_FAILS(clearance_world_remove(world, "chair"), REJECTED, "'chair'");
}

/* Names of a world are valid until it changes, and are arguments of the call that changes it. */
static void check_names_of_worlds(void) {
  clearance_world *own = NULL;
  const double size[3] = {0.1, 0.1, 0.1};
  const clearance_pose pose = {{1, 0, 0}, {0, 0, 0, 1}};
  CHECK_OK(clearance_world_new(&own));
  CHECK_OK(clearance_world_add_box(own, "a name that is longer than a small string", size, NULL));
  CHECK_OK(clearance_world_add_box(own, "another name that is longer than a small string", size, NULL));
  const char *first = clearance_world_obstacle_name(own, 0);
  CHECK_FAILS(clearance_world_add_sphere(own, "ball", -1.0, NULL), REJECTED, "'ball'");
  CHECK_FAILS(clearance_world_add_box(own, first, size, NULL), REJECTED, "a name that is longer");
  CHECK_FAILS(clearance_world_remove(own, "chair"), REJECTED, "'chair'");
  CHECK(first == clearance_world_obstacle_name(own, 0));
  CHECK_TEXT(first, "longer than a small string");
  CHECK_OK(clearance_world_move(own, first, &pose));
  for (size_t count = 2; count > 0; --count) {
    CHECK(clearance_world_obstacle_count(own) == count);
    CHECK_OK(clearance_world_remove(own, clearance_world_obstacle_name(own, 0)));
  }
  CHECK(clearance_world_obstacle_count(own) == 0 && clearance_world_obstacle_name(own, 0) == NULL);
  clearance_world_free(own);
}

/* A checker without a pair of bodies calls every state free: it has a warning. */
static void check_warnings_of_checkers(void) {
  clearance_checker *nothing = NULL, *something = NULL, *again = NULL;
  clearance_world *empty = NULL;
  clearance_checker_options options = clearance_checker_options_default();
  const clearance_checker_options zeros = {0};
  options.check_self = 0;
  CHECK_OK(clearance_world_new(&empty));
  CHECK_FAILS(clearance_checker_new(robot, world, &zeros, &nothing), REJECTED, "clearance_checker_options_default");
  CHECK_OK(clearance_checker_new(robot, empty, &options, &nothing));
  CHECK(clearance_checker_pair_count(nothing) == 0 && clearance_checker_warning_count(nothing) == 1);
  CHECK_TEXT(clearance_checker_warning(nothing, 0), "no pair of bodies to check");
  CHECK(clearance_checker_warning(nothing, 1) == NULL);
  CHECK_OK(clearance_checker_with_world(nothing, world, &something));
  CHECK(clearance_checker_pair_count(something) > 0 && clearance_checker_warning_count(something) == 0);
  CHECK_OK(clearance_checker_with_world(something, empty, &again));
  CHECK(clearance_checker_warning_count(again) == 1 && clearance_checker_warning_count(checker) == 0);
  CHECK(clearance_checker_warning_count(NULL) == 0);
  clearance_checker_free(nothing);
  clearance_checker_free(something);
  clearance_checker_free(again);

  /* a state without positions has no length that limits the number of states */
  clearance_robot *fixed = NULL;
  clearance_checker *lifeless = NULL;
  uint8_t free[1] = {0};
  uint64_t seed = 1;
  const clearance_states states = {NULL, SIZE_MAX, 0}, one = {NULL, 1, 0};
  const clearance_edges edges = {NULL, NULL, SIZE_MAX, 0};
  CHECK_OK(clearance_robot_from_urdf("<robot name='r'><link name='l'/></robot>", NULL, NULL, 0, &fixed));
  CHECK_OK(clearance_checker_new(fixed, NULL, NULL, &lifeless));
  CHECK_FAILS(clearance_checker_are_free(lifeless, workspace, states, 1, free), ARGUMENT, "are_free can not have");
  CHECK_FAILS(clearance_checker_are_motions_free(lifeless, workspace, edges, NULL, free), ARGUMENT, "are_free can not have");
  CHECK_OK(clearance_robot_random_states(fixed, &seed, SIZE_MAX, NULL, 0));
  CHECK_OK(clearance_checker_are_free(lifeless, workspace, one, 1, free));
  CHECK(free[0] == 1);
  clearance_checker_free(lifeless);
  clearance_robot_free(fixed);
  clearance_world_free(empty);
}

static void check_repeated_names(void) {
  clearance_checker *none = NULL;
  const clearance_named_value links[2] = {{"hand", 0.2}, {"hand", 0.1}}, tables[2] = {{"table", 0.9}, {"table", 1.0}};
  clearance_checker_options options = clearance_checker_options_default();
  options.link_padding = links;
  options.link_padding_count = 2;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "link_padding: 'hand' is given twice");
  options = clearance_checker_options_default();
  options.link_scale = links;
  options.link_scale_count = 2;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "link_scale: 'hand' is given twice");
  options = clearance_checker_options_default();
  options.object_padding = tables;
  options.object_padding_count = 2;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "object_padding: 'table' is given twice");
  options = clearance_checker_options_default();
  options.object_scale = tables;
  options.object_scale_count = 2;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "object_scale: 'table' is given twice");
  CHECK(none == NULL);
}

static void check_options(void) {
  clearance_checker *none = NULL;
  clearance_checker_options options = clearance_checker_options_default();
  options.group = "leg";
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "no group 'leg'; its SRDF has 'arm' and 'hand'");
  options = clearance_checker_options_default();
  options.padding = NAN;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "padding");
  const clearance_named_value chair = {"chair", 0.1}, joint = {"joint1", 0.1}, unnamed = {NULL, 0.1};
  const clearance_pair pair = {"hand", "chair"}, half = {"hand", NULL};
  options = clearance_checker_options_default();
  options.object_padding = &chair;
  options.object_padding_count = 1;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "object_padding: there is no object 'chair'");
  options = clearance_checker_options_default();
  options.link_padding = &chair;
  options.link_padding_count = 1;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "'chair'");
  options.link_padding = &unnamed;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), ARGUMENT, "link_padding[0].name is null");
  options = clearance_checker_options_default();
  options.allowed_collisions = &pair;
  options.allowed_collision_count = 1;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "allowed_collisions: there is no link or object 'chair'");
  options.allowed_collisions = &half;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), ARGUMENT, "allowed_collisions[0].b is null");
  options = clearance_checker_options_default();
  options.group = "arm";
  options.fixed = &joint;
  options.fixed_count = 1;
  CHECK_FAILS(clearance_checker_new(robot, world, &options, &none), REJECTED, "fixed: joint 'joint1' is one of group 'arm'");
  CHECK_FAILS(clearance_checker_new(NULL, world, NULL, &none), ARGUMENT, "robot is null");
  CHECK_FAILS(clearance_checker_with_world(checker, NULL, &none), ARGUMENT, "world is null");
  CHECK(none == NULL);
}

static void check_states(void) {
  const double bad[N] = {0, 0, 0, NAN, 0, 0, 0};
  const clearance_state home = {HOME, N}, nan = {bad, N}, too_short = {HOME, 6}, missing = {NULL, N}, empty = {NULL, 0};
  const clearance_state misaligned = {(const double *)((const char *)HOME + 1), 6};
  bool is_free = true;
  clearance_distances distances;
  clearance_clearance near;
  CHECK_FAILS(clearance_checker_is_free(NULL, workspace, home, &is_free), ARGUMENT, "checker is null");
  CHECK_FAILS(clearance_checker_is_free(checker, NULL, home, &is_free), ARGUMENT, "workspace is null");
  CHECK_FAILS(clearance_checker_is_free(checker, workspace, home, NULL), ARGUMENT, "is_free is null");
  CHECK_FAILS(clearance_checker_is_free(checker, workspace, nan, &is_free), REJECTED, "state: joint 'joint4' has position NaN");
  CHECK_FAILS(clearance_checker_is_free(checker, workspace, too_short, &is_free), ARGUMENT, "state has 6 positions, but must have 7: one for each of joint1");
  CHECK_FAILS(clearance_checker_is_free(checker, workspace, missing, &is_free), ARGUMENT, "state is null");
  CHECK_FAILS(clearance_checker_is_free(checker, workspace, empty, &is_free), ARGUMENT, "state has 0 positions");
  CHECK_FAILS(clearance_checker_is_free(checker, workspace, misaligned, &is_free), ARGUMENT, "not aligned");
  CHECK_FAILS(clearance_checker_distance(checker, workspace, home, -1.0, &distances), REJECTED, "max_distance is -1");
  CHECK_FAILS(clearance_checker_clearance(checker, workspace, home, NAN, &near), REJECTED, "influence_distance is NaN");

  double rows[3 * N];
  uint8_t free[3];
  for (size_t i = 0; i < 3; ++i) {
    memcpy(rows + i * N, i == 2 ? bad : HOME, sizeof HOME);
  }
  const clearance_states states = {rows, 3, N}, wrong = {rows, 3, 6}, huge = {rows, SIZE_MAX / 16, N}, endless = {rows, SIZE_MAX, N};
  CHECK_FAILS(clearance_checker_are_free(checker, workspace, states, 1, free), REJECTED, "states: row 2: joint 'joint4'");
  CHECK_FAILS(clearance_checker_are_free(checker, workspace, wrong, 1, free), ARGUMENT, "states: row 0 has 6 positions");
  CHECK_FAILS(clearance_checker_are_free(checker, workspace, huge, 1, free), ARGUMENT, "states can not have");
  CHECK_FAILS(clearance_checker_are_free(checker, workspace, endless, 1, free), ARGUMENT, "are_free can not have");
  const clearance_states sound = {rows, 2, N}, none = {NULL, 0, N};
  CHECK_FAILS(clearance_checker_are_free(checker, workspace, sound, 5000, free), ARGUMENT, "threads is 5000");
  CHECK_FAILS(clearance_checker_are_free(checker, workspace, sound, 1, NULL), ARGUMENT, "are_free is null");
  CHECK_OK(clearance_checker_are_free(checker, workspace, none, 1, NULL));
}

static void check_motions(void) {
  const double bad[N] = {0, INFINITY, 0, 0, 0, 0, 0}, beyond[N] = {99, 0, 0, 0, 0, 0, 0};
  const clearance_edge edge = {HOME, HOME, N}, nan = {HOME, bad, N}, half = {HOME, NULL, N}, far = {HOME, beyond, N};
  clearance_motion_report report;
  clearance_plan plan;
  clearance_motion_options options = clearance_motion_options_default();
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, nan, NULL, &report), REJECTED, "to: joint 'joint2'");
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, half, NULL, &report), ARGUMENT, "to is null");
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, NULL, NULL), ARGUMENT, "report is null");
  options.tolerance = 0.0;
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, &options, &report), REJECTED, "tolerance is 0");
  options = clearance_motion_options_default();
  options.timeout = NAN;
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, &options, &report), REJECTED, "timeout is NaN");
  options.timeout = -1.0;
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, &options, &report), REJECTED, "timeout is -1");
  /* beyond every clock: no deadline */
  options.timeout = DBL_MAX;
  CHECK_OK(clearance_checker_check_motion(checker, workspace, edge, &options, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_FREE);
  options = clearance_motion_options_default();
  options.tolerance = INFINITY;
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, &options, &report), REJECTED, "tolerance is inf, but must be finite");
  options = clearance_motion_options_default();
  options.margin = -0.1;
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, &options, &report), REJECTED, "margin is -0.1");
  clearance_along_options along = clearance_along_options_default();
  clearance_motion_distances distances;
  CHECK_FAILS(clearance_checker_clearance_along(checker, workspace, nan, NULL, &distances), REJECTED, "to: joint 'joint2'");
  CHECK_FAILS(clearance_checker_clearance_along(checker, workspace, edge, NULL, NULL), ARGUMENT, "distances is null");
  CHECK_FAILS(clearance_checker_clearance_along_trajectory(checker, workspace, NULL, NULL, &distances), ARGUMENT, "trajectory is null");
  along.absolute_tolerance = -1.0;
  CHECK_FAILS(clearance_checker_clearance_along(checker, workspace, edge, &along, &distances), REJECTED, "absolute_tolerance is -1");
  along = clearance_along_options_default();
  along.max_distance = NAN;
  CHECK_FAILS(clearance_checker_clearance_along(checker, workspace, edge, &along, &distances), REJECTED, "max_distance is NaN");
  options = clearance_motion_options_default();
  const double tube[3] = {0.1, 0.1, -0.1};
  options.tube = tube;
  options.tube_count = 3;
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, &options, &report), ARGUMENT, "tube has 3 tolerances, but must have 7");
  options.tube = tube + 2;
  options.tube_count = 1;
  CHECK_FAILS(clearance_checker_check_motion(checker, workspace, edge, &options, &report), REJECTED, "-0.1");
  double points[2 * N];
  memcpy(points, HOME, sizeof HOME);
  memcpy(points + N, HOME, sizeof HOME);
  const double times[2] = {1.0, 1.0};
  clearance_trajectory trajectory = {points, 2, N, times, NULL, NULL, 0};
  CHECK_FAILS(clearance_checker_check_trajectory(checker, workspace, &trajectory, NULL, &report), REJECTED, "trajectory.times[1] is 1 s");
  const double in_order[2] = {0.0, 1.0}, rates[2 * N] = {0};
  trajectory.times = in_order;
  trajectory.accelerations = rates;
  CHECK_FAILS(clearance_checker_check_trajectory(checker, workspace, &trajectory, NULL, &report), REJECTED, "trajectory.accelerations");
  trajectory.velocities = rates;
  CHECK_OK(clearance_checker_check_trajectory(checker, workspace, &trajectory, NULL, &report));
  trajectory.velocities = NULL;
  trajectory.accelerations = NULL;
  trajectory.times = NULL;
  trajectory.count = 1;
  CHECK_FAILS(clearance_checker_check_trajectory(checker, workspace, &trajectory, NULL, &report), REJECTED, "trajectory");
  trajectory.positions = NULL;
  CHECK_FAILS(clearance_checker_check_trajectory(checker, workspace, &trajectory, NULL, &report), ARGUMENT, "trajectory.positions is null");
  CHECK_FAILS(clearance_checker_plan(checker, workspace, far, NULL, &plan), REJECTED, "joint1");
  clearance_recovery_options recovery = clearance_recovery_options_default();
  const char *locked = "wheel";
  recovery.locked = &locked;
  recovery.locked_count = 1;
  clearance_free_state found;
  const clearance_state home = {HOME, N};
  CHECK_FAILS(clearance_checker_find_free_state(checker, workspace, home, &recovery, &found), REJECTED, "no joint 'wheel'");
  const clearance_grasp grasp = {"chair", "hand", NULL, {NULL, 0}, NULL, 0}, no_tail = {"table", "tail", NULL, {HOME, N}, NULL, 0};
  clearance_checker *none = NULL;
  CHECK_FAILS(clearance_checker_attach(checker, &grasp, &none), REJECTED, "no object 'chair'");
  CHECK_FAILS(clearance_checker_attach(checker, &no_tail, &none), REJECTED, "no link 'tail'");
  CHECK_FAILS(clearance_checker_detach(checker, "table", home, &none), REJECTED, "no object 'table' is attached");
}

int main(void) {
  CHECK(strcmp(clearance_last_error(), "") == 0);
  CHECK_OK(clearance_robot_from_urdf(URDF, "urdf/demo_arm/demo_arm.srdf", NULL, 0, &robot));
  CHECK_OK(clearance_world_from_file("config/demo_world.yaml", robot, 0.0, 0, &world));
  clearance_checker_options options = clearance_checker_options_default();
  options.group = "arm";
  CHECK_OK(clearance_checker_new(robot, world, &options, &checker));
  CHECK_OK(clearance_workspace_new(checker, &workspace));
  check_robots();
  check_worlds();
  check_names_of_worlds();
  check_options();
  check_repeated_names();
  check_warnings_of_checkers();
  check_states();
  check_motions();
  CHECK_FAILS(clearance_workspace_new(NULL, &workspace), ARGUMENT, "checker is null");
  clearance_certificate *certificate = NULL;
  CHECK_FAILS(clearance_certificate_from_json("{}", &certificate), REJECTED, "certificate");
  CHECK(clearance_certificate_to_json(NULL) == NULL);

  /* nothing was changed by what failed */
  bool is_free = false;
  const clearance_state home = {HOME, N};
  CHECK(clearance_world_obstacle_count(world) >= 2);
  CHECK_OK(clearance_checker_is_free(checker, workspace, home, &is_free));
  CHECK(is_free);
  clearance_certificate_free(NULL);
  clearance_robot_free(NULL);
  clearance_world_free(NULL);
  clearance_checker_free(NULL);
  clearance_workspace_free(NULL);
  clearance_workspace_free(workspace);
  clearance_checker_free(checker);
  clearance_world_free(world);
  clearance_robot_free(robot);
  printf("%d checks failed\n", failed_checks);
  return failed_checks == 0 ? 0 : 1;
}
