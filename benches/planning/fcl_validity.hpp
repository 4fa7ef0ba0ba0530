// Validity of states by FCL, as MoveIt uses it: a BVHModel<OBBRSS> for each mesh, a DynamicAABBTreeCollisionManager for the robot and
// one for the world, and allowed pairs in the callback. The world is checked first, link by link, and the first contact ends a check.
//
// In favour of FCL: MoveIt makes the manager of the robot anew for each check and looks allowed pairs up by name; here, the manager is
// updated, and pairs are in a matrix.
#pragma once

#include <fcl/fcl.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>

#include <memory>
#include <vector>

#include "problem.hpp"

class FclValidity : public ompl::base::StateValidityChecker {
 public:
  FclValidity(const ompl::base::SpaceInformationPtr &si, const Problem &problem)
      : ompl::base::StateValidityChecker(si), problem_(problem), poses_(problem.joints.size()) {
    const std::size_t count = problem.links.size() + problem.obstacles.size();
    is_checked_.assign(count, std::vector<char>(count, 0));
    for (const auto &[a, b] : problem.pairs) {
      is_checked_[a][b] = is_checked_[b][a] = 1;
    }
    add(problem.links, 0, links_, robot_);
    add(problem.obstacles, problem.links.size(), obstacles_, world_);
  }

  bool isValid(const ompl::base::State *state) const override {
    return is_free(state->as<ompl::base::RealVectorStateSpace::StateType>()->values);
  }

  bool is_free(const double *q) const {
    move(q);
    Check check{*this};
    for (std::size_t i = 0; i < links_.size() && !check.collides; ++i) {
      world_.collide(links_[i].get(), &check, &FclValidity::callback);
    }
    if (!check.collides) {
      robot_.collide(&check, &FclValidity::callback);
    }
    return !check.collides;
  }

 private:
  using Object = fcl::CollisionObjectd;
  using Manager = fcl::DynamicAABBTreeCollisionManagerd;

  struct Check {
    const FclValidity &owner;
    bool collides = false;
  };

  static bool callback(Object *a, Object *b, void *data) {
    auto &check = *static_cast<Check *>(data);
    const auto index = [](const Object *object) { return reinterpret_cast<std::uintptr_t>(object->getUserData()); };
    if (check.owner.is_checked_[index(a)][index(b)]) {
      fcl::CollisionResultd result;
      check.collides = fcl::collide(a, b, fcl::CollisionRequestd(), result) > 0;
    }
    return check.collides;
  }

  static std::shared_ptr<fcl::CollisionGeometryd> geometry(const Body &body) {
    if (body.shape == "box") {
      return std::make_shared<fcl::Boxd>(body.sizes[0], body.sizes[1], body.sizes[2]);
    }
    if (body.shape == "cylinder") {
      return std::make_shared<fcl::Cylinderd>(body.sizes[0], body.sizes[1]);
    }
    auto made = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    std::vector<fcl::Triangle> triangles;
    for (const auto &triangle : body.mesh.triangles) {
      triangles.emplace_back(triangle[0], triangle[1], triangle[2]);
    }
    made->beginModel(static_cast<int>(triangles.size()), static_cast<int>(body.mesh.vertices.size()));
    made->addSubModel(body.mesh.vertices, triangles);
    made->endModel();
    return made;
  }

  static void add(const std::vector<Body> &bodies, std::size_t first, std::vector<std::unique_ptr<Object>> &objects, Manager &manager) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      objects.push_back(std::make_unique<Object>(geometry(bodies[i]), bodies[i].pose));
      objects.back()->setUserData(reinterpret_cast<void *>(first + i));
      objects.back()->computeAABB();
      manager.registerObject(objects.back().get());
    }
    manager.setup();
  }

  void move(const double *q) const {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const Joint &joint = problem_.joints[i];
      const double position = joint.column < 0 ? joint.fixed : q[joint.column];
      Eigen::Isometry3d pose = joint.parent < 0 ? joint.pose : poses_[joint.parent] * joint.pose;
      if (joint.is_prismatic) {
        pose.translate(position * joint.axis);
      } else {
        pose.rotate(Eigen::AngleAxisd(position, joint.axis));
      }
      poses_[i] = pose;
    }
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const Body &link = problem_.links[i];
      links_[i]->setTransform(link.joint < 0 ? link.pose : poses_[link.joint] * link.pose);
      links_[i]->computeAABB();
    }
    robot_.update();
  }

  const Problem &problem_;
  std::vector<std::vector<char>> is_checked_;
  std::vector<std::unique_ptr<Object>> links_, obstacles_;
  mutable std::vector<Eigen::Isometry3d, Eigen::aligned_allocator<Eigen::Isometry3d>> poses_;
  mutable Manager robot_, world_;
};
