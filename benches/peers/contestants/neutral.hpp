// The neutral form of a robot or a pair of meshes (README.md), and where its links are in a state.
#pragma once
#include <Eigen/Geometry>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace neutral {

struct Pose {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();

  Pose operator*(const Pose& b) const { return {turn * b.turn, turn * b.shift + shift}; }
};

struct Link {
  enum Kind { Fixed, Turns, Slides, Placed } kind = Fixed;
  std::string id;         // what answers call it
  int parent = -1;        // index in Robot::links
  size_t position = 0;    // index in a state
  double factor = 1, offset = 0;  // a joint that mimics another
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Pose origin;            // of the joint in the parent
  std::vector<Eigen::Vector3d> vertices;      // of all the link's meshes, in its frame
  std::vector<std::array<size_t, 3>> triangles;
};

struct Primitive {
  std::string shape;  // box, sphere, cylinder, capsule
  size_t link = 0;
  std::vector<double> sizes;  // as URDF has them: full lengths
  Pose pose;                  // in the link
};

// Balls of one radius, in the frame of the link.
struct Cloud {
  double radius = 0;
  std::vector<Eigen::Vector3d> points;
};

using State = std::vector<double>;

struct Robot {
  std::vector<Link> links;  // parents first
  std::vector<Primitive> primitives;
  std::vector<Cloud> clouds;  // of worlds only, whose links are where the root is
  std::vector<std::pair<size_t, size_t>> pairs;
  std::map<std::string, std::vector<State>> states;

  // Poses of all links in the root, into `poses`.
  void place(const State& q, std::vector<Pose>& poses) const {
    for (size_t i = 0; i < links.size(); ++i) {
      const Link& link = links[i];
      if (link.parent < 0) continue;  // stays the identity
      Pose pose = poses[link.parent] * link.origin;
      if (link.kind == Link::Turns) {
        const double angle = link.factor * q[link.position] + link.offset;
        pose.turn = pose.turn * turned(link.axis, angle);
      } else if (link.kind == Link::Slides) {
        pose.shift += pose.turn * (link.axis * (link.factor * q[link.position] + link.offset));
      }
      poses[i] = pose;
    }
  }

  // Rodrigues' formula.
  static Eigen::Matrix3d turned(const Eigen::Vector3d& a, double angle) {
    const double s = std::sin(angle), c = std::cos(angle), v = 1 - c;
    Eigen::Matrix3d m;
    m << c + a.x() * a.x() * v, a.x() * a.y() * v - a.z() * s, a.x() * a.z() * v + a.y() * s,
        a.y() * a.x() * v + a.z() * s, c + a.y() * a.y() * v, a.y() * a.z() * v - a.x() * s,
        a.z() * a.x() * v - a.y() * s, a.z() * a.y() * v + a.x() * s, c + a.z() * a.z() * v;
    return m;
  }
};

inline std::vector<std::string> words(const std::string& line) {
  std::vector<std::string> out;
  size_t from = 0;
  for (size_t tab; (tab = line.find('\t', from)) != std::string::npos; from = tab + 1)
    out.push_back(line.substr(from, tab - from));
  out.push_back(line.substr(from));
  return out;
}

inline double number(const std::string& word) { return std::strtod(word.c_str(), nullptr); }

// Twelve words from `at` on: the upper rows of the homogeneous matrix.
inline Pose pose(const std::vector<std::string>& w, size_t at) {
  Pose p;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) p.turn(row, column) = number(w.at(at + 4 * row + column));
    p.shift[row] = number(w.at(at + 4 * row + 3));
  }
  return p;
}

class Reader {
 public:
  explicit Reader(const std::string& file) : in_(file) {
    if (!in_) throw std::runtime_error("cannot open " + file);
    if (next().at(0) != "neutral") throw std::runtime_error(file + " is not in the neutral form");
    while (more()) entry(next());
  }
  Robot robot;

 private:
  std::ifstream in_;
  std::map<std::string, size_t> index_;

  bool more() { return in_.peek() != EOF; }

  std::vector<std::string> next() {
    std::string line;
    std::getline(in_, line);
    return words(line);
  }

  void entry(const std::vector<std::string>& w) {
    if (w[0] == "link") {
      link(w);
    } else if (w[0] == "mesh") {
      mesh(robot.links[index_.at(w.at(1))], std::stoul(w.at(2)), std::stoul(w.at(3)));
    } else if (w[0] == "cloud") {
      robot.clouds.push_back({number(w.at(3)), {}});
      for (size_t n = std::stoul(w.at(2)); n > 0; --n) robot.clouds.back().points.push_back(point(next()));
    } else if (w[0] == "pair") {
      robot.pairs.emplace_back(index_.at(w.at(1)), index_.at(w.at(2)));
    } else if (w[0] == "states") {
      auto& states = robot.states[w.at(1)];
      for (size_t n = std::stoul(w.at(2)); n > 0; --n) states.push_back(numbers(next()));
    } else if (w[0] != "limits") {  // those are for who draws edges
      Primitive p{w[0], index_.at(w.at(1)), {}, pose(w, w.size() - 12)};
      for (size_t i = 2; i + 12 < w.size(); ++i) p.sizes.push_back(number(w[i]));
      robot.primitives.push_back(p);
    }
  }

  void link(const std::vector<std::string>& w) {
    static const std::map<std::string, Link::Kind> kinds{
        {"fixed", Link::Fixed}, {"turns", Link::Turns}, {"slides", Link::Slides}, {"placed", Link::Placed}};
    Link l;
    l.id = w.at(1);
    l.parent = w.at(4) == "-1" ? -1 : static_cast<int>(index_.at(w[4]));
    l.kind = kinds.at(w.at(5));
    l.position = l.kind == Link::Fixed ? 0 : std::stoul(w.at(6));
    l.factor = number(w.at(7));
    l.offset = number(w.at(8));
    l.axis = {number(w.at(9)), number(w.at(10)), number(w.at(11))};
    l.origin = pose(w, 12);
    index_[l.id] = robot.links.size();
    robot.links.push_back(l);
  }

  void mesh(Link& link, size_t vertices, size_t triangles) {
    const size_t first = link.vertices.size();
    for (; vertices > 0; --vertices) link.vertices.push_back(point(next()));
    for (; triangles > 0; --triangles) {
      const auto w = next();
      link.triangles.push_back({first + std::stoul(w.at(0)), first + std::stoul(w.at(1)), first + std::stoul(w.at(2))});
    }
  }

  static Eigen::Vector3d point(const std::vector<std::string>& w) {
    return {number(w.at(0)), number(w.at(1)), number(w.at(2))};
  }

  static State numbers(const std::vector<std::string>& w) {
    State s;
    for (const auto& word : w) s.push_back(number(word));
    return s;
  }
};

}  // namespace neutral
