// The C++ interface: objects, errors, certificates, Eigen.

#if __has_include(<Eigen/Core>)
#define CLEARANCE_WITH_EIGEN
#endif

#include <clearance.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>
#include <type_traits>

#include <unistd.h>

#include "checks.h"

namespace {

// The text of the error of a call; empty if it succeeds.
template <typename Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const clearance::Error &error) {
    return error.what();
  }
  return "";
}

#define CHECK_THROWS(expression, part) CHECK_TEXT(error_of([&] { (void)(expression); }).c_str(), part)

clearance::CheckerOptions of_arm() {
  clearance::CheckerOptions options;
  options.group = "arm";
  return options;
}

struct Scene {
  clearance::Robot robot = clearance::Robot::from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf");
  clearance::World world = clearance::World::from_file("config/demo_world.yaml", robot);
  clearance::Checker checker = clearance::Checker(robot, world, of_arm());
  clearance::Workspace workspace = checker.workspace();
  std::vector<double> near = checker.state({{"joint2", 0.1}, {"joint4", -1.6}});
  std::vector<double> far = checker.state({{"joint2", 0.2}, {"joint4", -1.7}});
  std::vector<double> table = checker.state({{"joint2", 0.9}, {"joint4", -1.6}});
};

void check_robots(const Scene &scene) {
  CHECK(scene.robot.name() == "demo_arm" && scene.robot.joint_names().size() == 8 && scene.robot.warnings().empty());
  CHECK(scene.robot.groups().at("arm") == scene.checker.joint_names());
  CHECK(scene.robot.group_states().at(0) == "arm/home" && scene.robot.group_state("home")[1] == -0.5);
  const auto poses = scene.robot.forward_kinematics(scene.robot.state());
  CHECK(poses.size() == scene.robot.link_names().size());
  CHECK(poses[0].position[2] == 0.0);
  const clearance::Robot copy = scene.robot;
  CHECK(copy.handle() == scene.robot.handle());
  CHECK(scene.checker.limits().first.size() == 7 && scene.checker.pairs().size() == 76);
  CHECK(scene.checker.expand(scene.near, 8)[3] == -1.6);
}

void check_errors(Scene &scene) {
  CHECK_THROWS(clearance::Robot::from_urdf("no/such.urdf"), "no/such.urdf");
  CHECK_THROWS(clearance::World::from_file("no/such.yaml"), "no/such.yaml");
  clearance::CheckerOptions options;
  options.group = "leg";
  CHECK_THROWS(clearance::Checker(scene.robot, scene.world, options), "no group 'leg'");
  CHECK_THROWS(scene.checker.is_free(std::vector<double>(6), scene.workspace), "6 positions, but must have 7");
  CHECK_THROWS(scene.checker.is_free(std::vector<double>(7, NAN), scene.workspace), "'joint1' has position NaN");
  CHECK_THROWS(scene.checker.check_motion(scene.near, std::vector<double>(6), scene.workspace), "7 and 6");
  CHECK_THROWS(clearance::States(std::vector<double>(8), 7), "8, is not a multiple of n, 7");
  CHECK_THROWS(clearance::Certificate::from_json("{\"format\": \"other\"}"), "certificate");
  clearance::Trajectory trajectory;
  trajectory.positions = std::vector<double>(8);
  trajectory.n = 7;
  CHECK_THROWS(scene.checker.check_trajectory(trajectory, scene.workspace), "n positions for each point");
  clearance::World world;
  CHECK_THROWS(world.add_points("p", {1.0, 2.0}, 0.1), "three numbers");
  CHECK_THROWS(world.add_sphere("s", -1.0), "obstacle 's'");
  // C would read the shorter text
  using namespace std::string_view_literals;
  CHECK_THROWS(world.add_sphere("tool\0left"sv, 0.1), "'tool' is followed by a NUL");
  CHECK_THROWS(clearance::Robot::from_urdf("urdf/demo_arm/demo_arm.urdf\0x"sv), "followed by a NUL");
  CHECK_THROWS(clearance::Certificate::from_json("{}\0x"sv), "followed by a NUL");
  CHECK_THROWS(scene.robot.state({{std::string("joint2\0x", 8), 0.1}}), "'joint2' is followed by a NUL");
  clearance::MotionOptions event;
  event.any_contact = true;
  CHECK_THROWS(scene.checker.event_distance(scene.table, scene.table, 0.1, scene.workspace, event), "any_contact");
  CHECK_THROWS(world.remove("s"), "'s'");
  CHECK(world.obstacle_names().empty());
}

// What is left of an object after a move has errors, not a null pointer.
void check_moved(const Scene &scene) {
  std::uint64_t seed = 1;
  clearance::Robot robot = scene.robot;
  const clearance::Robot other = std::move(robot);
  CHECK_THROWS(robot.name(), "the robot was moved from");
  CHECK_THROWS(robot.root_link(), "the robot was moved from");
  CHECK_THROWS(robot.joint_names(), "the robot was moved from");
  CHECK_THROWS(robot.groups(), "the robot was moved from");
  CHECK_THROWS(robot.size(), "the robot was moved from");
  clearance::World world;
  const clearance::World taken = std::move(world);
  CHECK_THROWS(world.obstacle_names(), "the world was moved from");
  CHECK_THROWS(clearance::Checker(scene.robot, world), "the world was moved from");
  CHECK_THROWS(scene.checker.with_world(world), "the world was moved from");
  CHECK_THROWS(clearance::World(world), "the world was moved from");
  CHECK_THROWS(world.add_sphere("ball", 0.1), "the world was moved from");
  CHECK_THROWS(world.remove("ball"), "the world was moved from");
  CHECK_THROWS(robot.random_states(seed), "the robot was moved from");
  CHECK_THROWS(clearance::Checker{robot}, "the robot was moved from");
  CHECK_THROWS(clearance::World::from_file("config/demo_world.yaml", robot), "the robot was moved from");
  clearance::Checker checker = scene.checker;
  const clearance::Checker kept = std::move(checker);
  CHECK_THROWS(checker.joint_names(), "the checker was moved from");
  CHECK_THROWS(checker.world(), "the checker was moved from");
  CHECK_THROWS(clearance::Workspace(checker), "the checker was moved from");
  clearance::Workspace workspace(kept);
  clearance::Workspace used = std::move(workspace);
  CHECK_THROWS(checker.is_free(scene.near, used), "the checker was moved from");
  CHECK_THROWS(kept.is_free(scene.near, workspace), "the workspace was moved from");
  CHECK(kept.is_free(scene.near, used));
  CHECK(kept.warnings().empty() && other.name() == "demo_arm" && taken.obstacle_names().empty());
  CHECK(clearance::Checker(clearance::Robot::from_urdf("<robot name='r'><link name='l'/></robot>")).warnings().size() == 1);
}

// A triangle and a line, which no mesh has.
void check_warnings() {
  const auto path = std::filesystem::temp_directory_path() / ("clearance_line_" + std::to_string(getpid()) + ".ply");
  std::ofstream(path) << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                         "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n";
  clearance::World world;
  world.add_mesh_file("mesh", path.string());
  std::filesystem::remove(path);
  CHECK(world.warnings().size() == 1);
  CHECK_TEXT(world.warnings().at(0).c_str(), "1 polygons of fewer than three corners are skipped");
}

void check_worlds(Scene &scene) {
  CHECK_THROWS(scene.checker.are_motions_free(clearance::States(std::vector<double>(14), 7), clearance::States(std::vector<double>(14), 14), scene.workspace),
               "from has 2 states of 7 positions, but to has 1 states of 14 positions");
  clearance::World world;
  world.add_box("box", {0.1, 0.1, 0.1}, clearance::Pose(3.0, 0.0, 0.0));
  world.add_sphere("sphere", 0.1, clearance::Pose(3.0, 0.0, 0.0));
  clearance::World copy = world;
  copy.remove("box");
  CHECK(world.obstacle_names().size() == 2 && copy.obstacle_names().size() == 1);
  copy = world;
  CHECK(copy.obstacle_names().size() == 2);
  const auto moved = scene.checker.with_world(world);
  CHECK(moved.is_free(scene.table, scene.workspace)); // the table is no longer there
  const auto holding = moved.attach("box", "hand", clearance::Pose(0.0, 0.0, 0.3), {"finger1", "finger2"});
  CHECK(holding.world().obstacle_names().size() == 1);
  CHECK(holding.detach("box", scene.near).world().obstacle_names().size() == 2);
  const auto grasped = moved.attach_at("box", "hand", scene.near);
  CHECK(grasped.detach("box", scene.near).distance(scene.near, scene.workspace, 10.0).world.distance > 1.0);

  // settings of an object end with the object, and the certificate is that of the others
  clearance::World rest = world;
  rest.remove("box");
  clearance::CheckerOptions of_box = of_arm();
  of_box.object_padding = {{"box", 0.5}};
  of_box.checked_collisions = {{"link1", "box"}};
  const clearance::Checker with_box(scene.robot, world, of_box);
  const auto without_box = with_box.with_world(rest);
  const auto world_distance = [&](const clearance::Checker &checker) {
    return checker.distance(scene.near, scene.workspace, 10.0).world.distance;
  };
  const double plain = world_distance(clearance::Checker(scene.robot, world, of_arm()));
  CHECK(world_distance(with_box) < plain - 0.3 && std::abs(world_distance(without_box.with_world(world)) - plain) < 1e-12);
  clearance::MotionOptions with_certificate;
  with_certificate.certificate = true;
  const auto motion = without_box.check_motion(scene.near, scene.far, scene.workspace, with_certificate);
  clearance::Expectation of_rest;
  of_rest.options = of_arm();
  CHECK(motion.certificate && motion.certificate->verify(scene.robot, rest, of_rest));
  const clearance::Pose in_hand(0.0, 0.0, 0.3);
  CHECK_THROWS(with_box.attach("box", "link1", in_hand), "'link1' and 'box' cannot be checked: the link holds the object");
  CHECK_THROWS(with_box.attach("box", "hand", in_hand, {"link1"}), "the link is a touch link of the object");
  const auto holds_both = moved.attach("box", "hand", in_hand).attach("sphere", "hand", in_hand);
  clearance::CheckerOptions of_both = of_arm();
  of_both.checked_collisions = {{"box", "sphere"}};
  CHECK_THROWS(clearance::Checker(scene.robot, holds_both.world(), of_both),
               "'box' and 'sphere' cannot be checked: one link holds both objects");

  clearance::CheckerOptions options = of_arm();
  options.padding = 0.2;
  const clearance::Checker padded(scene.robot, scene.world, options);
  CHECK(scene.checker.is_free(scene.near, scene.workspace) && !padded.is_free(scene.near, scene.workspace));
  const auto report = padded.check(scene.near, scene.workspace);
  CHECK(report.world_collision && !report.self_collision && !report.contacts.empty());
  options.allowed_collisions = report.colliding_pairs;
  CHECK(clearance::Checker(scene.robot, scene.world, options).is_free(scene.near, scene.workspace));
  options.link_padding = {{"link6", 0.0}};
  options.object_padding = {{"table", 0.01}};
  CHECK(clearance::Checker(scene.robot, scene.world, options).pairs().size() < 76);
  options.allowed_collisions.clear();
  CHECK_THROWS(clearance::Checker(scene.robot, options), "object_padding: there is no object 'table'");
}

// The certificate of a motion proves it, after a round trip too; an altered one and another motion are rejected.
void check_certificates(Scene &scene) {
  clearance::MotionOptions options;
  options.certificate = true;
  const auto report = scene.checker.check_motion(scene.near, scene.far, scene.workspace, options);
  CHECK(report.is_free() && report.certificate.has_value());
  CHECK(!scene.checker.check_motion(scene.near, scene.table, scene.workspace, options).certificate.has_value());
  const auto distances = scene.checker.clearance_along(scene.near, scene.far, scene.workspace);
  CHECK(0.0 < distances.lower() && distances.nearest_self.pair && distances.nearest_world.upper >= distances.lower());
  options.margin = 0.9 * distances.lower();
  const auto kept = scene.checker.check_motion(scene.near, scene.far, scene.workspace, options);
  clearance::Expectation of_margin;
  of_margin.options = of_arm();
  of_margin.margin = options.margin;
  CHECK(kept.certificate && kept.certificate->verify(scene.robot, scene.world, of_margin));
  CHECK(!report.certificate->verify(scene.robot, scene.world, of_margin));
  of_margin.margin = -1.0;
  CHECK_THROWS(kept.certificate->verify(scene.robot, scene.world, of_margin), "expectation.margin is");
  options.margin = 0.0;
  const double within = std::min(distances.nearest_self.upper, distances.nearest_world.upper) + 1e-3;
  CHECK(scene.checker.event_distance(scene.near, scene.far, within, scene.workspace).verdict == clearance::Verdict::contact);
  CHECK(scene.checker.event_distance(scene.near, scene.far, 0.9 * distances.lower(), scene.workspace).is_free());
  clearance::Trajectory both;
  both.n = 7;
  both.positions = scene.near;
  both.positions.insert(both.positions.end(), scene.far.begin(), scene.far.end());
  both.times = {0.0, 2.0};
  const auto to_world = scene.checker.clearance_along(both, scene.workspace).nearest_world;
  CHECK(to_world.lower > 0.0 && to_world.segment == 0 && std::abs(to_world.time - 2.0 * to_world.t) < 1e-9);
  const std::string json = report.certificate->to_json();
  const auto read = clearance::Certificate::from_json(json);
  CHECK(read.to_json() == json && read.segment_count() == 1 && read.pair_count() == 76);

  clearance::Expectation expected;
  expected.options = of_arm();
  expected.tolerance = options.tolerance;
  expected.motion.emplace();
  expected.motion->n = 7;
  expected.motion->positions = scene.near;
  expected.motion->positions.insert(expected.motion->positions.end(), scene.far.begin(), scene.far.end());
  const auto valid = read.verify(scene.robot, scene.world, expected);
  CHECK(valid && valid.reason.empty() && valid.segments == 1 && valid.pairs == 76 && valid.proofs > 0);
  for (const double tolerance : {std::nan(""), -1.0, std::numeric_limits<double>::infinity()}) {
    clearance::Expectation wrong = expected;
    wrong.tolerance = tolerance;
    CHECK_THROWS(read.verify(scene.robot, scene.world, wrong), "expectation.tolerance is");
  }
  expected.motion->positions[8] += 0.01;
  const auto other_motion = read.verify(scene.robot, scene.world, expected);
  CHECK(!other_motion && !other_motion.reason.empty());
  clearance::World other_world = scene.world;
  other_world.add_sphere("sphere", 0.01, clearance::Pose(0.5, 0.0, 2.0));
  CHECK(!read.verify(scene.robot, other_world));
  CHECK(read.verify(scene.robot, scene.world));

  // altered text: the digest does not fit
  std::string altered = json;
  const std::size_t digit = altered.find("-1.6");
  CHECK(digit != std::string::npos);
  altered[digit + 3] = '5';
  CHECK(!error_of([&] { clearance::Certificate::from_json(altered); }).empty());

  clearance::PlanOptions limits;
  limits.certificate = true;
  const auto plan = scene.checker.plan(scene.near, scene.far, scene.workspace, limits);
  CHECK(plan.is_found && plan.certificate && plan.certificate->verify(scene.robot, scene.world));
  // at every timeout, a path has its certificate or the reason why not
  const auto start = scene.checker.state({{"joint1", -0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}});
  const auto goal = scene.checker.state({{"joint1", 0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}});
  for (int i = 0; i < 60; ++i) {
    limits.timeout = 0.001 * i;
    const auto timed = scene.checker.plan(start, goal, scene.workspace, limits);
    CHECK(timed.certificate.has_value() == (timed.reason == "found"));
    CHECK(timed.is_found == (timed.reason == "found" || timed.reason == "found_without_certificate"));
  }
  const auto found = scene.checker.find_free_state(scene.table, scene.workspace);
  CHECK(found.is_found && scene.checker.is_free(found.positions, scene.workspace));
}

void check_eigen(Scene &scene) {
#ifdef CLEARANCE_WITH_EIGEN
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(scene.near.data(), 7);
  CHECK(scene.checker.is_free(q, scene.workspace));
  Eigen::MatrixXd columns(7, 2), rows(2, 7);
  columns.col(1) = q;
  CHECK(scene.checker.is_free(columns.col(1), scene.workspace));
  rows.row(0) = q;
  rows.row(1) = Eigen::Map<const Eigen::VectorXd>(scene.table.data(), 7);
  CHECK_THROWS(scene.checker.is_free(rows.row(0), scene.workspace), "not contiguous");
  // the rows of a matrix have gaps, whatever the class of the expression
  Eigen::MatrixXd many = Eigen::MatrixXd::Zero(8, 7);
  many.row(3) = q;
  CHECK_THROWS(scene.checker.is_free(many.block(3, 0, 1, 7), scene.workspace), "not contiguous");
  CHECK_THROWS(scene.checker.is_free(many.block<1, 7>(3, 0), scene.workspace), "not contiguous");
  CHECK_THROWS(scene.checker.is_free(many.middleRows(3, 1), scene.workspace), "not contiguous");
  CHECK_THROWS(scene.checker.is_free(many.topRows(1), scene.workspace), "not contiguous");
  CHECK_THROWS(clearance::Positions(many.block(0, 0, 2, 2)), "a matrix of 2 x 2");
  CHECK_THROWS(clearance::Positions(many.topRows(2)), "a matrix of 2 x 7");
  const clearance::States::Rows by_rows = many;
  CHECK_THROWS(scene.checker.is_free(by_rows.block(0, 3, 7, 1), scene.workspace), "not contiguous");
  CHECK_THROWS(scene.checker.is_free(by_rows.middleCols(3, 1), scene.workspace), "not contiguous");
  const Eigen::MatrixXd by_columns = many.transpose();
  for (const clearance::Positions &same : {clearance::Positions(by_rows.block(3, 0, 1, 7)), clearance::Positions(by_rows.middleRows(3, 1)),
                                           clearance::Positions(by_columns.block(0, 3, 7, 1)), clearance::Positions(by_columns.col(3)),
                                           clearance::Positions(by_columns.middleCols(3, 1)), clearance::Positions(by_rows.row(3))}) {
    CHECK(same.size() == 7 && std::equal(same.data(), same.data() + 7, scene.near.begin()));
  }
  const auto free = scene.checker.are_free(rows, scene.workspace);
  CHECK(free.size() == 2 && free[0] == 1 && free[1] == 0);
  const auto near = scene.checker.clearance(q, scene.workspace, 0.15);
  CHECK(near.gradient_matrix().rows() == 5 && near.gradient_matrix()(4, 6) == near.gradient(4)[6]);
  const Eigen::Isometry3d turned = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX());
  CHECK(clearance::Pose(turned).isometry().isApprox(turned, 1e-12));
  std::cout << "with Eigen, ";
#else
  (void)scene;
#endif
}

}  // namespace

int main() {
  static_assert(!std::is_copy_constructible_v<clearance::Workspace> && std::is_move_constructible_v<clearance::Workspace>);
  try {
    Scene scene;
    check_robots(scene);
    check_errors(scene);
    check_moved(scene);
    check_warnings();
    check_worlds(scene);
    check_certificates(scene);
    check_eigen(scene);
  } catch (const std::exception &error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  std::cout << failed_checks << " checks failed\n";
  return failed_checks == 0 ? 0 : 1;
}
