// Collision geometries of Coal for what the neutral form describes.
#pragma once
#include <coal/BVH/BVH_model.h>
#include <coal/shape/geometric_shapes.h>

#include <functional>
#include <memory>

#include "neutral.hpp"

namespace neutral {

// One collision geometry: all meshes of a link, or one primitive.
struct Solid {
  size_t link;
  bool in_link_frame;
  Pose pose;  // in the link
  std::shared_ptr<coal::CollisionGeometry> geometry;
  Eigen::Vector3d centre;  // of a sphere around it, in its frame
  double radius;
};

inline std::shared_ptr<coal::CollisionGeometry> mesh(const Link& link) {
  auto bvh = std::make_shared<coal::BVHModel<coal::OBBRSS>>();
  std::vector<coal::Vec3s> points(link.vertices.begin(), link.vertices.end());
  std::vector<coal::Triangle> triangles;
  for (const auto& t : link.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  bvh->beginModel(static_cast<unsigned>(triangles.size()), static_cast<unsigned>(points.size()));
  bvh->addSubModel(points, triangles);
  bvh->endModel();
  return bvh;
}

inline std::shared_ptr<coal::CollisionGeometry> primitive(const Primitive& p) {
  const auto& s = p.sizes;
  if (p.shape == "box") return std::make_shared<coal::Box>(s.at(0), s.at(1), s.at(2));
  if (p.shape == "sphere") return std::make_shared<coal::Sphere>(s.at(0));
  if (p.shape == "cylinder") return std::make_shared<coal::Cylinder>(s.at(0), s.at(1));
  if (p.shape == "capsule") return std::make_shared<coal::Capsule>(s.at(0), s.at(1));
  throw std::runtime_error("no shape " + p.shape);
}

// All meshes of a link as one, then its primitives.
inline std::vector<Solid> solids(const Robot& robot) {
  std::vector<Solid> out;
  const auto add = [&](size_t link, bool plain, const Pose& pose, std::shared_ptr<coal::CollisionGeometry> g) {
    g->computeLocalAABB();
    out.push_back({link, plain, pose, g, g->aabb_center, g->aabb_radius});
  };
  for (size_t i = 0; i < robot.links.size(); ++i)
    if (!robot.links[i].triangles.empty()) add(i, true, Pose{}, mesh(robot.links[i]));
  for (const auto& p : robot.primitives) add(p.link, false, p.pose, primitive(p));
  return out;
}

}  // namespace neutral
