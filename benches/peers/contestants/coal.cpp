// Coal as a careful C++ programmer would drive it; what that means is in README.md, "Fairness".
#include <coal/collision.h>
#include <coal/distance.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>

#include "edges.hpp"
#include "neutral.hpp"
#include "protocol.hpp"
#include "solids.hpp"
#include "surroundings.hpp"

using neutral::Pose;
using neutral::Solid;

// The least distance that the question "near" looks for (m).
static constexpr double kNear = 0.1;

// Two geometries of two links, with Coal's functions looked up once.
struct Check {
  size_t a, b;  // solids
  size_t pair;  // of links
  coal::ComputeCollision collide;
  coal::ComputeDistance distance;
};

class Contestant {
 public:
  explicit Contestant(const std::string& file) : robot_(neutral::Reader(file).robot), poses_(robot_.links.size()) {
    solids_ = neutral::solids(robot_);
    std::vector<std::vector<size_t>> of_link(robot_.links.size());
    for (size_t i = 0; i < solids_.size(); ++i) of_link[solids_[i].link].push_back(i);
    for (size_t pair = 0; pair < robot_.pairs.size(); ++pair)
      for (size_t a : of_link[robot_.pairs[pair].first])
        for (size_t b : of_link[robot_.pairs[pair].second])
          checks_.push_back({a, b, pair, {solids_[a].geometry.get(), solids_[b].geometry.get()},
                             {solids_[a].geometry.get(), solids_[b].geometry.get()}});
    places_.resize(solids_.size());
    centres_.resize(solids_.size());
    collision_request_.break_distance = 0;
    distance_request_.enable_signed_distance = false;
    for (const auto& link : robot_.links) given_ |= link.kind == neutral::Link::Placed;
    if (given_) place_once();
  }

  // Asks `question` about every state of `set`, which is a name or, for its first few states, `name:count`.
  // False where there is no such question.
  template <class Hear>
  bool ask(const std::string& question, const std::string& set, Hear hear) {
    const size_t colon = set.find(':');
    const auto first_few = [&](size_t all) {
      return colon == std::string::npos ? all : std::min<size_t>(all, std::stoul(set.substr(colon + 1)));
    };
    if (question.rfind("edge-", 0) == 0) {
      const auto& edges = edges_.at(set.substr(0, colon));
      const bool any = question.rfind("edge-any-", 0) == 0;
      const double step = neutral::number(question.substr(question.rfind('-') + 1));
      if (question.rfind("edge-least-", 0) == 0) {
        for (size_t i = 0; i < first_few(edges.size()); ++i) hear(least_along(edges[i], step));
        return true;
      }
      for (size_t i = 0; i < first_few(edges.size()); ++i) hear(edge_free(edges[i], step, any));
      return true;
    }
    const auto& states = robot_.states.at(set.substr(0, colon));
    const size_t count = first_few(states.size());
    const coal::Transform3s* given = given_ ? transforms_.at(set).data() : nullptr;
    const auto each = [&](auto answer) {
      for (size_t i = 0; i < count; ++i) {
        given ? put(given[i]) : place(states[i]);
        hear(answer());
      }
      return true;
    };
    if (question == "free") return each([&] { return free(); });
    if (question == "free-bare") return each([&] { return free_bare(); });
    if (question == "pairs") return each([&]() -> const std::vector<size_t>& { return hits(); });
    if (question == "distance") return each([&] { return distance(std::numeric_limits<double>::max()); });
    if (question == "near") return each([&] { return distance(kNear); });
    if (!surroundings_) return false;
    auto& around = *surroundings_;
    if (question == "free-world-tree") return each([&] { return !around.tree_hit(places_, centres_); });
    if (question == "distance-world-tree") return each([&] { return around.tree_distance(places_, centres_); });
    if (question == "free-world-octree") return around.has_octree() && each([&] { return !around.octree_hit(places_, centres_); });
    if (!around.is_short()) return false;
    if (question == "free-world-list") return each([&] { return !around.list_hit(places_, centres_); });
    if (question == "distance-world-list") return each([&] { return around.list_distance(places_, centres_); });
    return false;
  }

  // Takes what stands in a file in place of what it had; false where it takes nothing of the kind.
  bool take(const std::string& kind, const std::string& file) {
    if (kind == "edges") edges_ = neutral::edges(file);
    else if (kind == "world") surroundings_ = std::make_unique<Surroundings>(solids_, neutral::Reader(file).robot);
    else return false;
    return true;
  }

  std::string say(bool free) const { return free ? "1" : "0"; }
  std::string say(double distance) const {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", distance);
    return distance < 0 ? "far" : text;
  }
  std::string say(const std::vector<size_t>& hits) const {
    std::string out;
    for (size_t pair : hits) {
      const auto& [a, b] = robot_.pairs[pair];
      out += (out.empty() ? "" : ",") + robot_.links[a].id + "-" + robot_.links[b].id;
    }
    return out;
  }

 private:
  neutral::Robot robot_;
  std::vector<Pose> poses_;  // of links
  std::vector<Solid> solids_;
  std::vector<Check> checks_;
  std::vector<coal::Transform3s> places_;  // of solids
  std::vector<Eigen::Vector3d> centres_;   // of their spheres
  std::vector<std::pair<double, size_t>> order_;
  std::vector<size_t> hits_;
  bool given_ = false;  // states are poses, given as Coal wants them: no kinematics to compute
  std::map<std::string, std::vector<coal::Transform3s>> transforms_;
  neutral::Edges edges_;
  std::map<std::pair<size_t, bool>, std::vector<size_t>> orders_;  // of samples, by their number
  neutral::State sample_;
  std::unique_ptr<Surroundings> surroundings_;
  coal::CollisionRequest collision_request_{coal::NO_REQUEST, 1};  // no contacts, one is enough
  coal::CollisionResult collision_;
  coal::DistanceRequest distance_request_{false};  // no nearest points
  coal::DistanceResult distance_;

  void place_once() {
    for (const auto& [set, states] : robot_.states)
      for (const auto& s : states) {
        coal::Matrix3s turn;
        turn << s[0], s[1], s[2], s[4], s[5], s[6], s[8], s[9], s[10];
        transforms_[set].emplace_back(turn, coal::Vec3s(s[3], s[7], s[11]));
      }
    centres_[0] = solids_[0].centre;
  }

  void put(const coal::Transform3s& given) {
    places_[1] = given;
    centres_[1] = given.transform(solids_[1].centre);
  }

  void place(const neutral::State& q) {
    robot_.place(q, poses_);
    for (size_t i = 0; i < solids_.size(); ++i) {
      const Solid& s = solids_[i];
      const Pose pose = s.in_link_frame ? poses_[s.link] : poses_[s.link] * s.pose;
      places_[i] = coal::Transform3s(pose.turn, pose.shift);
      centres_[i] = pose.turn * s.centre + pose.shift;
    }
  }

  // Never more than the distance of the two solids of a check.
  double lower_bound(const Check& c) const {
    return (centres_[c.a] - centres_[c.b]).norm() - solids_[c.a].radius - solids_[c.b].radius;
  }

  bool spheres_apart(const Check& c) const {
    const double reach = solids_[c.a].radius + solids_[c.b].radius;
    return (centres_[c.a] - centres_[c.b]).squaredNorm() > reach * reach;
  }

  bool collide(Check& c) {
    collision_.clear();
    return c.collide(places_[c.a], places_[c.b], collision_request_, collision_) > 0;
  }

  bool touches(Check& c) { return !spheres_apart(c) && collide(c); }

  bool free() {
    for (Check& c : checks_)
      if (touches(c)) return false;
    return true;
  }

  // Whether all samples along an edge are free, none farther than `step` from the next; stops at the first hit.
  bool edge_free(const neutral::Edge& edge, double step, bool any) {
    const size_t steps = edge.steps(step);
    auto& order = orders_[{steps, any}];
    if (order.empty()) order = any ? neutral::van_der_corput(steps) : neutral::in_turn(steps);
    for (size_t i : order) {
      edge.at(static_cast<double>(i) / static_cast<double>(steps), sample_);
      place(sample_);
      if (!free()) return false;
    }
    return true;
  }

  // The least distance at samples along an edge, none farther than `step` from the next: each up to the least so far.
  double least_along(const neutral::Edge& edge, double step) {
    const size_t steps = edge.steps(step);
    double least = std::numeric_limits<double>::max();
    for (size_t i = 0; i <= steps && least > 0; ++i) {
      edge.at(static_cast<double>(i) / static_cast<double>(steps), sample_);
      place(sample_);
      const double found = distance(least);
      if (found >= 0) least = found;
    }
    return least;
  }

  // Coal's own query of every pair, without the sphere test before it.
  bool free_bare() {
    for (Check& c : checks_)
      if (collide(c)) return false;
    return true;
  }

  const std::vector<size_t>& hits() {
    hits_.clear();
    for (Check& c : checks_)
      if ((hits_.empty() || hits_.back() != c.pair) && touches(c)) hits_.push_back(c.pair);
    return hits_;
  }

  // The least distance if it is below `limit`, else -1: pairs that may be nearest first, each up to the least so far.
  double distance(double limit) {
    order_.clear();
    for (size_t i = 0; i < checks_.size(); ++i) {
      const double lower = lower_bound(checks_[i]);
      if (lower < limit) order_.emplace_back(lower, i);
    }
    std::sort(order_.begin(), order_.end());
    double least = limit;
    for (const auto& [lower, i] : order_) {
      if (lower >= least || least <= 0) break;
      Check& c = checks_[i];
      distance_.clear();
      distance_.min_distance = least;
      least = std::min(least, std::max(0.0, c.distance(places_[c.a], places_[c.b], distance_request_, distance_)));
    }
    return least < limit ? least : -1;
  }
};

int main() { return protocol::serve<Contestant>(); }
