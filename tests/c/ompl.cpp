// OMPL with proven motions: names of joints, the short way of continuous joints, last valid states, planning, certificates.

// OMPL needs Eigen: included first here, which must not change the classes of clearance
#include <Eigen/Geometry>

#include <clearance/ompl.hpp>

#include <ompl/base/spaces/DiscreteStateSpace.h>
#include <ompl/base/spaces/SE2StateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/cforest/CForestStateSpaceWrapper.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>
#include <type_traits>

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

// without CLEARANCE_WITH_EIGEN, vectors are accepted, and nothing else
static_assert(std::is_constructible_v<clearance::Positions, Eigen::VectorXd>);
static_assert(!std::is_constructible_v<clearance::Pose, Eigen::Isometry3d>);
static_assert(!std::is_constructible_v<clearance::States, Eigen::MatrixXd>);

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
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(compound("slide", "turn"), checker); }).c_str(), "'slide' is in an SO2StateSpace, but a whole turn of it is another state");
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

// OMPL would interpolate the components of a quaternion, which is another motion than the proven one.
void check_floating_joint() {
  const auto robot = clearance::Robot::from_urdf(
      "<robot name='r'><link name='world'/><link name='body'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
      "<joint name='free' type='floating'><parent link='world'/><child link='body'/></joint></robot>");
  const clearance::Checker checker(robot, clearance::World());
  const auto unnamed = std::make_shared<ob::RealVectorStateSpace>(7);
  unnamed->setBounds(-1.0, 1.0);
  const std::string errors[] = {
      error_of([&] { clearance::OmplJoints(unnamed, checker); }),
      error_of([&] { clearance::OmplJoints(unnamed, checker, clearance::OmplSpaces::straight); }),
      error_of([&] { clearance::ompl_state_space(checker); }),
  };
  for (const std::string &error : errors) {
    CHECK_TEXT(error.c_str(), "the floating joint 'free' cannot be planned with OMPL");
  }
}

// A whole turn of a continuous joint moves a joint that follows it at half its angle.
void check_circle_with_mimic_joint() {
  const clearance::Checker checker(clearance::Robot::from_urdf(
      "<robot name='r'><link name='base'/><link name='wheel'/><link name='hand'/>"
      "<joint name='turn' type='continuous'><parent link='base'/><child link='wheel'/><axis xyz='0 0 1'/></joint>"
      "<joint name='half' type='continuous'><parent link='wheel'/><child link='hand'/><axis xyz='0 0 1'/>"
      "<mimic joint='turn' multiplier='0.5'/></joint></robot>"));
  const auto circle = std::make_shared<ob::SO2StateSpace>();
  circle->setName("turn");
  const auto space = std::make_shared<ob::CompoundStateSpace>();
  space->addSubspace(circle, 1.0);
  CHECK(checker.joint_names() == (std::vector<std::string>{"turn"}) && !checker.is_continuous(0));
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(space, checker); }).c_str(), "or other joints mimic it");
}

// A part without joints would be ignored; half a turn is written within the bounds.
void check_parts() {
  const auto checker = turner(0.0);
  const auto space = compound("turn", "slide");
  const auto part = std::make_shared<ob::DiscreteStateSpace>(0, 3);
  part->setName("gear");
  space->as<ob::CompoundStateSpace>()->addSubspace(part, 1.0);
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(space, checker); }).c_str(), "'gear' is neither");
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(space, checker, clearance::OmplSpaces::straight); }).c_str(),
             "'gear' has no joint of the checker");
  const auto made = clearance::ompl_state_space(checker);
  const clearance::OmplJoints joints(made, checker);
  ob::ScopedState<> state(made);
  for (const double angle : {M_PI, -M_PI, 3.0 * M_PI, -3.0 * M_PI, 7.0}) {
    joints.write(std::vector<double>{0.0, angle}, state.get());
    CHECK(made->satisfiesBounds(state.get()));
    CHECK_NEAR(std::cos(state["turn"]), std::cos(angle), 1e-12);
  }
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
  constexpr auto promised = clearance::OmplSpaces::straight;
  CHECK_TEXT(error_of([] { clearance::OmplJoints(std::make_shared<Bent>(), turner(0.0)); }).c_str(), "promise it with OmplSpaces::straight");
  CHECK_TEXT(error_of([] { clearance::OmplJoints(std::make_shared<Bent>(), turner(0.0), promised); }).c_str(),
             "does not interpolate along straight lines");
  // without bounds, when all states that a test could draw are the same
  const auto point = std::make_shared<Bent>();
  point->setBounds(0.0, 0.0);
  CHECK_TEXT(error_of([&] { information(point, turner(0.0)); }).c_str(), "may not interpolate along straight lines");
  // a class of its own that is straight
  class Named : public ob::RealVectorStateSpace {
   public:
    Named() : ob::RealVectorStateSpace(2) { setBounds(-1.0, 1.0); }
  };
  const auto named = std::make_shared<Named>();
  CHECK(!error_of([&] { clearance::OmplJoints(named, turner(0.0)); }).empty());
  CHECK(error_of([&] { clearance::OmplJoints(named, turner(0.0), promised); }).empty());
  const auto si = std::make_shared<ob::SpaceInformation>(named);
  clearance::use_in_ompl(si, turner(0.0), {}, promised);
  ob::RealVectorBounds bounds(2);
  bounds.setLow(-1.0);
  bounds.setHigh(1.0);
  bounds.setHigh(1, INFINITY);
  named->setBounds(bounds);
  CHECK_TEXT(error_of([&] { clearance::OmplJoints(named, turner(0.0), promised); }).c_str(), "dimension 1 of the state space");
  const auto straight = std::make_shared<ob::RealVectorStateSpace>(2);
  straight->setBounds(-1.0, 1.0);
  CHECK(error_of([&] { clearance::OmplJoints(straight, turner(0.0)); }).empty());
  straight->setBounds(0.0, 0.0);
  CHECK(error_of([&] { clearance::OmplJoints(straight, turner(0.0)); }).empty());
}

ob::ScopedState<> turned(const ob::SpaceInformationPtr &si, double angle) {
  ob::ScopedState<> state(si->getStateSpace());
  state["turn"] = angle;
  state["slide"] = 0.0;
  return state;
}

// The space of the paths of CForest hides the joints; its states fit into a path of the own space.
void check_path_of_cforest() {
  const auto checker = turner(0.0);
  for (const auto &space : {compound("turn", "slide"), clearance::ompl_state_space(checker)}) {
    const auto si = information(space, checker);
    const auto wrapper = std::make_shared<ob::CForestStateSpaceWrapper>(nullptr, space.get());
    const og::PathGeometric found(std::make_shared<ob::SpaceInformation>(wrapper), turned(si, 2.0).get(), turned(si, 2.5).get());
    for (const auto spaces : {clearance::OmplSpaces::known, clearance::OmplSpaces::straight}) {
      CHECK_TEXT(error_of([&] { clearance::trajectory_of(found, checker, spaces); }).c_str(), "a wrapper of the planner CForest");
    }
    og::PathGeometric own(si);
    for (std::size_t i = 0; i < found.getStateCount(); ++i) {
      own.append(found.getState(static_cast<unsigned int>(i)));
    }
    clearance::Workspace workspace(checker);
    CHECK(clearance::certify(own, checker, workspace).is_free());
  }
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
  // values that are not finite are within the bounds of OMPL, but not free
  ob::ScopedState<> lost = turned(met, 1.0);
  lost["slide"] = NAN;
  CHECK(!met->isValid(lost.get()) && !met->checkMotion(start.get(), lost.get()) && !met->checkMotion(lost.get(), start.get()));
  CHECK(!met->checkMotion(start.get(), lost.get(), last_valid) && last_valid.second == 0.0 && last["turn"] == 2.0);
  CHECK(!met->checkMotion(outside.get(), start.get()));
  CHECK(met->getMotionValidator()->getInvalidMotionCount() == 10 && met->getMotionValidator()->getValidMotionCount() == 2);
}

void check_clearance() {
  const auto si = information(compound("turn", "slide"), turner(0.0));
  // beside the ball by an angle: the distance of a line and a ball
  CHECK_NEAR(si->getStateValidityChecker()->clearance(turned(si, 0.4).get()), 0.8 * std::sin(0.4) - 0.11, 1e-6);
  CHECK(si->getStateValidityChecker()->clearance(turned(si, M_PI).get()) == 0.5);
  CHECK_NEAR(si->getStateValidityChecker()->clearance(turned(si, 0.0).get()), -0.11, 1e-3);
}

// Distances are cut at the largest one.
void check_specs() {
  const auto si = information(compound("turn", "slide"), turner(0.0));
  CHECK(si->getStateValidityChecker()->getSpecs().clearanceComputationType == ob::StateValidityCheckerSpecs::BOUNDED_APPROXIMATE);
}

// Planners may check from several threads.
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

  // every motion is counted
  constexpr unsigned int MOTIONS = 20000;
  threads.clear();
  for (int i = 0; i < 2; ++i) {
    threads.emplace_back([&] {
      const auto from = turned(si, 2.0), to = turned(si, 2.1);
      for (unsigned int k = 0; k < MOTIONS; ++k) {
        si->checkMotion(from.get(), to.get());
      }
    });
  }
  for (std::thread &thread : threads) {
    thread.join();
  }
  CHECK(si->getMotionValidator()->getValidMotionCount() == 2 * MOTIONS);
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

// The proven motion is the one that the space interpolates, also for differences of exactly half a turn and after whole turns.
void check_path_of(const std::vector<double> &angles) {
  const auto checker = turner(0.0);
  const auto si = information(compound("turn", "slide"), checker);
  const auto &space = si->getStateSpace();
  og::PathGeometric path(si);
  for (const double angle : angles) {
    path.append(turned(si, angle).get());
  }
  const std::vector<double> rows = clearance::trajectory_of(path, checker).positions;
  bool is_free = true;
  ob::ScopedState<> between(space);
  for (std::size_t i = 0; i + 1 < angles.size(); ++i) {
    for (int k = 0; k <= 64; ++k) {
      const double t = k / 64.0, proven = rows[2 * i + 1] + t * (rows[2 * i + 3] - rows[2 * i + 1]);
      space->interpolate(path.getState(i), path.getState(i + 1), t, between.get());
      CHECK_NEAR(std::cos(between["turn"]), std::cos(proven), 1e-12);
      CHECK_NEAR(std::sin(between["turn"]), std::sin(proven), 1e-12);
      is_free = is_free && si->isValid(between.get());
    }
  }
  clearance::Workspace workspace(checker);
  const bool is_proven = clearance::certify(path, checker, workspace).is_free();
  CHECK(is_free || !is_proven);
}

void check_half_turns() {
  const double half = M_PI / 2;
  check_path_of({half, -M_PI, -half, half});
  check_path_of({half, -M_PI, 0.0, half});
  check_path_of({-half, half, -M_PI, 0.0, -M_PI, -half, half});
  for (const double d : {0.25, 0.5, 0.75, 1.0, 1.25}) {
    check_path_of({half + d, -M_PI + d / 2, -M_PI + d, d, d + 0.1});
  }
  // half a turn is out of the bounds of an SO2StateSpace
  const auto checker = turner(0.0);
  const auto si = information(compound("turn", "slide"), checker);
  og::PathGeometric path(si);
  for (const double angle : {half, M_PI, -half, half}) {
    path.append(turned(si, angle).get());
  }
  CHECK(!si->satisfiesBounds(path.getState(1)));
  CHECK_TEXT(error_of([&] { clearance::trajectory_of(path, checker); }).c_str(), "state 1 of the path is not within the bounds");
}

}  // namespace

int main() {
  ompl::msg::setLogLevel(ompl::msg::LOG_WARN);
  ompl::RNG::setSeed(1);
  try {
    check_names();
    check_floating_joint();
    check_circle_with_mimic_joint();
    check_path_of_cforest();
    check_bent_space();
    check_parts();
    check_short_way();
    check_half_turns();
    check_clearance();
    check_specs();
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
