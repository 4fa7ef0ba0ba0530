// Checks states and a motion of the demo arm in its world. Run it in the repository: the paths are relative to it.

#include <clearance.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <vector>

int main() try {
  const auto robot = clearance::Robot::from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf");
  const auto world = clearance::World::from_file("config/demo_world.yaml", robot);
  clearance::CheckerOptions options;
  options.group = "arm";
  const clearance::Checker checker(robot, world, options);  // immutable, shared by threads
  clearance::Workspace workspace(checker);                  // one for each thread

  const auto q = checker.state({{"joint2", 0.1}, {"joint4", -1.6}});  // rad; the others at their defaults
  const auto near = checker.distance(q, workspace, 0.5);
  std::printf("free: %s, self: %.4f m %s - %s, world: %.4f m %s - %s\n", checker.is_free(q, workspace) ? "yes" : "no",
              near.self.distance, near.self.pair->first.c_str(), near.self.pair->second.c_str(), near.world.distance,
              near.world.pair->first.c_str(), near.world.pair->second.c_str());

  // random states of the arm, row by row: of each state of the robot, the joints of the checker
  std::uint64_t seed = 1;
  const auto whole = robot.random_states(seed, 10000);
  const auto names = robot.joint_names(), of_arm = checker.joint_names();
  std::vector<double> rows;
  for (auto row = whole.begin(); row != whole.end(); row += robot.size()) {
    for (const auto &name : of_arm) {
      rows.push_back(row[std::find(names.begin(), names.end(), name) - names.begin()]);
    }
  }
  const auto free = checker.are_free(clearance::States(rows, checker.size()), workspace);  // all cores
  std::printf("%d of %zu random states are free\n", std::accumulate(free.begin(), free.end(), 0), free.size());

  const auto motion = checker.check_motion(q, checker.state({{"joint2", 0.9}, {"joint4", -1.6}}), workspace);
  if (motion.verdict == clearance::Verdict::contact) {
    std::printf("the motion is proven free until t = %.2f, then %s touches %s\n", motion.t[0],
                motion.pair->first.c_str(), motion.pair->second.c_str());
  }
  return 0;
} catch (const clearance::Error &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
