// C++17 interface of clearance: collisions, distances, motions, plans and proofs. Header only, above the C interface of clearance.h.
//
// Units are metres, radians and seconds. Poses and points are in the frame of the robot's root link.
//
// Errors are exceptions of the class clearance::Error, whose text names the element and says what to do. A collision is a result, and no
// error.
//
// Threads: Robot, Checker and Certificate are immutable; copies share their content, and any number of threads may use them. Each thread
// needs a Workspace of its own. While a thread changes a World, no other thread may use it.
//
// Eigen: vectors are accepted wherever Positions are. If CLEARANCE_WITH_EIGEN is defined, there are conversions of poses and matrices,
// too: define it for all files of a program, for example in the build system.

#ifndef CLEARANCE_HPP
#define CLEARANCE_HPP

#include "clearance.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#ifdef CLEARANCE_WITH_EIGEN
#include <Eigen/Core>
#include <Eigen/Geometry>
#endif

namespace clearance {

// A failed call: the input is rejected, or an argument does not fit.
class Error : public std::runtime_error {
 public:
  Error(clearance_status status, const std::string &text) : std::runtime_error(text), status_(status) {}

  // CLEARANCE_STATUS_REJECTED for input that the library rejects, CLEARANCE_STATUS_ARGUMENT for wrong lengths and the like.
  clearance_status status() const noexcept { return status_; }

 private:
  clearance_status status_;
};

// Values by name: positions (rad, m), paddings (m), factors.
using NamedValues = std::map<std::string, double>;

// Names of two bodies: links, attached objects or obstacles.
using Pair = std::pair<std::string, std::string>;

namespace detail {

inline void check(clearance_status status) {
  if (status != CLEARANCE_STATUS_OK) {
    throw Error(status, clearance_last_error());
  }
}

// Calls a function that makes a handle.
template <typename Handle, typename Make>
Handle *make(Make call) {
  Handle *handle = nullptr;
  check(call(&handle));
  return handle;
}

inline std::string text(const char *text) { return text == nullptr ? std::string() : std::string(text); }

// A text as C reads it. C would read one with a NUL in it as a shorter one.
inline std::string terminated(std::string_view text) {
  if (text.find('\0') != std::string_view::npos) {
    throw Error(CLEARANCE_STATUS_ARGUMENT, "the text '" + std::string(text.substr(0, text.find('\0'))) +
                                               "' is followed by a NUL and more: texts end at their first NUL");
  }
  return std::string(text);
}

// The text of the caller, if C reads all of it.
inline const char *pointer(const std::string &text) {
  terminated(text);
  return text.c_str();
}

inline std::optional<Pair> pair(const clearance_pair &pair) {
  if (pair.a == nullptr) {
    return std::nullopt;
  }
  return Pair(pair.a, text(pair.b));
}

// Arrays of C that refer to names of the caller.
inline std::vector<clearance_named_value> named(const NamedValues &values) {
  std::vector<clearance_named_value> list;
  for (const auto &[name, value] : values) {
    list.push_back({pointer(name), value});
  }
  return list;
}

inline std::vector<const char *> pointers(const std::vector<std::string> &texts) {
  std::vector<const char *> list;
  for (const std::string &text : texts) {
    list.push_back(pointer(text));
  }
  return list;
}

inline std::vector<clearance_pair> pairs(const std::vector<Pair> &names) {
  std::vector<clearance_pair> list;
  for (const auto &[a, b] : names) {
    list.push_back({pointer(a), pointer(b)});
  }
  return list;
}

inline std::array<double, 3> xyz(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

// True for the matrices, blocks and maps of Eigen, whose elements may have gaps between them.
template <typename Container, typename = void>
struct HasStrides : std::false_type {};
template <typename Container>
struct HasStrides<Container, std::void_t<decltype(std::declval<const Container &>().rows()), decltype(std::declval<const Container &>().cols()),
                                         decltype(std::declval<const Container &>().innerStride()),
                                         decltype(std::declval<const Container &>().outerStride()), decltype(Container::IsRowMajor)>>
    : std::true_type {};

// Rejects matrices that are neither one row nor one column, and rows and columns with gaps between their elements.
template <typename Container>
void check_contiguous(const Container &values) {
  if constexpr (HasStrides<Container>::value) {
    if (values.size() <= 1) {
      return;
    }
    if (values.rows() != 1 && values.cols() != 1) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "the positions are a matrix of " + std::to_string(values.rows()) + " x " +
                                                 std::to_string(values.cols()) + ": give one row or column");
    }
    const bool is_along_inner = (values.rows() == 1) == static_cast<bool>(Container::IsRowMajor);
    if ((is_along_inner ? values.innerStride() : values.outerStride()) != 1) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "the positions are not contiguous: copy the row or column into a vector");
    }
  }
}

// The handle of an object that was not moved from.
template <typename Handle>
Handle *valid(Handle *handle, const char *what) {
  if (handle == nullptr) {
    throw Error(CLEARANCE_STATUS_ARGUMENT, std::string("the ") + what + " was moved from: use the object that it was moved to");
  }
  return handle;
}

}  // namespace detail

// Joint positions (rad, m) of one state, or other numbers: refers to contiguous doubles of the caller, such as a std::vector<double>, a
// std::array, a std::span or an Eigen vector. Throws Error for Eigen matrices, and for rows and columns with gaps between the elements.
class Positions {
 public:
  Positions(const double *data, std::size_t size) : data_(data), size_(size) {}

  template <typename Container,
            typename = std::enable_if_t<std::is_convertible_v<decltype(std::declval<const Container &>().data()), const double *>>>
  Positions(const Container &values) : data_(values.data()), size_(static_cast<std::size_t>(values.size())) {
    detail::check_contiguous(values);
  }

  const double *data() const noexcept { return data_; }
  std::size_t size() const noexcept { return size_; }
  clearance_state state() const noexcept { return {data_, size_}; }

 private:
  const double *data_;
  std::size_t size_;
};

// Many states: refers to rows of n joint positions each (rad, m), row by row.
class States {
 public:
  States(const double *data, std::size_t count, std::size_t n) : data_(data), count_(count), n_(n) {}

  // All rows one after the other; n positions each.
  States(const std::vector<double> &values, std::size_t n) : States(values.data(), n == 0 ? 0 : values.size() / n, n) {
    if (n == 0 || values.size() % n != 0) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "the number of positions, " + std::to_string(values.size()) + ", is not a multiple of n, " + std::to_string(n));
    }
  }

#ifdef CLEARANCE_WITH_EIGEN
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  // A matrix with a row for each state, which is not copied.
  States(const Rows &rows)
      : States(rows.data(), static_cast<std::size_t>(rows.rows()), static_cast<std::size_t>(rows.cols())) {}

  // The same of another kind of matrix, which is copied.
  template <typename Derived>
  States(const Eigen::MatrixBase<Derived> &rows)
      : data_(nullptr),
        count_(static_cast<std::size_t>(rows.rows())),
        n_(static_cast<std::size_t>(rows.cols())),
        own_(static_cast<std::size_t>(rows.size())) {
    Eigen::Map<Rows>(own_.data(), rows.rows(), rows.cols()) = rows;
    data_ = own_.data();
  }
#endif

  States(const States &) = delete;
  States &operator=(const States &) = delete;

  const double *data() const noexcept { return data_; }
  std::size_t count() const noexcept { return count_; }
  std::size_t n() const noexcept { return n_; }

 private:
  const double *data_;
  std::size_t count_;
  std::size_t n_;
  std::vector<double> own_;
};

// A pose: position (m) and unit quaternion x, y, z, w. By default the identity.
struct Pose : clearance_pose {
  Pose() : Pose(0.0, 0.0, 0.0) {}
  Pose(double x, double y, double z) : clearance_pose{{x, y, z}, {0.0, 0.0, 0.0, 1.0}} {}
  Pose(const std::array<double, 3> &p, const std::array<double, 4> &q)
      : clearance_pose{{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}} {}
  explicit Pose(const clearance_pose &pose) : clearance_pose(pose) {}

#ifdef CLEARANCE_WITH_EIGEN
  Pose(const Eigen::Isometry3d &pose) : Pose() {
    const Eigen::Quaterniond q(pose.rotation());
    for (int i = 0; i < 3; ++i) {
      position[i] = pose.translation()[i];
    }
    for (int i = 0; i < 4; ++i) {
      orientation[i] = q.coeffs()[i];
    }
  }

  Eigen::Isometry3d isometry() const {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(Eigen::Vector3d(position[0], position[1], position[2]));
    return pose.rotate(Eigen::Quaterniond(orientation[3], orientation[0], orientation[1], orientation[2]));
  }
#endif
};

// A robot: links and joints from URDF, groups and allowed collisions from SRDF, with the meshes.
class Robot {
 public:
  // Reads a robot; urdf and srdf are paths or XML texts. Folders that package:// is searched in first: package_paths.
  static Robot from_urdf(std::string_view urdf, std::string_view srdf = {},
                         const std::vector<std::string> &package_paths = {}) {
    const std::string urdf_text = detail::terminated(urdf), srdf_text = detail::terminated(srdf);
    const auto folders = detail::pointers(package_paths);
    return Robot(detail::make<clearance_robot>([&](clearance_robot **robot) {
      return clearance_robot_from_urdf(urdf_text.c_str(), srdf.empty() ? nullptr : srdf_text.c_str(), folders.data(),
                                       folders.size(), robot);
    }));
  }

  std::string name() const { return clearance_robot_name(valid()); }
  std::string root_link() const { return clearance_robot_root_link(valid()); }

  // Names of the positions of a state of the whole robot, in order.
  std::vector<std::string> joint_names() const {
    return names(clearance_robot_joint_count(valid()), clearance_robot_joint_name);
  }
  // Names of the links, in the order of the URDF.
  std::vector<std::string> link_names() const {
    return names(clearance_robot_link_count(valid()), clearance_robot_link_name);
  }
  // Texts about unusual content that was accepted.
  std::vector<std::string> warnings() const {
    return names(clearance_robot_warning_count(valid()), clearance_robot_warning);
  }
  // Names of the group states of the SRDF, as GROUP/STATE.
  std::vector<std::string> group_states() const {
    return names(clearance_robot_group_state_count(valid()), clearance_robot_group_state_name);
  }
  // The groups of the SRDF: the names of the positions of each.
  std::map<std::string, std::vector<std::string>> groups() const {
    std::map<std::string, std::vector<std::string>> groups;
    for (std::size_t i = 0; i < clearance_robot_group_count(valid()); ++i) {
      auto &joints = groups[clearance_robot_group_name(valid(), i)];
      for (std::size_t k = 0; k < clearance_robot_group_joint_count(valid(), i); ++k) {
        joints.emplace_back(clearance_robot_group_joint_name(valid(), i, k));
      }
    }
    return groups;
  }

  // Lower and upper limits (rad, m) of the positions; infinite without limit.
  std::pair<std::vector<double>, std::vector<double>> limits() const {
    std::vector<double> lower(size()), upper(size());
    detail::check(clearance_robot_limits(valid(), lower.data(), upper.data(), size()));
    return {lower, upper};
  }

  // A state of the whole robot with some joints set by name (rad, m), the others at their defaults.
  std::vector<double> state(const NamedValues &values = {}) const {
    const auto list = detail::named(values);
    std::vector<double> q(size());
    detail::check(clearance_robot_state(valid(), list.data(), list.size(), q.data(), q.size()));
    return q;
  }

  // A group state of the SRDF, STATE or GROUP/STATE, as a state of the whole robot.
  std::vector<double> group_state(std::string_view name) const {
    std::vector<double> q(size());
    detail::check(clearance_robot_group_state(valid(), detail::terminated(name).c_str(), q.data(), q.size()));
    return q;
  }

  // Random states of the whole robot, uniform between the limits, row by row; seed is updated.
  std::vector<double> random_states(std::uint64_t &seed, std::size_t count = 1) const {
    std::vector<double> rows(count * size());
    detail::check(clearance_robot_random_states(valid(), &seed, count, rows.data(), size()));
    return rows;
  }

  // The poses of all links in the frame of the root link, in the order of link_names, for a state of the whole robot.
  std::vector<Pose> forward_kinematics(Positions q) const {
    std::vector<clearance_pose> poses(clearance_robot_link_count(valid()));
    detail::check(clearance_robot_forward_kinematics(valid(), q.state(), poses.data(), poses.size()));
    std::vector<Pose> result;
    for (const clearance_pose &pose : poses) {
      result.emplace_back(pose);
    }
    return result;
  }

  // The pose of a link in the frame of the root link, for a state of the whole robot.
  Pose link_pose(Positions q, std::string_view link) const {
    Pose pose;
    detail::check(clearance_robot_link_pose(valid(), q.state(), detail::terminated(link).c_str(), &pose));
    return pose;
  }

  // Number of positions of a state of the whole robot.
  std::size_t size() const { return clearance_robot_joint_count(valid()); }

  const clearance_robot *handle() const noexcept { return handle_.get(); }

 private:
  explicit Robot(clearance_robot *handle) : handle_(handle, clearance_robot_free) {}

  const clearance_robot *valid() const { return detail::valid(handle(), "robot"); }

  std::vector<std::string> names(std::size_t count, const char *(*get)(const clearance_robot *, std::size_t)) const {
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < count; ++i) {
      texts.emplace_back(get(handle(), i));
    }
    return texts;
  }

  std::shared_ptr<clearance_robot> handle_;
};

// Obstacles around a robot, by name; lengths in metres, poses in the frame of the robot's root link.
class World {
 public:
  World() : World(detail::make<clearance_world>(clearance_world_new)) {}
  World(const World &other)
      : World(detail::make<clearance_world>(
            [&](clearance_world **world) { return clearance_world_copy(detail::valid(other.handle(), "world"), world); })) {}
  World(World &&) noexcept = default;
  World &operator=(World other) noexcept {
    handle_ = std::move(other.handle_);
    return *this;
  }
  ~World() = default;

  // Reads a file: MoveIt's planning scene (YAML or .scene), an octree, or a cloud with balls of point_radius (m) around its points.
  static World from_file(std::string_view path, const Robot *robot = nullptr, double point_radius = 0.0,
                         bool unknown_is_occupied = false) {
    const std::string text = detail::terminated(path);
    const clearance_robot *frames = robot == nullptr ? nullptr : detail::valid(robot->handle(), "robot");
    return World(detail::make<clearance_world>([&](clearance_world **world) {
      return clearance_world_from_file(text.c_str(), frames, point_radius, unknown_is_occupied ? 1 : 0, world);
    }));
  }
  static World from_file(std::string_view path, const Robot &robot) { return from_file(path, &robot); }

  void add_box(std::string_view name, const std::array<double, 3> &size, const Pose &pose = {}) {
    detail::check(clearance_world_add_box(valid(), detail::terminated(name).c_str(), size.data(), &pose));
  }
  void add_sphere(std::string_view name, double radius, const Pose &pose = {}) {
    detail::check(clearance_world_add_sphere(valid(), detail::terminated(name).c_str(), radius, &pose));
  }
  // Along z, centred at pose.
  void add_cylinder(std::string_view name, double radius, double length, const Pose &pose = {}) {
    detail::check(clearance_world_add_cylinder(valid(), detail::terminated(name).c_str(), radius, length, &pose));
  }
  // Along z, centred at pose; length does not include the half spheres.
  void add_capsule(std::string_view name, double radius, double length, const Pose &pose = {}) {
    detail::check(clearance_world_add_capsule(valid(), detail::terminated(name).c_str(), radius, length, &pose));
  }
  // Vertices: three coordinates each; triangles: three indices each.
  void add_mesh(std::string_view name, const std::vector<double> &vertices, const std::vector<std::uint32_t> &triangles,
                const Pose &pose = {}) {
    if (vertices.size() % 3 != 0 || triangles.size() % 3 != 0) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "the mesh '" + std::string(name) + "' needs three numbers for each vertex and triangle");
    }
    const clearance_mesh mesh = {vertices.data(), vertices.size() / 3, triangles.data(), triangles.size() / 3};
    detail::check(clearance_world_add_mesh(valid(), detail::terminated(name).c_str(), mesh, &pose));
  }
  // STL, OBJ, COLLADA, PLY, glTF, with a scale for each axis.
  void add_mesh_file(std::string_view name, std::string_view path, const std::array<double, 3> &scale = {1.0, 1.0, 1.0},
                     const Pose &pose = {}) {
    detail::check(clearance_world_add_mesh_file(valid(), detail::terminated(name).c_str(), detail::terminated(path).c_str(),
                                                scale.data(), &pose));
  }
  // Balls of one radius around points of three coordinates each.
  void add_points(std::string_view name, const std::vector<double> &xyz, double radius, const Pose &pose = {}) {
    if (xyz.size() % 3 != 0) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "the points '" + std::string(name) + "' need three numbers each");
    }
    detail::check(
        clearance_world_add_points(valid(), detail::terminated(name).c_str(), {xyz.data(), xyz.size() / 3}, radius, &pose));
  }
  void move(std::string_view name, const Pose &pose) {
    detail::check(clearance_world_move(valid(), detail::terminated(name).c_str(), &pose));
  }
  void remove(std::string_view name) {
    detail::check(clearance_world_remove(valid(), detail::terminated(name).c_str()));
  }

  std::vector<std::string> obstacle_names() const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < clearance_world_obstacle_count(valid()); ++i) {
      names.emplace_back(clearance_world_obstacle_name(valid(), i));
    }
    return names;
  }
  // Texts about unusual content of a file that was accepted.
  std::vector<std::string> warnings() const {
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < clearance_world_warning_count(valid()); ++i) {
      texts.emplace_back(clearance_world_warning(valid(), i));
    }
    return texts;
  }

  clearance_world *handle() noexcept { return handle_.get(); }
  const clearance_world *handle() const noexcept { return handle_.get(); }

 private:
  friend class Checker;
  explicit World(clearance_world *handle) : handle_(handle) {}

  clearance_world *valid() { return detail::valid(handle(), "world"); }
  const clearance_world *valid() const { return detail::valid(handle(), "world"); }

  struct Free {
    void operator()(clearance_world *world) const { clearance_world_free(world); }
  };
  std::unique_ptr<clearance_world, Free> handle_;
};

// Options of a checker.
struct CheckerOptions {
  // Group of the SRDF whose positions are those of a state, in the order of the robot, which joint_names gives; empty for all joints of
  // the robot. A mimic joint of the group has no position; without its leader in the group, it stays in place.
  std::string group;
  // Positions (rad, m) of joints outside of the group.
  NamedValues fixed;
  // Safety distance (m) of all links against obstacles, with pad_self also between links.
  double padding = 0.0;
  bool pad_self = false;
  bool check_self = true;
  bool check_world = true;
  // A closed mesh includes its inside.
  bool solid_meshes = false;
  // By name: paddings (m) and scale factors.
  NamedValues link_padding, link_scale, object_padding, object_scale;
  // Pairs that may touch, and pairs that are checked, whatever the world's file or the SRDF allows. A pair that cannot be checked, such as
  // an attached object and the link that holds it, is an error, also of with_world, attach and detach.
  std::vector<Pair> allowed_collisions, checked_collisions;
};

namespace detail {

// Options as C reads them; refers to the options of the caller.
class COptions {
 public:
  explicit COptions(const CheckerOptions &options)
      : fixed_(named(options.fixed)),
        link_padding_(named(options.link_padding)),
        link_scale_(named(options.link_scale)),
        object_padding_(named(options.object_padding)),
        object_scale_(named(options.object_scale)),
        allowed_(pairs(options.allowed_collisions)),
        checked_(pairs(options.checked_collisions)),
        options_(clearance_checker_options_default()) {
    options_.group = options.group.empty() ? nullptr : pointer(options.group);
    options_.padding = options.padding;
    options_.pad_self = options.pad_self ? 1 : 0;
    options_.check_self = options.check_self ? 1 : 0;
    options_.check_world = options.check_world ? 1 : 0;
    options_.solid_meshes = options.solid_meshes ? 1 : 0;
    set(fixed_, options_.fixed, options_.fixed_count);
    set(link_padding_, options_.link_padding, options_.link_padding_count);
    set(link_scale_, options_.link_scale, options_.link_scale_count);
    set(object_padding_, options_.object_padding, options_.object_padding_count);
    set(object_scale_, options_.object_scale, options_.object_scale_count);
    set(allowed_, options_.allowed_collisions, options_.allowed_collision_count);
    set(checked_, options_.checked_collisions, options_.checked_collision_count);
  }
  COptions(const COptions &) = delete;
  COptions &operator=(const COptions &) = delete;

  const clearance_checker_options *get() const { return &options_; }

 private:
  template <typename Element>
  static void set(const std::vector<Element> &list, const Element *&data, std::size_t &count) {
    data = list.data();
    count = list.size();
  }

  std::vector<clearance_named_value> fixed_, link_padding_, link_scale_, object_padding_, object_scale_;
  std::vector<clearance_pair> allowed_, checked_;
  clearance_checker_options options_;
};

}  // namespace detail

// Options of motion checks.
struct MotionOptions {
  // Pairs that stay farther apart than this (m) are always decided.
  double tolerance = clearance_motion_options_default().tolerance;
  // Time (s) after which a check ends with its results so far.
  double timeout = clearance_motion_options_default().timeout;
  // Number of evaluations of a pair after which a check ends.
  std::uint64_t budget = clearance_motion_options_default().budget;
  // Tracking tolerance (rad, m): one for each position, or one for all, or none.
  std::vector<double> tube;
  // The check ends at any contact, not at the earliest.
  bool any_contact = false;
  // A motion that is free gets a certificate.
  bool certificate = false;
  // Threads of are_motions_free; 0 for all cores.
  std::size_t threads = 0;
  // Distance (m) that pairs have to keep, besides their paddings: a pair that is not farther apart counts as touching.
  double margin = 0.0;

  // As C reads them; refers to this object.
  clearance_motion_options c_options() const {
    return {tolerance, timeout, budget, tube.data(), tube.size(), any_contact ? 1 : 0, certificate ? 1 : 0, threads,
            margin};
  }
};

// Options of searches for the least distances along a motion.
struct AlongOptions {
  // The search ends when lower and upper bound differ by at most this (m), or by this fraction of the upper bound.
  double absolute_tolerance = clearance_along_options_default().absolute_tolerance;
  double relative_tolerance = clearance_along_options_default().relative_tolerance;
  // Larger distances (m) do not matter.
  double max_distance = clearance_along_options_default().max_distance;
  // Time (s) after which a search ends with its results so far.
  double timeout = clearance_along_options_default().timeout;
  // Number of evaluations of a pair after which a search ends.
  std::uint64_t budget = clearance_along_options_default().budget;
  // Tracking tolerance (rad, m): one for each position, or one for all, or none.
  std::vector<double> tube;

  // As C reads them; refers to this object.
  clearance_along_options c_options() const {
    return {absolute_tolerance, relative_tolerance, max_distance, timeout, budget, tube.data(), tube.size()};
  }
};

// A trajectory: points with all positions of a state each, row by row.
struct Trajectory {
  // count x n positions (rad, m).
  std::vector<double> positions;
  // Number of positions of a state.
  std::size_t n = 0;
  // Times (s from the start), one for each point; none for a path without times.
  std::vector<double> times;
  // As the positions (rad/s, m/s), or empty.
  std::vector<double> velocities;
  // As the positions (rad/s², m/s²), or empty; they need velocities.
  std::vector<double> accelerations;
  // Continuous joints go the shortest way.
  bool shortest = false;

  // As C reads it; refers to this object.
  clearance_trajectory c_trajectory() const {
    const std::size_t count = n == 0 ? 0 : positions.size() / n;
    if (n == 0 || positions.size() != count * n || !(times.empty() || times.size() == count) || !fits(velocities) ||
        !fits(accelerations)) {
      throw Error(CLEARANCE_STATUS_ARGUMENT,
                  "the trajectory needs n positions for each point, and times, velocities and accelerations for all points or none");
    }
    return {positions.data(),          count, n, pointer(times), pointer(velocities), pointer(accelerations),
            shortest ? 1 : 0};
  }

 private:
  bool fits(const std::vector<double> &rates) const { return rates.empty() || rates.size() == positions.size(); }
  static const double *pointer(const std::vector<double> &values) { return values.empty() ? nullptr : values.data(); }
};

// Result of a verification: true only if the certificate proves the motion free.
struct Verification {
  bool is_valid = false;
  // Why the certificate is rejected; empty if it is valid.
  std::string reason;
  std::size_t segments = 0;
  std::size_t pairs = 0;
  std::size_t proofs = 0;

  explicit operator bool() const noexcept { return is_valid; }
};

// Expected content of a certificate: the options and tolerances of the check, and the motion.
struct Expectation {
  // Options of the check, without objects that the world does not have.
  CheckerOptions options;
  // The motion; without it only the proof is checked. A straight motion is a path of two states without times.
  std::optional<Trajectory> motion;
  std::vector<double> tube;
  // Tolerance (m) of the check; 0 for any.
  double tolerance = 0.0;
  // Distance (m) that the proof has to keep at least, besides paddings; 0 for any.
  double margin = 0.0;
};

// A proof that a motion is free, for one robot in one world.
class Certificate {
 public:
  // Takes over a handle.
  explicit Certificate(clearance_certificate *handle) : handle_(handle, clearance_certificate_free) {}

  static Certificate from_json(std::string_view json) {
    const std::string text = detail::terminated(json);
    return Certificate(detail::make<clearance_certificate>([&](clearance_certificate **certificate) {
      return clearance_certificate_from_json(text.c_str(), certificate);
    }));
  }

  // One line of JSON, as `clearance motion --certificate` writes it.
  std::string to_json() const { return detail::text(clearance_certificate_to_json(valid())); }
  std::size_t segment_count() const { return clearance_certificate_segment_count(valid()); }
  std::size_t pair_count() const { return clearance_certificate_pair_count(valid()); }

  // Verifies with code that is independent of the checker that this proves a motion of the robot in the world free.
  Verification verify(const Robot &robot, const World &world, const Expectation &expected = {}) const {
    const detail::COptions options(expected.options);
    clearance_expectation expectation = clearance_expectation_default();
    clearance_trajectory motion;
    if (expected.motion) {
      motion = expected.motion->c_trajectory();
      expectation.motion = &motion;
    }
    expectation.options = options.get();
    expectation.margin = expected.margin;
    expectation.tube = expected.tube.data();
    expectation.tube_count = expected.tube.size();
    expectation.tolerance = expected.tolerance;
    clearance_verification found;
    detail::check(clearance_verify(valid(), detail::valid(robot.handle(), "robot"), detail::valid(world.handle(), "world"),
                                   &expectation, &found));
    return {found.is_valid, detail::text(found.reason), found.segments, found.pairs, found.proofs};
  }

  const clearance_certificate *handle() const noexcept { return handle_.get(); }

 private:
  const clearance_certificate *valid() const { return detail::valid(handle(), "certificate"); }

  std::shared_ptr<clearance_certificate> handle_;
};

// Distance of two bodies (m, padding subtracted) and their nearest points (root frame, without padding).
struct PairDistance {
  // None if no pair is within the largest distance; then the distance is infinite.
  std::optional<Pair> pair;
  double distance = std::numeric_limits<double>::infinity();
  std::array<std::array<double, 3>, 2> points{};
};

// Least distances within the robot, and between robot and world.
struct Distances {
  PairDistance self;
  PairDistance world;
};

// A contact of two bodies, paddings included; in the root frame.
struct Contact {
  Pair pair;
  std::array<double, 3> point{};
  // Unit vector along which the second body separates; NaN if it is not known.
  std::array<double, 3> normal{};
  // Penetration depth (m), or an upper bound on it; NaN if it is not known.
  double depth = 0.0;
  double depth_lower = 0.0;
  bool is_deepest = false;
};

// Report on one state.
struct Report {
  bool is_free = false;
  bool self_collision = false;
  bool world_collision = false;
  std::vector<Pair> colliding_pairs;
  std::vector<Contact> contacts;
  std::vector<PairDistance> distances;
};

// Signed distance of two bodies, with bounds, nearest points and normal (root frame).
struct PairClearance {
  Pair pair;
  double distance = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  std::array<std::array<double, 3>, 2> points{};
  std::array<double, 3> normal{};
  // The nearest points are unique: the signed distance has a derivative.
  bool is_unique = false;
};

// Signed distances of near pairs, and their derivatives.
struct Clearance {
  std::vector<PairClearance> pairs;
  // Derivatives (m/rad, m/m): a row for each pair, a column for each position.
  std::vector<double> gradients;
  // Number of columns.
  std::size_t n = 0;

  // Derivatives of a pair.
  const double *gradient(std::size_t pair) const { return gradients.data() + pair * n; }

#ifdef CLEARANCE_WITH_EIGEN
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::Map<const Rows> gradient_matrix() const {
    return {gradients.data(), static_cast<Eigen::Index>(pairs.size()), static_cast<Eigen::Index>(n)};
  }
#endif
};

// Verdict on a motion; free is a proof for every point.
enum class Verdict { undecided = -1, contact = 0, free = 1 };

// Report on a motion.
struct MotionReport {
  Verdict verdict = Verdict::undecided;
  clearance_reason reason = CLEARANCE_REASON_NONE;
  // Contact: proven free before t[0], collides at t[1]. Undecided: proven free before t[0] and after t[1]. Free: NaN.
  std::array<double, 2> t{};
  std::optional<Pair> pair;
  // Undecided: bounds on the distance (m).
  std::array<double, 2> distance{};
  // Contact: a common point (m, root frame), NaN if none is known.
  std::array<double, 3> point{};
  // Trajectory: the segment of the verdict, and times (s) of t.
  std::size_t segment = 0;
  std::array<double, 2> time{};
  std::uint64_t evaluations = 0;
  std::optional<Certificate> certificate;

  bool is_free() const noexcept { return verdict == Verdict::free; }
};

// Proven bounds on the least distance of the pairs of one kind along a motion (m, padding subtracted).
struct LeastDistance {
  // No pair is nearer at any time; 0 if some pair touches or nothing is proven. Infinite if no such pairs are checked.
  double lower = 0.0;
  // Distance of the pair at t: the least distance is not larger. Infinite if there is no pair.
  double upper = 0.0;
  std::optional<Pair> pair;
  // Nearest points of the pair (m, root frame), without padding.
  std::array<std::array<double, 3>, 2> points{};
  // Where `upper` is attained: fraction of the motion or segment, segment, time (s) of a trajectory with times.
  double t = 0.0;
  std::size_t segment = 0;
  double time = 0.0;
};

// The least distances along a motion.
struct MotionDistances {
  LeastDistance nearest_self;
  LeastDistance nearest_world;
  // Why the bounds differ by more than the tolerance, or none.
  clearance_reason reason = CLEARANCE_REASON_NONE;
  std::uint64_t evaluations = 0;

  // No pair is nearer than this (m) at any time.
  double lower() const noexcept {
    return nearest_self.lower < nearest_world.lower ? nearest_self.lower : nearest_world.lower;
  }
};

// Limits of a search for a path.
struct PlanOptions {
  std::uint64_t seed = clearance_plan_options_default().seed;
  double timeout = clearance_plan_options_default().timeout;
  std::uint64_t max_edges = clearance_plan_options_default().max_edges;
  double range = clearance_plan_options_default().range;
  std::uint32_t shortcuts = clearance_plan_options_default().shortcuts;
  bool certificate = false;
};

// Result of a search for a path; nothing is proven if none is found.
struct Plan {
  bool is_found = false;
  // found, found_without_certificate (the time was over before the proof was complete), start_not_free, goal_not_free, most_edges or
  // deadline.
  std::string reason;
  // From the start to the goal; the edges between them are proven free.
  std::vector<std::vector<double>> states;
  double length = 0.0;
  std::uint64_t edges = 0;
  std::optional<Certificate> certificate;
};

// Limits of a search for a free state.
struct RecoveryOptions {
  double max_distance = clearance_recovery_options_default().max_distance;
  double clearance = clearance_recovery_options_default().clearance;
  std::uint64_t max_checks = clearance_recovery_options_default().max_checks;
  double timeout = clearance_recovery_options_default().timeout;
  // Joints that stay where they are.
  std::vector<std::string> locked;
};

// Result of a search for a free state.
struct FreeState {
  bool is_found = false;
  // found, already_free, not_movable, unfinished or beyond_limits.
  std::string reason;
  std::vector<double> positions;
  // Euclidean norm of all changes (rad, m).
  double distance = 0.0;
  // The straight motion is proven free from this t on.
  double exit = 0.0;
  // A pair that no movable joint moves apart by the clearance.
  std::optional<Pair> pair;
  std::uint64_t checks = 0;
};

class Checker;

// Memory of queries: one for each thread.
class Workspace {
 public:
  explicit Workspace(const Checker &checker);
  clearance_workspace *handle() noexcept { return handle_.get(); }

 private:
  struct Free {
    void operator()(clearance_workspace *workspace) const { clearance_workspace_free(workspace); }
  };
  std::unique_ptr<clearance_workspace, Free> handle_;
};

// Checks states and motions of a robot in a world. States have the positions of joint_names.
class Checker {
 public:
  Checker(const Robot &robot, const World &world, const CheckerOptions &options = {})
      : Checker(made(robot, detail::valid(world.handle(), "world"), options)) {}
  // Without obstacles.
  explicit Checker(const Robot &robot, const CheckerOptions &options = {}) : Checker(made(robot, nullptr, options)) {}

  Workspace workspace() const { return Workspace(*this); }

  // The same checker in another world. Hierarchies of links and of obstacles that do not change are shared. Paddings, scales and pairs
  // of objects that the world does not have are dropped, also in checkers that are made from that one. Links hold what is attached in
  // that world, and nothing else.
  Checker with_world(const World &world) const {
    return Checker(detail::make<clearance_checker>(
        [&](clearance_checker **made) {
          return clearance_checker_with_world(valid(), detail::valid(world.handle(), "world"), made);
        }));
  }

  // A checker in which an obstacle is attached to a link at a pose in its frame; touch_links may touch it, besides the link.
  Checker attach(std::string_view object, std::string_view link, const Pose &pose,
                 const std::vector<std::string> &touch_links = {}) const {
    return attached(object, link, &pose, {nullptr, 0}, touch_links);
  }
  // The same where the object is in the world, in the state q of the grasp.
  Checker attach_at(std::string_view object, std::string_view link, Positions q,
                    const std::vector<std::string> &touch_links = {}) const {
    return attached(object, link, nullptr, q, touch_links);
  }
  // A checker in which an attached object is an obstacle, where it is in the state q.
  Checker detach(std::string_view object, Positions q) const {
    const std::string name = detail::terminated(object);
    return Checker(detail::make<clearance_checker>([&](clearance_checker **made) {
      return clearance_checker_detach(valid(), name.c_str(), q.state(), made);
    }));
  }

  // A copy of the world.
  World world() const {
    return World(detail::make<clearance_world>(
        [&](clearance_world **world) { return clearance_checker_world(valid(), world); }));
  }

  // Number of positions of a state.
  std::size_t size() const { return clearance_checker_joint_count(valid()); }
  std::vector<std::string> joint_names() const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < size(); ++i) {
      names.emplace_back(clearance_checker_joint_name(valid(), i));
    }
    return names;
  }
  // True if a whole turn of a position changes nothing: a continuous joint without mimic joints that it moves elsewhere.
  bool is_continuous(std::size_t joint) const { return clearance_checker_joint_is_continuous(valid(), joint); }
  // Lower and upper limits (rad, m) of the positions; infinite without limit.
  std::pair<std::vector<double>, std::vector<double>> limits() const {
    std::vector<double> lower(size()), upper(size());
    detail::check(clearance_checker_limits(valid(), lower.data(), upper.data(), size()));
    return {lower, upper};
  }
  // A state with some joints set by name (rad, m), the others at their defaults.
  std::vector<double> state(const NamedValues &values = {}) const {
    const auto list = detail::named(values);
    std::vector<double> q(size());
    detail::check(clearance_checker_state(valid(), list.data(), list.size(), q.data(), q.size()));
    return q;
  }
  // The positions of the whole robot for a state, count of them.
  std::vector<double> expand(Positions q, std::size_t count) const {
    std::vector<double> whole(count);
    detail::check(clearance_checker_expand(valid(), q.state(), whole.data(), whole.size()));
    return whole;
  }
  // The pairs of bodies that are checked.
  std::vector<Pair> pairs() const {
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < clearance_checker_pair_count(valid()); ++i) {
      const clearance_pair pair = clearance_checker_pair(valid(), i);
      pairs.emplace_back(pair.a, pair.b);
    }
    return pairs;
  }

  // Texts about the checker, such as that it has no pair of bodies to check. Those of the robot and of the world are separate.
  std::vector<std::string> warnings() const {
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < clearance_checker_warning_count(valid()); ++i) {
      texts.emplace_back(clearance_checker_warning(valid(), i));
    }
    return texts;
  }

  // True is proven: every pair is apart, by more than the padding.
  bool is_free(Positions q, Workspace &workspace) const {
    bool is_free = false;
    detail::check(clearance_checker_is_free(valid(), valid(workspace), q.state(), &is_free));
    return is_free;
  }
  // 1 for each state that is free, otherwise 0. Threads: 0 for all cores.
  std::vector<std::uint8_t> are_free(const States &states, Workspace &workspace, std::size_t threads = 0) const {
    std::vector<std::uint8_t> free(states.count());
    const clearance_states rows = {states.data(), states.count(), states.n()};
    detail::check(clearance_checker_are_free(valid(), valid(workspace), rows, threads, free.data()));
    return free;
  }
  // Least distances up to max_distance (m).
  Distances distance(Positions q, Workspace &workspace, double max_distance = 0.1) const {
    clearance_distances found;
    detail::check(clearance_checker_distance(valid(), valid(workspace), q.state(), max_distance, &found));
    return {pair_distance(found.self_pair), pair_distance(found.world_pair)};
  }
  // All colliding pairs, their contacts, and distances of all pairs up to max_distance (m).
  Report check(Positions q, Workspace &workspace, double max_distance = 0.1, std::size_t max_contacts = 1) const {
    const clearance_report_options options = {max_distance, max_contacts};
    clearance_report found;
    detail::check(clearance_checker_check(valid(), valid(workspace), q.state(), &options, &found));
    return report(found);
  }
  // Signed distances up to influence_distance (m), with derivatives.
  Clearance clearance(Positions q, Workspace &workspace, double influence_distance) const {
    clearance_clearance found;
    detail::check(clearance_checker_clearance(valid(), valid(workspace), q.state(), influence_distance, &found));
    Clearance result;
    for (std::size_t i = 0; i < found.pair_count; ++i) {
      const clearance_pair_clearance &pair = found.pairs[i];
      result.pairs.push_back({Pair(pair.pair.a, pair.pair.b), pair.distance, pair.lower, pair.upper,
                              {detail::xyz(pair.points[0]), detail::xyz(pair.points[1])}, detail::xyz(pair.normal),
                              pair.is_unique});
    }
    result.n = found.n;
    result.gradients.assign(found.gradients, found.gradients + found.pair_count * found.n);
    return result;
  }

  // Whether the straight motion is proven free, at every point.
  bool is_motion_free(Positions from, Positions to, Workspace &workspace, const MotionOptions &options = {}) const {
    const clearance_motion_options c_options = options.c_options();
    bool is_free = false;
    detail::check(
        clearance_checker_is_motion_free(valid(), valid(workspace), edge(from, to), &c_options, &is_free));
    return is_free;
  }
  // 1 for each straight motion that is proven free, otherwise 0.
  std::vector<std::uint8_t> are_motions_free(const States &from, const States &to, Workspace &workspace,
                                             const MotionOptions &options = {}) const {
    if (from.count() != to.count() || from.n() != to.n()) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "from has " + shape(from) + ", but to has " + shape(to) + ": they must be the same");
    }
    const clearance_motion_options c_options = options.c_options();
    const clearance_edges edges = {from.data(), to.data(), from.count(), from.n()};
    std::vector<std::uint8_t> free(from.count());
    detail::check(
        clearance_checker_are_motions_free(valid(), valid(workspace), edges, &c_options, free.data()));
    return free;
  }
  // Report on the straight motion; free is a proof.
  MotionReport check_motion(Positions from, Positions to, Workspace &workspace, const MotionOptions &options = {}) const {
    const clearance_motion_options c_options = options.c_options();
    clearance_motion_report found;
    detail::check(
        clearance_checker_check_motion(valid(), valid(workspace), edge(from, to), &c_options, &found));
    return motion_report(found);
  }
  // Report on a trajectory.
  MotionReport check_trajectory(const Trajectory &trajectory, Workspace &workspace,
                                const MotionOptions &options = {}) const {
    const clearance_motion_options c_options = options.c_options();
    const clearance_trajectory c_trajectory = trajectory.c_trajectory();
    clearance_motion_report found;
    detail::check(
        clearance_checker_check_trajectory(valid(), valid(workspace), &c_trajectory, &c_options, &found));
    return motion_report(found);
  }

  // Proven bounds on the least distances along the straight motion.
  MotionDistances clearance_along(Positions from, Positions to, Workspace &workspace,
                                  const AlongOptions &options = {}) const {
    const clearance_along_options c_options = options.c_options();
    clearance_motion_distances found;
    detail::check(
        clearance_checker_clearance_along(valid(), valid(workspace), edge(from, to), &c_options, &found));
    return motion_distances(found);
  }
  // Proven bounds on the least distances along a trajectory.
  MotionDistances clearance_along(const Trajectory &trajectory, Workspace &workspace,
                                  const AlongOptions &options = {}) const {
    const clearance_along_options c_options = options.c_options();
    const clearance_trajectory c_trajectory = trajectory.c_trajectory();
    clearance_motion_distances found;
    detail::check(clearance_checker_clearance_along_trajectory(valid(), valid(workspace), &c_trajectory, &c_options,
                                                               &found));
    return motion_distances(found);
  }
  // The first time at which a pair is not farther apart than the distance (m), besides its padding, which takes the place of the
  // margin: a report as of check_motion, whose certificate proves this distance. A trajectory: check_trajectory with a margin.
  MotionReport event_distance(Positions from, Positions to, double distance, Workspace &workspace,
                              MotionOptions options = {}) const {
    if (options.margin != 0.0 || options.any_contact) {
      throw Error(CLEARANCE_STATUS_ARGUMENT,
                  "event_distance finds the first time at the distance: margin and any_contact must be left out");
    }
    options.margin = distance;
    return check_motion(from, to, workspace, options);
  }

  // Searches for a path of straight edges that are proven free, within the joint limits.
  Plan plan(Positions start, Positions goal, Workspace &workspace, const PlanOptions &options = {}) const {
    const clearance_plan_options c_options = {options.seed,  options.timeout,   options.max_edges,
                                              options.range, options.shortcuts, options.certificate ? 1 : 0};
    clearance_plan found;
    detail::check(clearance_checker_plan(valid(), valid(workspace), edge(start, goal), &c_options, &found));
    Plan plan{found.is_found, detail::text(found.reason), {}, found.length, found.edges, certificate(found.certificate)};
    for (std::size_t i = 0; i < found.count; ++i) {
      plan.states.emplace_back(found.states + i * found.n, found.states + (i + 1) * found.n);
    }
    return plan;
  }
  // Searches for a free state near q. Floating joints and passive joints of the SRDF never move, planar joints only with a group that has
  // them.
  FreeState find_free_state(Positions q, Workspace &workspace, const RecoveryOptions &options = {}) const {
    const auto locked = detail::pointers(options.locked);
    const clearance_recovery_options c_options = {options.max_distance, options.clearance, options.max_checks,
                                                  options.timeout,      locked.data(),     locked.size()};
    clearance_free_state found;
    detail::check(
        clearance_checker_find_free_state(valid(), valid(workspace), q.state(), &c_options, &found));
    FreeState result{found.is_found, detail::text(found.reason), {}, found.distance, found.exit,
                     detail::pair(found.pair), found.checks};
    if (found.is_found) {
      result.positions.assign(found.positions, found.positions + found.n);
    }
    return result;
  }

  const clearance_checker *handle() const noexcept { return handle_.get(); }

 private:
  explicit Checker(clearance_checker *handle) : handle_(handle, clearance_checker_free) {}

  const clearance_checker *valid() const { return detail::valid(handle(), "checker"); }
  static clearance_workspace *valid(Workspace &workspace) { return detail::valid(workspace.handle(), "workspace"); }

  static clearance_checker *made(const Robot &robot, const clearance_world *world, const CheckerOptions &options) {
    const detail::COptions c_options(options);
    return detail::make<clearance_checker>([&](clearance_checker **checker) {
      return clearance_checker_new(detail::valid(robot.handle(), "robot"), world, c_options.get(), checker);
    });
  }

  Checker attached(std::string_view object, std::string_view link, const clearance_pose *pose, Positions q,
                   const std::vector<std::string> &touch_links) const {
    const std::string name = detail::terminated(object), link_name = detail::terminated(link);
    const auto links = detail::pointers(touch_links);
    const clearance_grasp grasp = {name.c_str(), link_name.c_str(), pose, q.state(), links.data(), links.size()};
    return Checker(detail::make<clearance_checker>(
        [&](clearance_checker **made) { return clearance_checker_attach(valid(), &grasp, made); }));
  }

  static std::string shape(const States &states) {
    return std::to_string(states.count()) + " states of " + std::to_string(states.n()) + " positions";
  }

  static clearance_edge edge(Positions from, Positions to) {
    if (from.size() != to.size()) {
      throw Error(CLEARANCE_STATUS_ARGUMENT, "the two states need the same number of positions, but they have " +
                                                 std::to_string(from.size()) + " and " + std::to_string(to.size()));
    }
    return {from.data(), to.data(), from.size()};
  }

  static PairDistance pair_distance(const clearance_pair_distance &found) {
    return {detail::pair(found.pair), found.distance, {detail::xyz(found.points[0]), detail::xyz(found.points[1])}};
  }

  static Report report(const clearance_report &found) {
    Report report{found.is_free, found.self_collision, found.world_collision, {}, {}, {}};
    for (std::size_t i = 0; i < found.colliding_pair_count; ++i) {
      report.colliding_pairs.emplace_back(found.colliding_pairs[i].a, found.colliding_pairs[i].b);
    }
    for (std::size_t i = 0; i < found.contact_count; ++i) {
      const clearance_contact &contact = found.contacts[i];
      report.contacts.push_back({Pair(contact.pair.a, contact.pair.b), detail::xyz(contact.point),
                                 detail::xyz(contact.normal), contact.depth, contact.depth_lower, contact.is_deepest});
    }
    for (std::size_t i = 0; i < found.distance_count; ++i) {
      report.distances.push_back(pair_distance(found.distances[i]));
    }
    return report;
  }

  static std::optional<Certificate> certificate(clearance_certificate *handle) {
    return handle == nullptr ? std::nullopt : std::optional<Certificate>(Certificate(handle));
  }

  static LeastDistance least_distance(const clearance_least_distance &found) {
    return {found.lower,
            found.upper,
            detail::pair(found.pair),
            {detail::xyz(found.points[0]), detail::xyz(found.points[1])},
            found.t,
            found.segment,
            found.time};
  }

  static MotionDistances motion_distances(const clearance_motion_distances &found) {
    return {least_distance(found.nearest_self), least_distance(found.nearest_world), found.reason, found.evaluations};
  }

  static MotionReport motion_report(const clearance_motion_report &found) {
    return {static_cast<Verdict>(found.verdict),
            found.reason,
            {found.t[0], found.t[1]},
            detail::pair(found.pair),
            {found.distance[0], found.distance[1]},
            detail::xyz(found.point),
            found.segment,
            {found.time[0], found.time[1]},
            found.evaluations,
            certificate(found.certificate)};
  }

  std::shared_ptr<clearance_checker> handle_;
};

inline Workspace::Workspace(const Checker &checker)
    : handle_(detail::make<clearance_workspace>(
          [&](clearance_workspace **made) {
            return clearance_workspace_new(detail::valid(checker.handle(), "checker"), made);
          })) {}

// Version of the library that is linked.
inline std::string version() { return clearance_version(); }

}  // namespace clearance

#endif  // CLEARANCE_HPP
