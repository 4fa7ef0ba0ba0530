// A planning problem as benches/planning/problem_file.py writes it: words and numbers, separated by white space.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

// A joint that moves, in the order of the kinematic tree.
struct Joint {
  int parent;  // -1: the root
  bool is_prismatic;
  Eigen::Vector3d axis;
  Eigen::Isometry3d pose;  // in the parent, at position 0
  int column;              // of the states; -1: fixed
  double fixed;            // rad, m
};

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

// A link or an obstacle with one shape.
struct Body {
  std::string name;
  int joint;  // -1: does not move
  Eigen::Isometry3d pose;
  std::string shape;           // box, cylinder, mesh
  std::vector<double> sizes;   // box: edges; cylinder: radius, length
  Mesh mesh;
};

struct Problem {
  std::string urdf, srdf, packages, group;
  std::vector<std::pair<std::string, double>> fixed;
  std::vector<std::pair<std::string, std::string>> allowed;
  std::vector<double> start, goal;
  std::vector<Joint> joints;
  std::vector<Body> links, obstacles;
  std::vector<std::pair<int, int>> pairs;  // that are checked; indices of links, then of obstacles
};

namespace problem_file {

template <typename Value>
Value next(std::istream &in) {
  Value value{};
  if (!(in >> value)) {
    throw std::runtime_error("the file of the problem ends too early");
  }
  return value;
}

inline std::vector<double> numbers(std::istream &in, std::size_t count) {
  std::vector<double> values(count);
  for (double &value : values) {
    value = next<double>(in);
  }
  return values;
}

inline Eigen::Isometry3d pose(std::istream &in) {
  Eigen::Isometry3d made = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      made.matrix()(row, column) = next<double>(in);
    }
  }
  return made;
}

inline Joint joint(std::istream &in) {
  Joint made{};
  made.parent = next<int>(in);
  made.is_prismatic = next<int>(in) != 0;
  for (int i = 0; i < 3; ++i) {
    made.axis[i] = next<double>(in);
  }
  made.pose = pose(in);
  made.column = next<int>(in);
  made.fixed = next<double>(in);
  return made;
}

inline Body body(std::istream &in) {
  Body made;
  made.name = next<std::string>(in);
  made.joint = next<int>(in);
  made.pose = pose(in);
  made.shape = next<std::string>(in);
  if (made.shape != "mesh") {
    made.sizes = numbers(in, made.shape == "box" ? 3 : 2);
    return made;
  }
  made.mesh.vertices.resize(next<std::size_t>(in));
  made.mesh.triangles.resize(next<std::size_t>(in));
  for (auto &vertex : made.mesh.vertices) {
    for (int i = 0; i < 3; ++i) {
      vertex[i] = next<double>(in);
    }
  }
  for (auto &triangle : made.mesh.triangles) {
    for (int &index : triangle) {
      index = next<int>(in);
    }
  }
  return made;
}

inline Problem read(const std::string &path) {
  std::ifstream in(path);
  Problem made;
  made.urdf = next<std::string>(in);
  made.srdf = next<std::string>(in);
  made.packages = next<std::string>(in);
  made.group = next<std::string>(in);
  made.fixed.resize(next<std::size_t>(in));
  for (auto &[name, value] : made.fixed) {
    name = next<std::string>(in);
    value = next<double>(in);
  }
  made.allowed.resize(next<std::size_t>(in));
  for (auto &[a, b] : made.allowed) {
    a = next<std::string>(in);
    b = next<std::string>(in);
  }
  const auto n = next<std::size_t>(in);
  made.start = numbers(in, n);
  made.goal = numbers(in, n);
  made.joints.resize(next<std::size_t>(in));
  for (auto &one : made.joints) {
    one = joint(in);
  }
  for (auto *bodies : {&made.links, &made.obstacles}) {
    bodies->resize(next<std::size_t>(in));
    for (auto &one : *bodies) {
      one = body(in);
    }
  }
  made.pairs.resize(next<std::size_t>(in));
  for (auto &[a, b] : made.pairs) {
    a = next<int>(in);
    b = next<int>(in);
  }
  return made;
}

}  // namespace problem_file
