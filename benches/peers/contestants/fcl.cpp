// FCL with its managers, as planning scenes drive it: each link is asked of a dynamic tree of boxes around all obstacles, and
// what the tree hands over goes to FCL's own query. Only robots among obstacles are asked of it; README.md, "Worlds".
#include <fcl/fcl.h>
#include <fcl/geometry/octree/octree.h>
#include <octomap/OcTree.h>

#include <cstdio>
#include <limits>
#include <memory>

#include "neutral.hpp"
#include "protocol.hpp"

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;
using Object = fcl::CollisionObjectd;
using Tree = fcl::DynamicAABBTreeCollisionManagerd;

static Geometry mesh(const neutral::Link& link) {
  auto bvh = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  std::vector<fcl::Vector3d> points(link.vertices.begin(), link.vertices.end());
  std::vector<fcl::Triangle> triangles;
  for (const auto& t : link.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  bvh->beginModel(static_cast<int>(triangles.size()), static_cast<int>(points.size()));
  bvh->addSubModel(points, triangles);
  bvh->endModel();
  return bvh;
}

static Geometry primitive(const neutral::Primitive& p) {
  const auto& s = p.sizes;
  if (p.shape == "box") return std::make_shared<fcl::Boxd>(s.at(0), s.at(1), s.at(2));
  if (p.shape == "sphere") return std::make_shared<fcl::Sphered>(s.at(0));
  if (p.shape == "cylinder") return std::make_shared<fcl::Cylinderd>(s.at(0), s.at(1));
  if (p.shape == "capsule") return std::make_shared<fcl::Capsuled>(s.at(0), s.at(1));
  throw std::runtime_error("no shape " + p.shape);
}

static fcl::Transform3d transform(const neutral::Pose& pose) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() = pose.turn;
  out.translation() = pose.shift;
  return out;
}

// A geometry that moves with a link, as an object of FCL.
struct Part {
  size_t link;
  neutral::Pose pose;  // in the link
  std::unique_ptr<Object> object;
};

// All meshes of a link as one, then its primitives.
static std::vector<Part> parts(const neutral::Robot& robot) {
  std::vector<Part> out;
  const auto add = [&](size_t link, const neutral::Pose& pose, const Geometry& geometry) {
    geometry->computeLocalAABB();
    out.push_back({link, pose, std::make_unique<Object>(geometry, transform(pose))});
  };
  for (size_t i = 0; i < robot.links.size(); ++i)
    if (!robot.links[i].triangles.empty()) add(i, {}, mesh(robot.links[i]));
  for (const auto& p : robot.primitives) add(p.link, p.pose, primitive(p));
  return out;
}

// Obstacles that stay where they are.
class World {
 public:
  explicit World(const neutral::Robot& world) : parts_(parts(world)) {
    for (const auto& cloud : world.clouds) add(cloud);
    std::vector<Object*> objects;
    for (const auto& part : parts_) objects.push_back(part.object.get());
    tree_.registerObjects(objects);
    tree_.setup();
  }

  Tree& tree() { return tree_; }
  Tree* octree() { return has_octree_ ? &octree_ : nullptr; }

 private:
  std::vector<Part> parts_;
  Tree tree_, octree_;
  std::unique_ptr<Object> cubes_;
  bool has_octree_ = false;

  // A ball for every point, and cubes of 2 cm for all of them.
  void add(const neutral::Cloud& cloud) {
    const auto ball = std::make_shared<fcl::Sphered>(cloud.radius);
    ball->computeLocalAABB();
    const auto cubes = std::make_shared<octomap::OcTree>(0.02);
    for (const auto& p : cloud.points) {
      const neutral::Pose pose{Eigen::Matrix3d::Identity(), p};
      parts_.push_back({0, pose, std::make_unique<Object>(ball, transform(pose))});
      cubes->updateNode(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())),
                        true, true);
    }
    cubes->updateInnerOccupancy();
    cubes_ = std::make_unique<Object>(
        std::make_shared<fcl::OcTree<double>>(std::shared_ptr<const octomap::OcTree>(cubes)));
    octree_.registerObject(cubes_.get());
    octree_.setup();
    has_octree_ = true;
  }
};

class Contestant {
 public:
  explicit Contestant(const std::string& file)
      : robot_(neutral::Reader(file).robot), poses_(robot_.links.size()), parts_(parts(robot_)) {}

  bool take(const std::string& kind, const std::string& file) {
    if (kind != "world") return false;
    world_ = std::make_unique<World>(neutral::Reader(file).robot);
    return true;
  }

  // As of the contestant of Coal; all that is asked about robots alone is unsupported.
  template <class Hear>
  bool ask(const std::string& question, const std::string& set, Hear hear) {
    if (!world_) return false;
    const size_t colon = set.find(':');
    const auto& states = robot_.states.at(set.substr(0, colon));
    const size_t count = colon == std::string::npos ? states.size() : std::stoul(set.substr(colon + 1));
    const auto each = [&](auto answer) {
      for (size_t i = 0; i < std::min(count, states.size()); ++i) {
        place(states[i]);
        hear(answer());
      }
      return true;
    };
    if (question == "free-world-tree") return each([&] { return !hit(world_->tree()); });
    if (question == "distance-world-tree") return each([&] { return distance(world_->tree()); });
    if (question == "free-world-octree") return world_->octree() && each([&] { return !hit(*world_->octree()); });
    return false;
  }

  std::string say(bool free) const { return free ? "1" : "0"; }
  std::string say(double distance) const {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", distance);
    return text;
  }

 private:
  neutral::Robot robot_;
  std::vector<neutral::Pose> poses_;  // of links
  std::vector<Part> parts_;
  std::unique_ptr<World> world_;

  void place(const neutral::State& q) {
    robot_.place(q, poses_);
    for (auto& part : parts_) {
      part.object->setTransform(transform(poses_[part.link] * part.pose));
      part.object->computeAABB();
    }
  }

  bool hit(Tree& tree) {
    bool hit = false;
    for (size_t i = 0; i < parts_.size() && !hit; ++i)
      tree.collide(parts_[i].object.get(), &hit, [](Object* a, Object* b, void* hit) {
        static const fcl::CollisionRequestd request(1, false);  // one contact, which nobody reads
        fcl::CollisionResultd result;
        return *static_cast<bool*>(hit) = fcl::collide(a, b, request, result) > 0;
      });
    return hit;
  }

  // Links in their order, each up to the least so far.
  double distance(Tree& tree) {
    double least = std::numeric_limits<double>::max();
    for (size_t i = 0; i < parts_.size() && least > 0; ++i)
      tree.distance(parts_[i].object.get(), &least, [](Object* a, Object* b, void* data, double& bound) {
        static const fcl::DistanceRequestd request(false);  // no nearest points
        auto& least = *static_cast<double*>(data);
        fcl::DistanceResultd result;
        result.min_distance = least;
        bound = least = std::min(least, std::max(0.0, fcl::distance(a, b, request, result)));
        return least <= 0;
      });
    return least;
  }
};

int main() { return protocol::serve<Contestant>(); }
