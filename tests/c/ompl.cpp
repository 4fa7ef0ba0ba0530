// OMPL with proven motions: names of joints, the short way of continuous joints, last valid states, planning, certificates.

#include <clearance/ompl.hpp>

#include <ompl/base/spaces/SE2StateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>

#include "checks.h"

namespace ob = ompl::base;
namespace og = ompl::geometric;

namespace {

// An arm of 1 m that turns about z, and slides along x.
const char *const TURNER = R"(<robot name='turner'><link name='base'/><link name='cart'/><link name='arm'>
  <collision><origin xyz='0.5 0 0'/><geometry><box size='1 0.02 0.02'/></geometry></collision></link>
  <joint name='slide' type='prismatic'><parent link='base'/><child link='cart'/><axis xyz='1 0 0'/>
    <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>
  <joint name='turn' type='continuous'><parent link='cart'/><child link='arm'/><axis xyz='0 0 1'/></joint></robot>)";

template <typename Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const clearance::Error &error) {
    return error.what();
  }
  return "";
}

// A checker of the turner with a ball of 0.1 m at an angle of its circle of 0.8 m.
clearance::Checker turner(double angle) {
  const auto robot = clearance::Robot::from_urdf(TURNER);
  clearance::World world;
  world.add_sphere("ball", 0.1, clearance::Pose(0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.0));
  return clearance::Checker(robot, world);
}

ob::SpaceInformationPtr information(const ob::StateSpacePtr &space, const clearance::Checker &checker) {
  const auto si = std::make_shared<ob::SpaceInformation>(space);
  clearance::use_in_ompl(si, checker);
  si->setup();
  return si;
}

// A compound space of the turner, whose parts are in another order than the joints.
ob::StateSpacePtr compound(const std::string &circle_name, const std::string &dimension) {
  const auto space = std::make_shared<ob::CompoundStateSpace>();
  const auto circle = std::make_shared<ob::SO2StateSpace>();
  circle->setName(circle_name);
  const auto real = std::make_shared<ob::RealVectorStateSpace>();
  real->addDimension(dimension, -1.0, 1.0);
  space->addSubspace(circle, 1.0);
  space->addSubspace(real, 1.0);
  return space;
}

void check_names() {
  const auto checker = turner(0.0);
  CHECK(checker.joint_names() == (std::vector<std::string>{"slide", "turn"}));
  CHECK(!checker.is_continuous(0) && checker.is_continuous(1) && !checker.is_continuous(2));
  const auto space = compound("turn", "slide");
  const clearance::OmplJoints joints(space, checker);
  ob::ScopedState<ob::CompoundStateSpace> state(space);
  state->as<ob::SO2StateSpace::StateType>(0)->value = 0.25;
  state->as<ob::RealVectorStateSpace::StateType>(1)->values[0] = -0.5;
  std::vector<double> q;
  joints.read(state.get(), q);
  CHECK(q == (std::vector<double>{-0.5, 0.25}));
  joints.write(std::vector<double>{0.75, 7.0}, state.get());
  joints.read(state.get(), q);
  CHECK(q[0] == 0.75);
  CHECK_NEAR(q[1], 7.0 - 2.0 * M_PI, 1e-12);
  CHECK_TEXT(error_of([&] { joints.write(std::vector<double>(3), state.get()); }).c_str(), "has 2 joints, but 3");

  const auto made = clearance::ompl_state_space(checker);
  CHECK(made->isCompound() && made->getDimension() == 2);
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(compound("wheel", "slide"), checker); }).c_str(), "no joint 'turn'");
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(compound("slide", "turn"), checker); }).c_str(), "'slide' is not continuous");
  const auto more = compound("turn", "slide");
  more->as<ob::CompoundStateSpace>()->addSubspace(std::make_shared<ob::SO2StateSpace>(), 1.0);
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(more, checker); }).c_str(), "3 values, but the checker has 2 joints");
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(std::make_shared<ob::SE2StateSpace>(), checker); }).c_str(), "no joint 'slide'");
  // a space that is named like a joint is not that joint
  const auto misnamed = std::make_shared<ob::RealVectorStateSpace>();
  misnamed->addDimension("slide", -1.0, 1.0);
  misnamed->addDimension("other", -1.0, 1.0);
  misnamed->setName("turn");
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(misnamed, checker); }).c_str(), "one value of its own");
}

// A space that interpolates along circles: straight lines are not what it moves along.
class Bent : public ob::RealVectorStateSpace {
 public:
  Bent() : ob::RealVectorStateSpace(2) {
    setBounds(-1.0, 1.0);
  }
  void interpolate(const ob::State *from, const ob::State *to, double t, ob::State *state) const override {
    ob::RealVectorStateSpace::interpolate(from, to, t, state);
    state->as<StateType>()->values[0] += t * (1.0 - t);
  }
};

void check_bent_space() {
  CHECK_TEXT(error_of([] { clearance::OmplJoints(std::make_shared<Bent>(), turner(0.0)); }).c_str(), "along straight lines");
  const auto straight = std::make_shared<ob::RealVectorStateSpace>(2);
  straight->setBounds(-1.0, 1.0);
  CHECK(error_of([&] { clearance::OmplJoints(straight, turner(0.0)); }).empty());
}

ob::ScopedState<> turned(const ob::SpaceInformationPtr &si, double angle) {
  ob::ScopedState<> state(si->getStateSpace());
  state["turn"] = angle;
  state["slide"] = 0.0;
  return state;
}

// The arm turns from 2 to -2 rad through the half turn; a ball there is met, a ball at 0 is not.
void check_short_way() {
  const auto space = compound("turn", "slide");
  const auto away = information(space, turner(0.0));
  const auto from = turned(away, 2.0), to = turned(away, -2.0);
  CHECK(away->isValid(from.get()) && !away->isValid(turned(away, 0.0).get()));
  CHECK(away->checkMotion(from.get(), to.get()));
  CHECK(!away->checkMotion(turned(away, 1.5).get(), turned(away, -1.5).get()));

  const auto met = information(compound("turn", "slide"), turner(M_PI));
  const auto start = turned(met, 2.0);
  auto end = turned(met, -2.0);
  CHECK(!met->checkMotion(start.get(), end.get()));
  CHECK(met->checkMotion(turned(met, 1.5).get(), turned(met, -1.5).get()));

  // the side of the arm meets the ball where 0.8 m sin(d) = 0.1 m + 0.01 m
  const double contact = (M_PI - std::asin(0.11 / 0.8) - 2.0) / (2.0 * M_PI - 4.0);
  ob::ScopedState<> last(met->getStateSpace());
  std::pair<ob::State *, double> last_valid(last.get(), -1.0);
  CHECK(!met->checkMotion(start.get(), end.get(), last_valid));
  CHECK(last_valid.second <= contact && last_valid.second > contact - 0.01);
  CHECK(met->isValid(last.get()));
  CHECK_NEAR(last["turn"], 2.0 + last_valid.second * (2.0 * M_PI - 4.0), 1e-12);
  // the result may be written over the end
  last_valid = {end.get(), -1.0};
  CHECK(!met->checkMotion(start.get(), end.get(), last_valid));
  CHECK(end["turn"] == last["turn"]);
  // no place for the state; and a motion that is free changes nothing
  last_valid = {nullptr, -1.0};
  CHECK(!met->checkMotion(start.get(), turned(met, -2.0).get(), last_valid) && last_valid.second > 0.0);
  last_valid = {last.get(), -1.0};
  CHECK(met->checkMotion(start.get(), turned(met, 1.0).get(), last_valid) && last_valid.second == -1.0);
  // the end is out of the bounds
  ob::ScopedState<> outside = turned(met, 1.0);
  outside["slide"] = 1.5;
  CHECK(!met->isValid(outside.get()) && !met->checkMotion(start.get(), outside.get()));
  CHECK(!met->checkMotion(start.get(), outside.get(), last_valid) && last_valid.second == 0.0 && last["turn"] == 2.0);
  CHECK(met->getMotionValidator()->getInvalidMotionCount() == 6 && met->getMotionValidator()->getValidMotionCount() == 2);
}

void check_clearance() {
  const auto si = information(compound("turn", "slide"), turner(0.0));
  // beside the ball by an angle: the distance of a line and a ball
  CHECK_NEAR(si->getStateValidityChecker()->clearance(turned(si, 0.4).get()), 0.8 * std::sin(0.4) - 0.11, 1e-6);
  CHECK(si->getStateValidityChecker()->clearance(turned(si, M_PI).get()) == 0.5);
  CHECK_NEAR(si->getStateValidityChecker()->clearance(turned(si, 0.0).get()), -0.11, 1e-3);
}

// Planners may ask from several threads.
void check_threads() {
  const auto si = information(compound("turn", "slide"), turner(0.0));
  std::vector<int> wrong(4, 1);
  std::vector<std::thread> threads;
  for (int &count : wrong) {
    threads.emplace_back([&] {
      count = 0;
      for (int i = 0; i < 500; ++i) {
        const double angle = -3.0 + 6.0 * i / 500.0;
        const bool is_free = std::abs(0.8 * std::sin(angle)) > 0.11 || std::cos(angle) < 0.0;
        count += si->isValid(turned(si, angle).get()) == is_free ? 0 : 1;
      }
    });
  }
  for (std::thread &thread : threads) {
    thread.join();
  }
  CHECK(wrong == std::vector<int>(4, 0));
}

// RRTConnect on the demo arm; its path is proven, and the proof verified.
void check_planning() {
  const auto robot = clearance::Robot::from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf");
  const auto world = clearance::World::from_file("config/demo_world.yaml", robot);
  clearance::CheckerOptions options;
  options.group = "arm";
  const clearance::Checker checker(robot, world, options);
  og::SimpleSetup setup(clearance::ompl_state_space(checker));
  clearance::use_in_ompl(setup.getSpaceInformation(), checker);
  ob::ScopedState<> start(setup.getStateSpace()), goal(setup.getStateSpace());
  const clearance::OmplJoints joints(setup.getStateSpace(), checker);
  joints.write(checker.state({{"joint1", -0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}}), start.get());
  joints.write(checker.state({{"joint1", 0.8}, {"joint2", 0.5}, {"joint4", -1.6}, {"joint6", 1.8}}), goal.get());
  setup.setStartAndGoalStates(start, goal);
  setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
  CHECK(!setup.getSpaceInformation()->checkMotion(start.get(), goal.get()));
  // the number of attempts is limited, not the time
  unsigned int attempts = 0;
  const ob::PlannerTerminationCondition is_enough([&] { return ++attempts > 20000; });
  CHECK(setup.solve(is_enough) == ob::PlannerStatus::EXACT_SOLUTION);
  setup.simplifySolution();
  const og::PathGeometric &path = setup.getSolutionPath();

  clearance::Workspace workspace(checker);
  const auto report = clearance::certify(path, checker, workspace);
  CHECK(report.is_free() && report.certificate.has_value());
  clearance::Expectation expected;
  expected.options = options;
  expected.motion = clearance::trajectory_of(path, checker);
  const auto verified = report.certificate->verify(robot, world, expected);
  CHECK(verified && verified.segments == path.getStateCount() - 1);
  CHECK(clearance::trajectory_of(path, checker).positions.size() == 7 * path.getStateCount());
}

// A path of a continuous joint over the half turn is proven as it is interpolated.
void check_path_over_half_turn() {
  const auto checker = turner(0.0);
  const auto si = information(compound("turn", "slide"), checker);
  og::PathGeometric path(si);
  for (const double angle : {2.0, 3.0, -3.0, -2.0}) {
    path.append(turned(si, angle).get());
  }
  const auto trajectory = clearance::trajectory_of(path, checker);
  CHECK_NEAR(trajectory.positions.back(), 2.0 * M_PI - 2.0, 1e-12);
  clearance::Workspace workspace(checker);
  CHECK(clearance::certify(path, checker, workspace).is_free());
}

}  // namespace

int main() {
  ompl::msg::setLogLevel(ompl::msg::LOG_WARN);
  ompl::RNG::setSeed(1);
  try {
    check_names();
    check_bent_space();
    check_short_way();
    check_clearance();
    check_threads();
    check_planning();
    check_path_over_half_turn();
  } catch (const std::exception &error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  std::cout << failed_checks << " checks failed\n";
  return failed_checks == 0 ? 0 : 1;
}
