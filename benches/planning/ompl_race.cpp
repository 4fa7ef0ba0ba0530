// RRT-Connect of OMPL on problems, with proven edges of clearance and with states of FCL:
//   ompl_race SEEDS SECONDS STEP PROBLEM_FILE...
//
// One line for each search: problem, validator, seed, 1 if solved, CPU time of the search (s), edges checked, states of the path,
// verdict of clearance on the path (1 free, 0 contact, -1 undecided; 2: no path). Loading and the set-up of the planner are not timed.
#include <clearance/ompl.hpp>

#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <ctime>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "fcl_validity.hpp"
#include "problem.hpp"

namespace {

namespace ob = ompl::base;

double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Limits {
  unsigned seeds;
  double seconds, step;
};

clearance::Pose pose_of(const Eigen::Isometry3d &pose) {
  const Eigen::Quaterniond turn(pose.linear());
  const Eigen::Vector3d &shift = pose.translation();
  return clearance::Pose({shift.x(), shift.y(), shift.z()}, {turn.x(), turn.y(), turn.z(), turn.w()});
}

clearance::World world_of(const Problem &problem) {
  clearance::World world;
  for (const Body &body : problem.obstacles) {
    const auto pose = pose_of(body.pose);
    if (body.shape == "box") {
      world.add_box(body.name, {body.sizes[0], body.sizes[1], body.sizes[2]}, pose);
    } else if (body.shape == "cylinder") {
      world.add_cylinder(body.name, body.sizes[0], body.sizes[1], pose);
    } else {
      std::vector<double> vertices;
      std::vector<std::uint32_t> triangles;
      for (const auto &vertex : body.mesh.vertices) {
        vertices.insert(vertices.end(), {vertex.x(), vertex.y(), vertex.z()});
      }
      for (const auto &triangle : body.mesh.triangles) {
        triangles.insert(triangles.end(), triangle.begin(), triangle.end());
      }
      world.add_mesh(body.name, vertices, triangles, pose);
    }
  }
  return world;
}

clearance::Checker checker_of(const Problem &problem) {
  const auto robot = clearance::Robot::from_urdf(problem.urdf, problem.srdf, {problem.packages});
  clearance::CheckerOptions options;
  options.group = problem.group;
  options.fixed.insert(problem.fixed.begin(), problem.fixed.end());
  options.allowed_collisions.assign(problem.allowed.begin(), problem.allowed.end());
  return clearance::Checker(robot, world_of(problem), options);
}

// Both validators have to give the same result for random states within the limits.
void check_agreement(const std::string &path, const clearance::Checker &checker, const FclValidity &fcl) {
  clearance::Workspace workspace(checker);
  const auto [lower, upper] = checker.limits();
  ompl::RNG random(1);
  for (int i = 0; i < 1000; ++i) {
    std::vector<double> q;
    for (std::size_t k = 0; k < lower.size(); ++k) {
      q.push_back(random.uniformReal(lower[k], upper[k]));
    }
    if (checker.is_free(q, workspace) != fcl.is_free(q.data())) {
      std::fprintf(stderr, "%s: clearance and FCL differ on random state %d\n", path.c_str(), i);
      std::exit(1);
    }
  }
}

void search(const std::string &path, const char *validator, const Problem &problem, const clearance::Checker &checker,
            ompl::geometric::SimpleSetup &setup, const Limits &limits, unsigned seed) {
  const auto si = setup.getSpaceInformation();
  const clearance::OmplJoints joints(setup.getStateSpace(), checker);
  ob::ScopedState<> start(setup.getStateSpace()), goal(setup.getStateSpace());
  joints.write(problem.start, start.get());
  joints.write(problem.goal, goal.get());
  setup.clear();
  ompl::RNG::setSeed(seed);
  setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(si));
  setup.setStartAndGoalStates(start, goal);
  setup.setup();
  si->getMotionValidator()->resetMotionCounter();
  const double begin = cpu_time();
  setup.solve(ob::PlannerTerminationCondition([&] { return cpu_time() - begin > limits.seconds; }));
  const double seconds = cpu_time() - begin;
  const bool is_solved = setup.haveExactSolutionPath();
  const unsigned edges = si->getMotionValidator()->getValidMotionCount() + si->getMotionValidator()->getInvalidMotionCount();
  int verdict = 2;
  std::size_t states = 0;
  if (is_solved) {
    clearance::Workspace workspace(checker);
    const auto &found = setup.getSolutionPath();
    states = found.getStateCount();
    verdict = static_cast<int>(checker.check_trajectory(clearance::trajectory_of(found, checker), workspace).verdict);
  }
  std::printf("%s %s %u %d %.9f %u %zu %d\n", path.c_str(), validator, seed, is_solved ? 1 : 0, seconds, edges, states, verdict);
  std::fflush(stdout);
}

void race(const std::string &path, const Limits &limits) {
  const Problem problem = problem_file::read(path);
  const auto checker = checker_of(problem);
  const auto space = clearance::ompl_state_space(checker);
  ompl::geometric::SimpleSetup proven(space), sampled(space);
  clearance::use_in_ompl(proven.getSpaceInformation(), checker);
  const auto fcl = std::make_shared<FclValidity>(sampled.getSpaceInformation(), problem);
  sampled.setStateValidityChecker(fcl);
  sampled.getSpaceInformation()->setStateValidityCheckingResolution(limits.step / space->getMaximumExtent());
  check_agreement(path, checker, *fcl);
  for (unsigned seed = 1; seed <= limits.seeds; ++seed) {
    search(path, "clearance", problem, checker, proven, limits, seed);
    search(path, "FCL", problem, checker, sampled, limits, seed);
  }
}

}  // namespace

int main(int count, char **arguments) try {
  if (count < 5) {
    std::fprintf(stderr, "ompl_race SEEDS SECONDS STEP PROBLEM_FILE...\n");
    return 2;
  }
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  const Limits limits{static_cast<unsigned>(std::stoul(arguments[1])), std::stod(arguments[2]), std::stod(arguments[3])};
  for (int i = 4; i < count; ++i) {
    race(arguments[i], limits);
  }
  return 0;
} catch (const std::exception &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
