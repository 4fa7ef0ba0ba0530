// clearance in OMPL: validity of states, motions that are proven free, and the certificate of a path. Header only; needs OMPL 1.5 or newer.
//
// A motion of OMPL is valid only if it is proven free at every point, for the straight line in joint space that the state space
// interpolates: the resolution of OMPL's validity checking has no effect. Continuous joints in an SO2StateSpace take the short way, as
// there.
//
// Values of a state space are joints by name: the dimension names of a RealVectorStateSpace, and the names of SO2StateSpaces, also inside
// of CompoundStateSpaces. A RealVectorStateSpace without dimension names has the joints of the checker in their order.
//
// A proof is about straight lines, which RealVectorStateSpace, SO2StateSpace and CompoundStateSpaces of these move along. Other classes of
// state spaces are rejected, unless the caller promises the same of them (OmplSpaces::straight).
//
// Threads: planners may check states and motions from any number of threads.

#ifndef CLEARANCE_OMPL_HPP
#define CLEARANCE_OMPL_HPP

#include "../clearance.hpp"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateSpace.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/SO2StateSpace.h>
#include <ompl/geometric/PathGeometric.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

namespace clearance {

// State spaces that are accepted.
enum class OmplSpaces {
  // Only RealVectorStateSpace, SO2StateSpace and CompoundStateSpace, not classes that are derived from them.
  known,
  // Any class. The caller promises that the space interpolates along straight lines between joint positions, on which values of
  // SO2StateSpaces take the short way: otherwise, motions are called free that are not proven. A few motions between the bounds are
  // tested, which must be set and finite; this finds mistakes, and proves nothing.
  straight
};

namespace detail {

// Throws Error for a floating joint: spaces of real values interpolate the components of its quaternion, but a motion turns the short
// way.
inline void reject_floating(const std::vector<std::string> &names) {
  const std::string last = "/rot_w";
  for (const std::string &name : names) {
    if (name.size() <= last.size() || name.compare(name.size() - last.size(), last.size(), last) != 0) {
      continue;
    }
    const std::string joint = name.substr(0, name.size() - last.size());
    const auto has = [&](const char *part) { return std::find(names.begin(), names.end(), joint + part) != names.end(); };
    if (has("/trans_x") && has("/trans_y") && has("/trans_z") && has("/rot_x") && has("/rot_y") && has("/rot_z")) {
      throw Error(CLEARANCE_STATUS_REJECTED,
                  "the floating joint '" + joint + "' cannot be planned with OMPL: leave it out, by the group of the checker");
    }
  }
}

// Throws Error for the space of the paths of CForest, whose parts and locations of values are not accessible.
inline void reject_wrapper(const ::ompl::base::StateSpace &space) {
  const std::string type = typeid(space).name();
  if (type.find("CForestStateSpaceWrapper") != std::string::npos) {
    throw Error(CLEARANCE_STATUS_REJECTED, "the state space '" + space.getName() +
                                               "' is a wrapper of the planner CForest, which hides the joints: append the states of the "
                                               "path to a PathGeometric of the SpaceInformation that the planner was made with");
  }
}

}  // namespace detail

// Where the positions of a checker are in the states of an OMPL space.
//
// Throws Error for a floating joint, if a joint is missing, if the space has values or parts that are not joints, if a whole turn of a
// joint in an SO2StateSpace is another state (it has limits, or other joints mimic it), if the space may not interpolate along straight
// lines, or if it is the wrapper of the planner CForest.
class OmplJoints {
 public:
  OmplJoints(const ::ompl::base::StateSpacePtr &space, const Checker &checker, OmplSpaces spaces = OmplSpaces::known)
      : space_(space) {
    detail::reject_wrapper(*space);
    space->computeLocations();
    const std::vector<std::string> names = checker.joint_names();
    detail::reject_floating(names);
    if (!is_in_order(names.size())) {
      for (std::size_t i = 0; i < names.size(); ++i) {
        add(names[i], checker.is_continuous(i));
      }
      reject_other_values(names);
    }
    check_parts(*space_, spaces);
    if (spaces == OmplSpaces::straight) {
      check_interpolation();
    }
  }

  // Writes the joint positions (rad, m) of a state.
  void read(const ::ompl::base::State *state, std::vector<double> &q) const {
    q.resize(values_.size());
    for (std::size_t i = 0; i < values_.size(); ++i) {
      q[i] = *space_->getValueAddressAtLocation(state, values_[i].location);
    }
  }

  // Writes both ends of the motion that the space interpolates: a straight line, on which circular joints take the short way.
  void read_motion(const ::ompl::base::State *s1, const ::ompl::base::State *s2, std::vector<double> &from,
                   std::vector<double> &to) const {
    read(s1, from);
    read(s2, to);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      to[i] += TURN * turns_between(i, from[i], to[i]);
    }
  }

  // Writes the motion along states that the space interpolates, row by row: whole turns are added to circular joints.
  //
  // Throws Error for a state out of the bounds of the space, or with a value that is not finite.
  void read_path(const std::vector<const ::ompl::base::State *> &states, std::vector<double> &rows) const {
    std::vector<double> last, q, turns(values_.size(), 0.0);
    rows.clear();
    for (std::size_t i = 0; i < states.size(); ++i) {
      read(states[i], q);
      if (!space_->satisfiesBounds(states[i]) || !is_finite(q)) {
        throw Error(CLEARANCE_STATUS_REJECTED, "state " + std::to_string(i) + " of the path is not within the bounds of the state space '" +
                                                   space_->getName() + "': call enforceBounds for it");
      }
      for (std::size_t k = 0; k < q.size(); ++k) {
        // from the values as they are in the states, as OMPL does: whole turns would round the difference
        turns[k] += i == 0 ? 0.0 : turns_between(k, last[k], q[k]);
        rows.push_back(q[k] + TURN * turns[k]);
      }
      last = q;
    }
  }

  // False for values that are NaN or infinite, which are within the bounds of some spaces of OMPL.
  static bool is_finite(const std::vector<double> &q) {
    return std::all_of(q.begin(), q.end(), [](double value) { return std::isfinite(value); });
  }

  // Writes joint positions (rad, m) into a state.
  void write(Positions q, ::ompl::base::State *state) const {
    if (q.size() != values_.size()) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "the state has " + std::to_string(values_.size()) + " joints, but " +
                                                 std::to_string(q.size()) + " positions are given");
    }
    for (std::size_t i = 0; i < values_.size(); ++i) {
      double value = q.data()[i];
      if (values_[i].is_circular) {
        value -= TURN * std::round(value / TURN);
        // half a turn is out of the bounds of an SO2StateSpace, minus half a turn is not
        value = value >= 0.5 * TURN ? value - TURN : value;
      }
      *space_->getValueAddressAtLocation(state, values_[i].location) = value;
    }
  }

 private:
  static constexpr double TURN = 6.283185307179586476925286766559;

  struct Value {
    ::ompl::base::StateSpace::ValueLocation location;
    bool is_circular;
  };

  // Whole turns to add to `to`, so that a circular joint goes the short way from `from`, as in SO2StateSpace::interpolate: both are
  // within half a turn, and a difference of exactly half a turn is as given.
  double turns_between(std::size_t i, double from, double to) const {
    const double difference = to - from;
    if (!values_[i].is_circular || !(std::abs(difference) > 0.5 * TURN)) {
      return 0.0;
    }
    return difference > 0.0 ? -1.0 : 1.0;
  }

  // A space of real values without names: takes the joints in their order.
  bool is_in_order(std::size_t count) {
    if (space_->getType() != ::ompl::base::STATE_SPACE_REAL_VECTOR || space_->getDimension() != count) {
      return false;
    }
    const auto *real = space_->as<::ompl::base::RealVectorStateSpace>();
    for (unsigned int i = 0; i < real->getDimension(); ++i) {
      if (!real->getDimensionName(i).empty()) {
        return false;
      }
    }
    for (const auto &location : space_->getValueLocations()) {
      values_.push_back({location, false});
    }
    return true;
  }

  void add(const std::string &name, bool is_continuous) {
    const auto &named = space_->getValueLocationsByName();
    const auto found = named.find(name);
    if (found == named.end()) {
      throw Error(CLEARANCE_STATUS_REJECTED, "the state space has no joint '" + name +
                                                 "': give this name to a dimension of a RealVectorStateSpace (setDimensionName), or to "
                                                 "an SO2StateSpace (setName)");
    }
    const int type = found->second.stateLocation.space->getType();
    if (type != ::ompl::base::STATE_SPACE_REAL_VECTOR && type != ::ompl::base::STATE_SPACE_SO2) {
      throw Error(CLEARANCE_STATUS_REJECTED,
                  "joint '" + name + "' is neither in a RealVectorStateSpace nor in an SO2StateSpace: use one of these");
    }
    const bool is_circular = type == ::ompl::base::STATE_SPACE_SO2;
    if (is_circular && !is_continuous) {
      throw Error(CLEARANCE_STATUS_REJECTED, "joint '" + name +
                                                 "' is in an SO2StateSpace, but a whole turn of it is another state: it is not continuous, "
                                                 "or other joints mimic it: use a dimension of a RealVectorStateSpace");
    }
    values_.push_back({found->second, is_circular});
  }

  // Values that are not joints of the checker would be ignored.
  void reject_other_values(const std::vector<std::string> &names) const {
    const std::size_t count = space_->getValueLocations().size();
    const ::ompl::base::ScopedState<> state(space_);
    std::set<const double *> addresses;
    for (const Value &value : values_) {
      addresses.insert(space_->getValueAddressAtLocation(state.get(), value.location));
    }
    if (count == names.size() && addresses.size() == names.size()) {
      return;
    }
    std::string list;
    for (const std::string &name : names) {
      list += (list.empty() ? "" : ", ") + name;
    }
    throw Error(CLEARANCE_STATUS_REJECTED, "the state space has " + std::to_string(count) + " values, but the checker has " +
                                               std::to_string(names.size()) +
                                               " joints, each of which needs one value of its own: " + list);
  }

  // Rejects parts that may interpolate along other paths than the proven ones, and parts without joints, which would be ignored.
  void check_parts(const ::ompl::base::StateSpace &part, OmplSpaces spaces) const {
    const bool is_known = typeid(part) == typeid(::ompl::base::CompoundStateSpace) ||
                          typeid(part) == typeid(::ompl::base::RealVectorStateSpace) ||
                          typeid(part) == typeid(::ompl::base::SO2StateSpace);
    if (spaces == OmplSpaces::known && !is_known) {
      throw Error(CLEARANCE_STATUS_REJECTED, "the state space '" + part.getName() +
                                                 "' is neither a RealVectorStateSpace nor an SO2StateSpace nor a CompoundStateSpace of "
                                                 "these, so that it may not interpolate along straight lines between joint positions, "
                                                 "which alone are proven: use these, or promise it with OmplSpaces::straight");
    }
    if (part.isCompound()) {
      const auto *compound = part.as<::ompl::base::CompoundStateSpace>();
      for (unsigned int i = 0; i < compound->getSubspaceCount(); ++i) {
        check_parts(*compound->getSubspace(i), spaces);
      }
      return;
    }
    const auto is_in_part = [&](const Value &value) { return value.location.stateLocation.space == &part; };
    if (part.getDimension() > 0 && std::none_of(values_.begin(), values_.end(), is_in_part)) {
      throw Error(CLEARANCE_STATUS_REJECTED,
                  "the state space '" + part.getName() + "' has no joint of the checker: leave it out of the compound space");
    }
  }

  // Without bounds there are no states between them to test.
  void check_bounds() const {
    for (const Value &value : values_) {
      const auto *part = value.location.stateLocation.space;
      if (part->getType() != ::ompl::base::STATE_SPACE_REAL_VECTOR) {
        continue;
      }
      const auto &bounds = part->as<::ompl::base::RealVectorStateSpace>()->getBounds();
      const std::size_t k = value.location.index;
      if (!std::isfinite(bounds.high[k] - bounds.low[k])) {
        const std::string &name = part->as<::ompl::base::RealVectorStateSpace>()->getDimensionName(static_cast<unsigned int>(k));
        throw Error(CLEARANCE_STATUS_REJECTED, "dimension " + std::to_string(k) + (name.empty() ? "" : " ('" + name + "')") +
                                                   " of the state space '" + part->getName() +
                                                   "' has no finite bounds: call setBounds before this");
      }
    }
  }

  // Tests some motions of a space whose class is not known.
  void check_interpolation() const {
    check_bounds();
    const auto sampler = space_->allocDefaultStateSampler();
    ::ompl::base::ScopedState<> a(space_), b(space_), middle(space_);
    std::vector<double> from, to, q;
    for (int i = 0; i < PROBES; ++i) {
      sampler->sampleUniform(a.get());
      sampler->sampleUniform(b.get());
      read_motion(a.get(), b.get(), from, to);
      space_->interpolate(a.get(), b.get(), PROBE, middle.get());
      read(middle.get(), q);
      std::vector<double> expected(from);
      for (std::size_t k = 0; k < from.size(); ++k) {
        expected[k] += PROBE * (to[k] - from[k]);
      }
      for (std::size_t k = 0; k < q.size(); ++k) {
        const double difference = q[k] - expected[k];
        const double turned = values_[k].is_circular ? difference - TURN * std::round(difference / TURN) : difference;
        if (!(std::abs(turned) <= 1e-6 * (1.0 + std::abs(expected[k])))) {
          throw Error(CLEARANCE_STATUS_REJECTED, "the state space '" + space_->getName() +
                                                     "' does not interpolate along straight lines between joint positions, which alone "
                                                     "are proven");
        }
      }
    }
  }

  static constexpr int PROBES = 16;
  static constexpr double PROBE = 0.3;

  ::ompl::base::StateSpacePtr space_;
  std::vector<Value> values_;
};

namespace detail {

// Workspaces for the threads of a planner: one for each check that runs, since OMPL does not pass the thread.
class OmplWorkspaces {
 public:
  struct Entry {
    explicit Entry(const Checker &checker) : workspace(checker) {}
    Workspace workspace;
    std::vector<double> from, to;
  };

  // An entry that this thread has alone; returned at its end.
  class Lease {
   public:
    Lease(OmplWorkspaces &owner, std::unique_ptr<Entry> entry) : owner_(owner), entry_(std::move(entry)) {}
    Lease(const Lease &) = delete;
    Lease &operator=(const Lease &) = delete;
    ~Lease() {
      const std::lock_guard<std::mutex> lock(owner_.mutex_);
      owner_.idle_.push_back(std::move(entry_));
    }
    Entry *operator->() { return entry_.get(); }
    Entry &operator*() { return *entry_; }

   private:
    OmplWorkspaces &owner_;
    std::unique_ptr<Entry> entry_;
  };

  Lease lease(const Checker &checker) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<Entry> entry = std::move(idle_.back());
        idle_.pop_back();
        return Lease(*this, std::move(entry));
      }
      // room for the return of this entry, which must not fail
      idle_.reserve(++made_);
    }
    return Lease(*this, std::make_unique<Entry>(checker));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Entry>> idle_;
  std::size_t made_ = 0;
};

}  // namespace detail

// Validity of states: within the bounds of the space, and proven free.
class OmplStateValidityChecker : public ::ompl::base::StateValidityChecker {
 public:
  // Distances beyond max_clearance (m) count as max_clearance.
  OmplStateValidityChecker(const ::ompl::base::SpaceInformationPtr &si, const Checker &checker, double max_clearance = 0.5,
                           OmplSpaces spaces = OmplSpaces::known)
      : ::ompl::base::StateValidityChecker(si),
        checker_(checker),
        joints_(si->getStateSpace(), checker, spaces),
        max_clearance_(max_clearance) {
    specs_.clearanceComputationType = ::ompl::base::StateValidityCheckerSpecs::BOUNDED_APPROXIMATE;
  }

  using ::ompl::base::StateValidityChecker::clearance;
  using ::ompl::base::StateValidityChecker::isValid;

  bool isValid(const ::ompl::base::State *state) const override {
    if (!si_->satisfiesBounds(state)) {
      return false;
    }
    auto lease = workspaces_.lease(checker_);
    joints_.read(state, lease->from);
    return OmplJoints::is_finite(lease->from) && checker_.is_free(lease->from, lease->workspace);
  }

  // Least distance of two bodies (m, padding subtracted), not of states; minus the penetration depth in a collision.
  double clearance(const ::ompl::base::State *state) const override {
    auto lease = workspaces_.lease(checker_);
    joints_.read(state, lease->from);
    const Distances near = checker_.distance(lease->from, lease->workspace, max_clearance_);
    const double distance = std::min({near.self.distance, near.world.distance, max_clearance_});
    if (distance > 0.0) {
      return distance;
    }
    double deepest = 0.0;
    for (const PairClearance &pair : checker_.clearance(lease->from, lease->workspace, 0.0).pairs) {
      deepest = std::min(deepest, pair.distance);
    }
    return deepest;
  }

 private:
  Checker checker_;
  OmplJoints joints_;
  double max_clearance_;
  mutable detail::OmplWorkspaces workspaces_;
};

// Validity of motions: proven free at every point, and between states within the bounds of the space.
class OmplMotionValidator : public ::ompl::base::MotionValidator {
 public:
  OmplMotionValidator(const ::ompl::base::SpaceInformationPtr &si, const Checker &checker, const MotionOptions &options = {},
                      OmplSpaces spaces = OmplSpaces::known)
      : ::ompl::base::MotionValidator(si), checker_(checker), joints_(si->getStateSpace(), checker, spaces), options_(options) {
    options_.certificate = false;
  }

  bool checkMotion(const ::ompl::base::State *s1, const ::ompl::base::State *s2) const override {
    bool is_free = false;
    auto lease = workspaces_.lease(checker_);
    if (read(s1, s2, *lease)) {
      is_free = checker_.is_motion_free(lease->from, lease->to, lease->workspace, options_);
    }
    return counted(is_free);
  }

  // The last valid state is the end of the part from s1 on that is proven free; its fraction is 0 if s1 or s2 is out of the bounds.
  bool checkMotion(const ::ompl::base::State *s1, const ::ompl::base::State *s2,
                   std::pair<::ompl::base::State *, double> &last_valid) const override {
    double fraction = 0.0;
    auto lease = workspaces_.lease(checker_);
    if (read(s1, s2, *lease)) {
      const MotionReport report = checker_.check_motion(lease->from, lease->to, lease->workspace, options_);
      if (report.is_free()) {
        return counted(true);
      }
      fraction = report.t[0];
    }
    ::ompl::base::ScopedState<> last(si_->getStateSpace());
    last_valid.second = shrink_to_free(s1, s2, fraction, last.get(), *lease);
    if (last_valid.first != nullptr) {
      si_->copyState(last_valid.first, last.get());
    }
    return counted(false);
  }

 private:
  // Reads a motion; false if an end is out of the bounds, or not finite.
  bool read(const ::ompl::base::State *s1, const ::ompl::base::State *s2, detail::OmplWorkspaces::Entry &entry) const {
    if (!si_->satisfiesBounds(s1) || !si_->satisfiesBounds(s2)) {
      return false;
    }
    joints_.read_motion(s1, s2, entry.from, entry.to);
    return OmplJoints::is_finite(entry.from) && OmplJoints::is_finite(entry.to);
  }

  bool counted(bool is_free) const {
    const std::lock_guard<std::mutex> lock(count_mutex_);
    ++(is_free ? valid_ : invalid_);
    return is_free;
  }

  // The end of the proven part, as the space rounds it, is free, too: otherwise a little less of it.
  double shrink_to_free(const ::ompl::base::State *s1, const ::ompl::base::State *s2, double fraction,
                        ::ompl::base::State *last, detail::OmplWorkspaces::Entry &entry) const {
    for (double step = 1e-12; fraction > 0.0; step *= 10.0) {
      si_->getStateSpace()->interpolate(s1, s2, fraction, last);
      joints_.read(last, entry.from);
      if (checker_.is_free(entry.from, entry.workspace)) {
        return fraction;
      }
      fraction -= step;
    }
    si_->copyState(last, s1);
    return 0.0;
  }

  Checker checker_;
  OmplJoints joints_;
  MotionOptions options_;
  mutable detail::OmplWorkspaces workspaces_;
  mutable std::mutex count_mutex_;
};

// Uses a checker for states and motions. Call it before the setup of the planner.
inline void use_in_ompl(const ::ompl::base::SpaceInformationPtr &si, const Checker &checker, const MotionOptions &options = {},
                        OmplSpaces spaces = OmplSpaces::known) {
  const double max_clearance = 0.5;
  si->setStateValidityChecker(std::make_shared<OmplStateValidityChecker>(si, checker, max_clearance, spaces));
  si->setMotionValidator(std::make_shared<OmplMotionValidator>(si, checker, options, spaces));
}

// A state space of the joints of a checker, with their limits: SO2StateSpaces for continuous joints, real values for the others.
//
// Throws Error for joints that are neither continuous nor limited on both sides, and for floating joints.
inline ::ompl::base::StateSpacePtr ompl_state_space(const Checker &checker) {
  const std::vector<std::string> names = checker.joint_names();
  detail::reject_floating(names);
  const auto [lower, upper] = checker.limits();
  const auto compound = std::make_shared<::ompl::base::CompoundStateSpace>();
  const auto real = std::make_shared<::ompl::base::RealVectorStateSpace>();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (checker.is_continuous(i)) {
      const auto circle = std::make_shared<::ompl::base::SO2StateSpace>();
      circle->setName(names[i]);
      compound->addSubspace(circle, 1.0);
      continue;
    }
    if (!std::isfinite(lower[i]) || !std::isfinite(upper[i])) {
      throw Error(CLEARANCE_STATUS_REJECTED, "joint '" + names[i] + "' has no limits: make a state space with bounds for it");
    }
    real->addDimension(names[i], lower[i], upper[i]);
  }
  if (compound->getSubspaceCount() == 0) {
    return real;
  }
  if (real->getDimension() > 0) {
    compound->addSubspace(real, 1.0);
  }
  compound->lock();
  return compound;
}

// The motion along a path, without times: for certify, and for the expectation of a verification.
//
// Throws Error for states out of the bounds of the space, and for paths of CForest: append their states to a path of your own
// SpaceInformation.
inline Trajectory trajectory_of(const ::ompl::geometric::PathGeometric &path, const Checker &checker,
                                OmplSpaces spaces = OmplSpaces::known) {
  const OmplJoints joints(path.getSpaceInformation()->getStateSpace(), checker, spaces);
  std::vector<const ::ompl::base::State *> states;
  for (std::size_t i = 0; i < path.getStateCount(); ++i) {
    states.push_back(path.getState(static_cast<unsigned int>(i)));
  }
  Trajectory trajectory;
  trajectory.n = checker.size();
  joints.read_path(states, trajectory.positions);
  return trajectory;
}

// Proves a path free: a report, with the certificate if it is free. Paths have at least two states.
inline MotionReport certify(const ::ompl::geometric::PathGeometric &path, const Checker &checker, Workspace &workspace,
                            MotionOptions options = {}, OmplSpaces spaces = OmplSpaces::known) {
  options.certificate = true;
  return checker.check_trajectory(trajectory_of(path, checker, spaces), workspace, options);
}

}  // namespace clearance

#endif  // CLEARANCE_OMPL_HPP
