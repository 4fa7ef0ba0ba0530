// Plans with OMPL: every motion is proven, and the whole path has a proof that can be verified. Run it in the repository.

#include <clearance/ompl.hpp>

#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>

#include <cstdio>

int main() try {
  const auto robot = clearance::Robot::from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf");
  const auto world = clearance::World::from_file("config/demo_world.yaml", robot);
  clearance::CheckerOptions options;
  options.group = "arm";
  const clearance::Checker checker(robot, world, options);

  ompl::geometric::SimpleSetup setup(clearance::ompl_state_space(checker));
  clearance::use_in_ompl(setup.getSpaceInformation(), checker);
  const clearance::OmplJoints joints(setup.getStateSpace(), checker);
  ompl::base::ScopedState<> start(setup.getStateSpace()), goal(setup.getStateSpace());
  joints.write(checker.state({{"joint1", -0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}}), start.get());
  joints.write(checker.state({{"joint1", 0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}}), goal.get());
  setup.setStartAndGoalStates(start, goal);
  setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(setup.getSpaceInformation()));
  if (!setup.solve(60.0)) {
    std::printf("no path within a minute\n");
    return 1;
  }
  setup.simplifySolution();
  const auto &path = setup.getSolutionPath();

  clearance::Workspace workspace(checker);
  const auto report = clearance::certify(path, checker, workspace);
  if (!report.certificate) {
    std::printf("the path is not proven\n");
    return 1;
  }
  clearance::Expectation expected;
  expected.options = options;
  expected.motion = clearance::trajectory_of(path, checker);
  const auto verified = report.certificate->verify(robot, world, expected);
  std::printf("%zu states, length %.2f rad, verified: %s\n", path.getStateCount(), path.length(),
              verified ? "yes" : verified.reason.c_str());
  return verified ? 0 : 1;
} catch (const clearance::Error &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
