// A robot's solids among obstacles that stay where they are, asked with Coal's tree of boxes, pair by pair, or with its
// octree in place of points; what careful means is in README.md, "Worlds".
#pragma once
#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/collision.h>
#include <coal/distance.h>
#include <coal/octree.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "solids.hpp"

class Surroundings {
 public:
  using Places = std::vector<coal::Transform3s>;     // of the robot's solids
  using Centres = std::vector<Eigen::Vector3d>;      // of the spheres around them

  Surroundings(const std::vector<neutral::Solid>& robot, const neutral::Robot& world) : robot_(robot) {
    for (const auto& solid : neutral::solids(world)) {
      const neutral::Pose& pose = solid.pose;
      add(solid.geometry, coal::Transform3s(pose.turn, pose.shift));
    }
    for (const auto& cloud : world.clouds) add(cloud);
    for (auto& object : objects_) tree_.registerObject(object.get());
    tree_.setup();
    for (const auto& solid : robot_) moving_.push_back(std::make_unique<coal::CollisionObject>(solid.geometry, false));
    collide_.resize(robot_.size() * objects_.size());
    distance_.resize(robot_.size() * objects_.size());
    collision_request_.break_distance = 0;
    distance_request_.enable_signed_distance = false;
  }

  // More obstacles than these are nothing for a plain list.
  bool is_short() const { return objects_.size() <= 10000; }
  bool has_octree() const { return octree_ != nullptr; }

  // The tree hands over what its boxes cannot keep apart; a sphere test stands before each query.
  bool tree_hit(const Places& places, const Centres& centres) {
    Hits hits(*this, places, centres);
    for (size_t i = 0; i < moving_.size() && !hits.hit; ++i) {
      put(i, places[i]);
      hits.solid = i;
      tree_.collide(moving_[i].get(), &hits);
    }
    return hits.hit;
  }

  bool list_hit(const Places& places, const Centres& centres) {
    for (size_t i = 0; i < robot_.size(); ++i)
      for (size_t j = 0; j < objects_.size(); ++j)
        if (touches(i, j, places, centres)) return true;
    return false;
  }

  // Solids are asked in the order of the least distance that they can have.
  double tree_distance(const Places& places, const Centres& centres) {
    const coal::AABB all = tree_bounds_;
    order_.clear();
    for (size_t i = 0; i < robot_.size(); ++i) order_.push_back({outside(all, centres[i]) - robot_[i].radius, i, 0});
    std::sort(order_.begin(), order_.end());
    Least least(*this, places);
    for (const auto& [lower, i, none] : order_) {
      if (lower >= least.least || least.least <= 0) break;
      put(i, places[i]);
      least.solid = i;
      tree_.distance(moving_[i].get(), &least);
    }
    return least.least;
  }

  // Pairs that may be nearest first, each up to the least so far.
  double list_distance(const Places& places, const Centres& centres) {
    order_.clear();
    for (size_t i = 0; i < robot_.size(); ++i)
      for (size_t j = 0; j < objects_.size(); ++j) {
        const double spheres = (centres[i] - spheres_[j].first).norm() - spheres_[j].second;
        order_.push_back({std::max(spheres, outside(objects_[j]->getAABB(), centres[i])) - robot_[i].radius, i, j});
      }
    std::sort(order_.begin(), order_.end());
    double least = std::numeric_limits<double>::max();
    for (const auto& [lower, i, j] : order_) {
      if (lower >= least || least <= 0) break;
      least = std::min(least, distance(i, j, places, least));
    }
    return least;
  }

  bool octree_hit(const Places& places, const Centres& centres) {
    for (size_t i = 0; i < robot_.size(); ++i) {
      if (outside(octree_->aabb_local, centres[i]) > robot_[i].radius) continue;
      collision_.clear();
      if (octree_checks_[i](places[i], coal::Transform3s(), collision_request_, collision_) > 0) return true;
    }
    return false;
  }

 private:
  struct Hits : coal::CollisionCallBackBase {
    Hits(Surroundings& all, const Places& places, const Centres& centres) : all(all), places(places), centres(centres) {}
    Surroundings& all;
    const Places& places;
    const Centres& centres;
    size_t solid = 0;
    bool hit = false;
    bool collide(coal::CollisionObject* a, coal::CollisionObject* b) override {
      hit = all.touches(solid, all.other(a, b), places, centres);
      return hit;
    }
  };

  struct Least : coal::DistanceCallBackBase {
    Least(Surroundings& all, const Places& places) : all(all), places(places) {}
    Surroundings& all;
    const Places& places;
    size_t solid = 0;
    double least = std::numeric_limits<double>::max();
    bool distance(coal::CollisionObject* a, coal::CollisionObject* b, coal::CoalScalar& bound) override {
      least = std::min(least, all.distance(solid, all.other(a, b), places, least));
      bound = least;
      return least <= 0;
    }
  };

  struct Candidate {
    double lower;
    size_t solid, object;
    bool operator<(const Candidate& other) const { return lower < other.lower; }
  };

  const std::vector<neutral::Solid>& robot_;
  std::vector<std::unique_ptr<coal::CollisionObject>> objects_;        // the obstacles
  std::vector<std::pair<Eigen::Vector3d, double>> spheres_;            // around them
  std::vector<std::unique_ptr<coal::CollisionObject>> moving_;         // the robot's solids
  coal::DynamicAABBTreeCollisionManager tree_;
  coal::AABB tree_bounds_;
  std::shared_ptr<coal::OcTree> octree_;
  std::vector<coal::ComputeCollision> octree_checks_;  // by solid
  std::vector<std::unique_ptr<coal::ComputeCollision>> collide_;  // by solid and object, once they met
  std::vector<std::unique_ptr<coal::ComputeDistance>> distance_;
  std::vector<Candidate> order_;
  coal::CollisionRequest collision_request_{coal::NO_REQUEST, 1};  // no contacts, one is enough
  coal::CollisionResult collision_;
  coal::DistanceRequest distance_request_{false};  // no nearest points
  coal::DistanceResult distance_result_;

  void add(const std::shared_ptr<coal::CollisionGeometry>& geometry, const coal::Transform3s& place) {
    objects_.push_back(std::make_unique<coal::CollisionObject>(geometry, place, false));
    auto& object = *objects_.back();
    object.computeAABB();
    object.setUserData(reinterpret_cast<void*>(objects_.size()));  // none of the robot's solids has any
    spheres_.emplace_back(place.transform(geometry->aabb_center), geometry->aabb_radius);
    tree_bounds_ = objects_.size() == 1 ? object.getAABB() : tree_bounds_ + object.getAABB();
  }

  // A ball for every point, and cubes of 2 cm for all of them.
  void add(const neutral::Cloud& cloud) {
    const auto ball = std::make_shared<coal::Sphere>(cloud.radius);
    ball->computeLocalAABB();
    coal::MatrixX3s points(cloud.points.size(), 3);
    for (size_t i = 0; i < cloud.points.size(); ++i) {
      add(ball, coal::Transform3s(coal::Matrix3s::Identity(), cloud.points[i]));
      points.row(i) = cloud.points[i].transpose();
    }
    octree_ = coal::makeOctree(points, 0.02);
    octree_->computeLocalAABB();
    for (const auto& solid : robot_) octree_checks_.emplace_back(solid.geometry.get(), octree_.get());
  }

  void put(size_t solid, const coal::Transform3s& place) {
    moving_[solid]->setTransform(place);
    moving_[solid]->computeAABB();
  }

  size_t other(const coal::CollisionObject* a, const coal::CollisionObject* b) const {
    const void* number = a->getUserData() ? a->getUserData() : b->getUserData();
    return reinterpret_cast<size_t>(number) - 1;
  }

  bool touches(size_t i, size_t j, const Places& places, const Centres& centres) {
    const double reach = robot_[i].radius + spheres_[j].second;
    if ((centres[i] - spheres_[j].first).squaredNorm() > reach * reach) return false;
    auto& check = collide_[i * objects_.size() + j];
    if (!check)
      check = std::make_unique<coal::ComputeCollision>(robot_[i].geometry.get(), objects_[j]->collisionGeometryPtr());
    collision_.clear();
    return (*check)(places[i], objects_[j]->getTransform(), collision_request_, collision_) > 0;
  }

  double distance(size_t i, size_t j, const Places& places, double limit) {
    auto& check = distance_[i * objects_.size() + j];
    if (!check)
      check = std::make_unique<coal::ComputeDistance>(robot_[i].geometry.get(), objects_[j]->collisionGeometryPtr());
    distance_result_.clear();
    distance_result_.min_distance = limit;
    return std::max(0.0, (*check)(places[i], objects_[j]->getTransform(), distance_request_, distance_result_));
  }

  // How far a point is from a box.
  static double outside(const coal::AABB& box, const Eigen::Vector3d& p) {
    return (box.min_ - p).cwiseMax(p - box.max_).cwiseMax(0.0).norm();
  }
};
