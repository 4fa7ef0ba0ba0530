/* The C interface on the demo arm: values against known truth. */

#include <clearance.h>
#include <stdlib.h>

#include "checks.h"

#define N 7

static clearance_robot *robot;
static clearance_world *world;
static clearance_checker *checker;
static clearance_workspace *workspace;

static const double HOME[N] = {0, -0.5, 0, -2.2, 0, 1.7, 0};
static const double NEAR[N] = {0, 0.1, 0, -1.6, 0, 0, 0};
static const double FAR[N] = {0, 0.2, 0, -1.7, 0, 0, 0};
static const double TABLE[N] = {0, 0.9, 0, -1.6, 0, 0, 0};

static clearance_state state_of(const double *q) {
  const clearance_state state = {q, N};
  return state;
}

static clearance_edge edge_of(const double *from, const double *to) {
  const clearance_edge edge = {from, to, N};
  return edge;
}

static void check_robot(void) {
  double lower[8], upper[8], q[8];
  clearance_pose poses[16], hand;
  size_t links = clearance_robot_link_count(robot);
  CHECK(strcmp(clearance_robot_name(robot), "demo_arm") == 0);
  CHECK(strcmp(clearance_robot_root_link(robot), "base") == 0);
  CHECK(clearance_robot_joint_count(robot) == 8);
  CHECK(strcmp(clearance_robot_joint_name(robot, 0), "joint1") == 0);
  CHECK(strcmp(clearance_robot_joint_name(robot, 7), "finger_joint1") == 0);
  CHECK(clearance_robot_joint_name(robot, 8) == NULL);
  CHECK(clearance_robot_group_count(robot) == 2);
  CHECK(strcmp(clearance_robot_group_name(robot, 0), "arm") == 0);
  CHECK(clearance_robot_group_joint_count(robot, 0) == N);
  CHECK(strcmp(clearance_robot_group_joint_name(robot, 0, 6), "joint7") == 0);
  CHECK(clearance_robot_group_joint_name(robot, 2, 0) == NULL);
  CHECK(clearance_robot_group_state_count(robot) == 3);
  CHECK(strcmp(clearance_robot_group_state_name(robot, 0), "arm/home") == 0);
  CHECK(clearance_robot_warning_count(robot) == 0 && clearance_robot_warning(robot, 0) == NULL);

  CHECK_OK(clearance_robot_limits(robot, lower, upper, 8));
  CHECK(lower[7] == 0.0 && upper[7] == 0.04);
  CHECK_OK(clearance_robot_group_state(robot, "home", q, 8));
  CHECK(memcmp(q, HOME, sizeof HOME) == 0 && q[7] == 0.0);
  const clearance_named_value finger = {"finger_joint1", 0.03};
  CHECK_OK(clearance_robot_state(robot, &finger, 1, q, 8));
  CHECK(q[0] == 0.0 && q[7] == 0.03);

  /* the fingers move along y of the hand, to opposite sides */
  const clearance_state whole = {q, 8};
  CHECK_OK(clearance_robot_forward_kinematics(robot, whole, poses, links));
  CHECK_OK(clearance_robot_link_pose(robot, whole, "hand", &hand));
  for (size_t i = 0; i < links; ++i) {
    const double *p = poses[i].position;
    const double distance = sqrt(pow(p[0] - hand.position[0], 2) + pow(p[1] - hand.position[1], 2) + pow(p[2] - hand.position[2], 2));
    const char *name = clearance_robot_link_name(robot, i);
    if (strcmp(name, "hand") == 0) {
      CHECK(distance == 0.0);
    }
    if (strcmp(name, "base") == 0) {
      CHECK(p[0] == 0.0 && p[1] == 0.0 && p[2] == 0.0 && poses[i].orientation[3] == 1.0);
    }
    if (strcmp(name, "finger1") == 0 || strcmp(name, "finger2") == 0) {
      CHECK(distance > 0.03 && distance < 0.15);
    }
  }
}

static void check_random_states(void) {
  double some[3 * 8], again[3 * 8], lower[8], upper[8];
  uint64_t seed = 5, same = 5;
  CHECK_OK(clearance_robot_random_states(robot, &seed, 3, some, 8));
  CHECK_OK(clearance_robot_random_states(robot, &same, 3, again, 8));
  CHECK(memcmp(some, again, sizeof some) == 0 && seed == same && seed != 5);
  CHECK_OK(clearance_robot_random_states(robot, &seed, 3, again, 8));
  CHECK(memcmp(some, again, sizeof some) != 0);
  CHECK_OK(clearance_robot_limits(robot, lower, upper, 8));
  for (size_t i = 0; i < 3 * 8; ++i) {
    CHECK(some[i] >= lower[i % 8] && some[i] <= upper[i % 8]);
  }
}

static void check_states(void) {
  bool is_free = false;
  double q[N], whole[8], lower[N], upper[N];
  clearance_distances near;
  CHECK(clearance_checker_joint_count(checker) == N);
  CHECK(strcmp(clearance_checker_joint_name(checker, 3), "joint4") == 0);
  CHECK(clearance_checker_pair_count(checker) == 76);
  CHECK(clearance_checker_pair(checker, 75).b != NULL && clearance_checker_pair(checker, 76).a == NULL);
  CHECK_OK(clearance_checker_limits(checker, lower, upper, N));
  CHECK(lower[3] < -1.0 && upper[3] <= 0.0);
  const clearance_named_value named[2] = {{"joint4", -1.6}, {"joint2", 0.1}};
  CHECK_OK(clearance_checker_state(checker, named, 2, q, N));
  CHECK(memcmp(q, NEAR, sizeof q) == 0);
  CHECK_OK(clearance_checker_expand(checker, state_of(q), whole, 8));
  CHECK(memcmp(q, whole, sizeof q) == 0 && whole[7] == 0.04); /* fixed */

  CHECK_OK(clearance_checker_is_free(checker, workspace, state_of(NEAR), &is_free));
  CHECK(is_free);
  CHECK_OK(clearance_checker_is_free(checker, workspace, state_of(TABLE), &is_free));
  CHECK(!is_free);
  /* as `clearance check` prints them in README.md */
  CHECK_OK(clearance_checker_distance(checker, workspace, state_of(NEAR), 0.5, &near));
  CHECK_NEAR(near.self_pair.distance, 0.009657, 1e-6);
  CHECK_NEAR(near.world_pair.distance, 0.129328, 1e-6);
  CHECK(strcmp(near.world_pair.pair.a, "link6") == 0 && strcmp(near.world_pair.pair.b, "shelf") == 0);
  CHECK_OK(clearance_checker_distance(checker, workspace, state_of(HOME), 0.001, &near));
  CHECK(near.self_pair.pair.a == NULL && isinf(near.self_pair.distance) && isnan(near.self_pair.points[0][0]));
}

static void check_reports(void) {
  clearance_report report;
  clearance_clearance near;
  CHECK_OK(clearance_checker_check(checker, workspace, state_of(TABLE), NULL, &report));
  CHECK(!report.is_free && report.world_collision && report.colliding_pair_count >= 1);
  CHECK(report.contact_count == report.colliding_pair_count && report.contacts[0].is_deepest);
  CHECK(report.contacts[0].depth > 0.0 && report.contacts[0].depth_lower <= report.contacts[0].depth);
  clearance_report_options options = clearance_report_options_default();
  CHECK(options.max_distance == 0.1 && options.max_contacts == 1);
  options.max_contacts = 0;
  options.max_distance = 0.3;
  CHECK_OK(clearance_checker_check(checker, workspace, state_of(NEAR), &options, &report));
  CHECK(report.is_free && report.contact_count == 0 && report.colliding_pair_count == 0 && report.distance_count > 2);

  CHECK_OK(clearance_checker_clearance(checker, workspace, state_of(NEAR), 0.15, &near));
  CHECK(near.pair_count == 5 && near.n == N); /* as in docs/plan/python.md */
  /* derivatives against differences */
  for (size_t i = 0; i < near.pair_count; ++i) {
    const clearance_pair pair = near.pairs[i].pair;
    const double distance = near.pairs[i].distance, slope = near.gradients[i * N + 3];
    const bool is_unique = near.pairs[i].is_unique;
    double q[N];
    memcpy(q, NEAR, sizeof q);
    q[3] += 1e-6;
    clearance_clearance moved;
    CHECK_OK(clearance_checker_clearance(checker, workspace, state_of(q), 0.2, &moved));
    for (size_t k = 0; k < moved.pair_count; ++k) {
      if (is_unique && strcmp(moved.pairs[k].pair.a, pair.a) == 0 && strcmp(moved.pairs[k].pair.b, pair.b) == 0) {
        CHECK_NEAR((moved.pairs[k].distance - distance) / 1e-6, slope, 1e-3);
      }
    }
    CHECK_OK(clearance_checker_clearance(checker, workspace, state_of(NEAR), 0.15, &near));
  }
}

static void check_motions(void) {
  bool is_free = false;
  clearance_motion_report report;
  clearance_motion_options options = clearance_motion_options_default();
  CHECK(options.tolerance == 5e-4 && isinf(options.timeout) && options.budget == 10000000);
  CHECK_OK(clearance_checker_is_motion_free(checker, workspace, edge_of(NEAR, FAR), NULL, &is_free));
  CHECK(is_free);
  CHECK_OK(clearance_checker_is_motion_free(checker, workspace, edge_of(NEAR, TABLE), NULL, &is_free));
  CHECK(!is_free);
  CHECK_OK(clearance_checker_check_motion(checker, workspace, edge_of(NEAR, TABLE), NULL, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_CONTACT && report.reason == CLEARANCE_REASON_NONE && report.certificate == NULL);
  CHECK_NEAR(report.t[0], 0.95, 0.005); /* as in docs/plan/python.md */
  CHECK(strcmp(report.pair.a, "link6") == 0 && strcmp(report.pair.b, "table") == 0 && report.t[1] >= report.t[0]);

  options.budget = 1;
  CHECK_OK(clearance_checker_check_motion(checker, workspace, edge_of(NEAR, TABLE), &options, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_UNDECIDED && report.reason == CLEARANCE_REASON_BUDGET);
  clearance_motion_distances along;
  CHECK_OK(clearance_checker_clearance_along(checker, workspace, edge_of(NEAR, FAR), NULL, &along));
  CHECK(along.reason == CLEARANCE_REASON_NONE && along.evaluations > 0);
  const clearance_least_distance *both[2] = {&along.nearest_self, &along.nearest_world};
  for (size_t i = 0; i < 2; ++i) {
    CHECK(0.0 < both[i]->lower && both[i]->lower <= both[i]->upper && both[i]->upper - both[i]->lower <= 2e-3);
    CHECK(both[i]->pair.a != NULL && both[i]->t >= 0.0 && both[i]->t <= 1.0 && isnan(both[i]->time));
    double squared = 0.0;
    for (size_t k = 0; k < 3; ++k) {
      squared += pow(both[i]->points[0][k] - both[i]->points[1][k], 2.0);
    }
    CHECK_NEAR(sqrt(squared), both[i]->upper, 1e-9);
  }
  const double least = fmin(along.nearest_self.lower, along.nearest_world.lower);
  const double upper = fmin(along.nearest_self.upper, along.nearest_world.upper);
  options = clearance_motion_options_default();
  CHECK(options.margin == 0.0);
  options.margin = 0.9 * least;
  CHECK_OK(clearance_checker_check_motion(checker, workspace, edge_of(NEAR, FAR), &options, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_FREE);
  options.margin = 1.1 * upper;
  CHECK_OK(clearance_checker_check_motion(checker, workspace, edge_of(NEAR, FAR), &options, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_CONTACT);
  clearance_along_options limits = clearance_along_options_default();
  CHECK(limits.absolute_tolerance == 1e-3 && limits.relative_tolerance == 0.01 && isinf(limits.max_distance));
  limits.timeout = 0.0;
  CHECK_OK(clearance_checker_clearance_along(checker, workspace, edge_of(NEAR, FAR), &limits, &along));
  CHECK(along.reason == CLEARANCE_REASON_DEADLINE && along.nearest_self.lower == 0.0 && isinf(along.nearest_self.upper));
  options = clearance_motion_options_default();
  options.timeout = 0.0;
  CHECK_OK(clearance_checker_check_motion(checker, workspace, edge_of(NEAR, FAR), &options, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_UNDECIDED && report.reason == CLEARANCE_REASON_DEADLINE);
  options = clearance_motion_options_default();
  const double wide = 0.2;
  options.tube = &wide;
  options.tube_count = 1;
  CHECK_OK(clearance_checker_check_motion(checker, workspace, edge_of(NEAR, FAR), &options, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_UNDECIDED && report.reason == CLEARANCE_REASON_TUBE);
}

static void check_trajectories(void) {
  double points[3 * N];
  const double times[3] = {0.0, 1.0, 3.0};
  memcpy(points, NEAR, sizeof NEAR);
  memcpy(points + N, FAR, sizeof FAR);
  memcpy(points + 2 * N, TABLE, sizeof TABLE);
  clearance_trajectory trajectory = {points, 3, N, times, NULL, NULL, 0};
  clearance_motion_report report;
  CHECK_OK(clearance_checker_check_trajectory(checker, workspace, &trajectory, NULL, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_CONTACT && report.segment == 1);
  clearance_motion_distances along;
  CHECK_OK(clearance_checker_clearance_along_trajectory(checker, workspace, &trajectory, NULL, &along));
  CHECK(along.nearest_world.lower == 0.0 && along.nearest_world.upper == 0.0 && along.nearest_world.segment == 1);
  CHECK_NEAR(along.nearest_world.time, 1.0 + 2.0 * along.nearest_world.t, 1e-9);
  CHECK_NEAR(report.time[0], 1.0 + 2.0 * report.t[0], 1e-9);
  trajectory.count = 2;
  trajectory.times = NULL;
  CHECK_OK(clearance_checker_check_trajectory(checker, workspace, &trajectory, NULL, &report));
  CHECK(report.verdict == CLEARANCE_VERDICT_FREE && isnan(report.time[0]) && isnan(report.t[0]) && report.pair.a == NULL);
}

static void check_search(void) {
  const double start[N] = {-0.8, 0.5, 0, -1.6, 0, 1.8, 0}, goal[N] = {0.8, 0.5, 0, -1.6, 0, 1.8, 0};
  clearance_plan plan;
  clearance_plan_options options = clearance_plan_options_default();
  CHECK_OK(clearance_checker_plan(checker, workspace, edge_of(start, goal), &options, &plan));
  CHECK(plan.is_found && strcmp(plan.reason, "found") == 0 && plan.count > 2 && plan.n == N && plan.certificate == NULL);
  CHECK(memcmp(plan.states, start, sizeof start) == 0);
  CHECK(memcmp(plan.states + (plan.count - 1) * N, goal, sizeof goal) == 0);
  CHECK(plan.length > 1.6 && plan.edges > 0);
  CHECK_OK(clearance_checker_plan(checker, workspace, edge_of(start, TABLE), &options, &plan));
  CHECK(!plan.is_found && strcmp(plan.reason, "goal_not_free") == 0 && plan.states == NULL && plan.count == 0);

  clearance_free_state found;
  bool is_free = false;
  CHECK_OK(clearance_checker_find_free_state(checker, workspace, state_of(TABLE), NULL, &found));
  CHECK(found.is_found && strcmp(found.reason, "found") == 0 && found.distance > 0.0 && found.distance <= 0.5);
  double q[N];
  memcpy(q, found.positions, sizeof q);
  CHECK_OK(clearance_checker_is_free(checker, workspace, state_of(q), &is_free));
  CHECK(is_free);
  CHECK_OK(clearance_checker_find_free_state(checker, workspace, state_of(NEAR), NULL, &found));
  CHECK(strcmp(found.reason, "already_free") == 0 && found.distance == 0.0);
}

/* Worlds: what is added collides where it is, and an attached object moves with its link. */
static void check_worlds(void) {
  clearance_world *own = NULL, *copy = NULL;
  clearance_checker *in_own = NULL, *holding = NULL, *released = NULL;
  const double size[3] = {0.1, 0.1, 0.1}, xyz[6] = {2.0, 0.0, 0.0, 2.0, 0.1, 0.0};
  const double vertices[9] = {3, 0, 0, 3, 1, 0, 3, 0, 1};
  const uint32_t triangle[3] = {0, 1, 2};
  const clearance_mesh mesh = {vertices, 3, triangle, 1};
  const clearance_points points = {xyz, 2};
  clearance_pose pose = {{2.0, 2.0, 2.0}, {0.0, 0.0, 0.0, 1.0}};
  CHECK_OK(clearance_world_new(&own));
  CHECK_OK(clearance_world_add_box(own, "box", size, &pose));
  CHECK_OK(clearance_world_add_sphere(own, "sphere", 0.1, &pose));
  CHECK_OK(clearance_world_add_cylinder(own, "cylinder", 0.1, 0.2, &pose));
  CHECK_OK(clearance_world_add_capsule(own, "capsule", 0.1, 0.2, &pose));
  CHECK_OK(clearance_world_add_mesh(own, "mesh", mesh, NULL));
  CHECK_OK(clearance_world_add_points(own, "points", points, 0.05, NULL));
  CHECK_OK(clearance_world_add_mesh_file(own, "file", "urdf/demo_arm/meshes/hand.stl", size, &pose));
  CHECK(clearance_world_obstacle_count(own) == 7);
  CHECK(strcmp(clearance_world_obstacle_name(own, 1), "sphere") == 0 && clearance_world_obstacle_name(own, 7) == NULL);
  CHECK_OK(clearance_world_remove(own, "sphere"));
  CHECK(strcmp(clearance_world_obstacle_name(own, 1), "cylinder") == 0);
  CHECK_OK(clearance_world_copy(own, &copy));
  CHECK_OK(clearance_world_remove(copy, "box"));
  CHECK(clearance_world_obstacle_count(copy) == 5 && clearance_world_obstacle_count(own) == 6);

  bool is_free = false;
  CHECK_OK(clearance_checker_with_world(checker, own, &in_own));
  CHECK_OK(clearance_checker_is_free(in_own, workspace, state_of(HOME), &is_free));
  CHECK(is_free);
  /* into the root link; the checker has its own copy of the world */
  pose.position[0] = pose.position[1] = pose.position[2] = 0.0;
  CHECK_OK(clearance_world_move(own, "box", &pose));
  CHECK_OK(clearance_checker_is_free(in_own, workspace, state_of(HOME), &is_free));
  CHECK(is_free);
  clearance_checker_free(in_own);
  CHECK_OK(clearance_checker_with_world(checker, own, &in_own));
  CHECK_OK(clearance_checker_is_free(in_own, workspace, state_of(HOME), &is_free));
  CHECK(!is_free);

  const clearance_pose in_hand = {{0.0, 0.0, 0.3}, {0.0, 0.0, 0.0, 1.0}};
  const char *touch_links[2] = {"finger1", "finger2"};
  const clearance_grasp grasp = {"box", "hand", &in_hand, {NULL, 0}, touch_links, 2};
  CHECK_OK(clearance_checker_attach(in_own, &grasp, &holding));
  clearance_world *held = NULL;
  CHECK_OK(clearance_checker_world(holding, &held));
  CHECK(clearance_world_obstacle_count(held) == 5);
  CHECK_OK(clearance_checker_is_free(holding, workspace, state_of(HOME), &is_free));
  CHECK(is_free);
  /* released at home, it is where the hand was */
  CHECK_OK(clearance_checker_detach(holding, "box", state_of(HOME), &released));
  const double turned[N] = {1.0, -0.5, 0, -2.2, 0, 1.7, 0};
  clearance_distances at_home, away;
  CHECK_OK(clearance_checker_distance(released, workspace, state_of(HOME), 1.0, &at_home));
  CHECK(strcmp(at_home.world_pair.pair.b, "box") == 0);
  CHECK_OK(clearance_checker_distance(released, workspace, state_of(turned), 1.0, &away));
  CHECK(away.world_pair.distance > at_home.world_pair.distance + 0.05);
  clearance_checker_free(released);
  clearance_checker_free(holding);
  clearance_checker_free(in_own);
  clearance_world_free(held);
  clearance_world_free(copy);
  clearance_world_free(own);
}

int main(void) {
  const clearance_named_value fixed = {"finger_joint1", 0.04};
  clearance_checker_options options = clearance_checker_options_default();
  options.group = "arm";
  options.fixed = &fixed;
  options.fixed_count = 1;
  CHECK_OK(clearance_robot_from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf", NULL, 0, &robot));
  CHECK_OK(clearance_world_from_file("config/demo_world.yaml", robot, 0.0, 0, &world));
  CHECK(clearance_world_warning_count(world) == 0);
  CHECK_OK(clearance_checker_new(robot, world, &options, &checker));
  CHECK_OK(clearance_workspace_new(checker, &workspace));
  char version[32];
  snprintf(version, sizeof version, "%d.%d.%d", CLEARANCE_VERSION_MAJOR, CLEARANCE_VERSION_MINOR, CLEARANCE_VERSION_PATCH);
  CHECK(strcmp(clearance_version(), version) == 0);

  check_robot();
  check_random_states();
  if (checker != NULL && workspace != NULL) {
    check_states();
    check_reports();
    check_motions();
    check_trajectories();
    check_search();
    check_worlds();
  }
  /* a checker needs neither its robot nor its world any more */
  clearance_world_free(world);
  clearance_robot_free(robot);
  bool is_free = false;
  CHECK_OK(clearance_checker_is_free(checker, workspace, state_of(HOME), &is_free));
  clearance_checker_free(checker);
  clearance_workspace_free(workspace);
  printf("%d checks failed\n", failed_checks);
  return failed_checks == 0 ? 0 : 1;
}
