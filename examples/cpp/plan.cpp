// Plans a path of the demo arm over its shelf, and verifies the proof that it is free. Run it in the repository.

#include <clearance.hpp>

#include <cstdio>

int main() try {
  const auto robot = clearance::Robot::from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf");
  const auto world = clearance::World::from_file("config/demo_world.yaml", robot);
  clearance::CheckerOptions options;
  options.group = "arm";
  const clearance::Checker checker(robot, world, options);
  clearance::Workspace workspace(checker);

  const auto start = checker.state({{"joint1", -0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}});
  const auto goal = checker.state({{"joint1", 0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}});
  clearance::PlanOptions limits;
  limits.certificate = true;
  const auto plan = checker.plan(start, goal, workspace, limits);
  if (!plan.is_found) {
    std::printf("no path: %s\n", plan.reason.c_str());
    return 1;
  }
  std::printf("%zu states, length %.2f rad, %llu edges checked\n", plan.states.size(), plan.length,
              static_cast<unsigned long long>(plan.edges));

  // the proof says which motion it is about: compare it with the path
  clearance::Expectation expected;
  expected.options = options;
  expected.motion.emplace();
  expected.motion->n = checker.size();
  for (const auto &state : plan.states) {
    expected.motion->positions.insert(expected.motion->positions.end(), state.begin(), state.end());
  }
  const auto verified = plan.certificate->verify(robot, world, expected);
  std::printf("verified: %s, %zu segments, %zu pairs of bodies\n", verified ? "yes" : verified.reason.c_str(),
              verified.segments, verified.pairs);
  return verified ? 0 : 1;
} catch (const clearance::Error &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
