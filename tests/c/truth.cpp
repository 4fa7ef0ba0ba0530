// The C++ interface against the Rust library: every number is the same, alone, in batches and on many threads that share a checker.
// The first argument is a file with the results of the Rust library.

#include <clearance.hpp>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "checks.h"

namespace {

// A word of the file: a number with all digits, a name, or - for none.
std::string word(std::istream &file) {
  std::string text;
  if (!(file >> text)) {
    throw std::runtime_error("the file of results ends early");
  }
  return text;
}

double number(std::istream &file) { return std::strtod(word(file).c_str(), nullptr); }

std::vector<double> numbers(std::istream &file, std::size_t count) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(number(file));
  }
  return values;
}

std::optional<clearance::Pair> pair(std::istream &file) {
  const std::string a = word(file), b = word(file);
  return a == "-" ? std::nullopt : std::optional<clearance::Pair>(clearance::Pair(a, b));
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

struct StateTruth {
  std::vector<double> q;
  bool is_free;
  double self_distance, world_distance;
  std::optional<clearance::Pair> self_pair, world_pair;
};

struct EdgeTruth {
  std::vector<double> from, to;
  int verdict;
  double t[2];
  std::optional<clearance::Pair> pair;
};

struct Truth {
  std::size_t n = 0;
  std::vector<StateTruth> states;
  std::vector<EdgeTruth> edges;
  std::vector<double> rows, from_rows, to_rows;

  explicit Truth(std::istream &file) {
    n = std::stoul(word(file));
    const std::size_t state_count = std::stoul(word(file)), edge_count = std::stoul(word(file));
    for (std::size_t i = 0; i < state_count; ++i) {
      StateTruth state;
      state.q = numbers(file, n);
      state.is_free = word(file) == "true";
      state.self_distance = number(file);
      state.self_pair = pair(file);
      state.world_distance = number(file);
      state.world_pair = pair(file);
      rows.insert(rows.end(), state.q.begin(), state.q.end());
      states.push_back(state);
    }
    for (std::size_t i = 0; i < edge_count; ++i) {
      EdgeTruth edge;
      edge.from = numbers(file, n);
      edge.to = numbers(file, n);
      edge.verdict = std::stoi(word(file));
      edge.t[0] = number(file);
      edge.t[1] = number(file);
      edge.pair = pair(file);
      from_rows.insert(from_rows.end(), edge.from.begin(), edge.from.end());
      to_rows.insert(to_rows.end(), edge.to.begin(), edge.to.end());
      edges.push_back(edge);
    }
  }
};

// Number of results that differ from the truth, one by one.
std::size_t differences(const clearance::Checker &checker, const Truth &truth) {
  clearance::Workspace workspace(checker);
  std::size_t different = 0;
  for (const StateTruth &state : truth.states) {
    const auto near = checker.distance(state.q, workspace, 0.3);
    const bool agrees = checker.is_free(state.q, workspace) == state.is_free && near.self.distance == state.self_distance &&
                        near.self.pair == state.self_pair && near.world.distance == state.world_distance &&
                        near.world.pair == state.world_pair &&
                        checker.check(state.q, workspace).is_free == state.is_free;
    different += agrees ? 0 : 1;
  }
  for (const EdgeTruth &edge : truth.edges) {
    const auto report = checker.check_motion(edge.from, edge.to, workspace);
    const bool agrees = static_cast<int>(report.verdict) == edge.verdict && same(report.t[0], edge.t[0]) &&
                        same(report.t[1], edge.t[1]) && report.pair == edge.pair &&
                        checker.is_motion_free(edge.from, edge.to, workspace) == (edge.verdict == 1);
    different += agrees ? 0 : 1;
  }
  return different;
}

void check_batches(const clearance::Checker &checker, const Truth &truth) {
  clearance::Workspace workspace(checker);
  for (const std::size_t threads : {std::size_t{1}, std::size_t{2}, std::size_t{0}}) {
    const auto free = checker.are_free(clearance::States(truth.rows, truth.n), workspace, threads);
    clearance::MotionOptions options;
    options.threads = threads;
    const clearance::States from(truth.from_rows, truth.n), to(truth.to_rows, truth.n);
    const auto free_motions = checker.are_motions_free(from, to, workspace, options);
    CHECK(free.size() == truth.states.size() && free_motions.size() == truth.edges.size());
    for (std::size_t i = 0; i < free.size(); ++i) {
      CHECK(free[i] == (truth.states[i].is_free ? 1 : 0));
    }
    for (std::size_t i = 0; i < free_motions.size(); ++i) {
      CHECK(free_motions[i] == (truth.edges[i].verdict == 1 ? 1 : 0));
    }
  }
}

// Threads that share a checker and have their own workspaces; then threads that wrongly share a workspace get errors, no wrong results.
void check_threads(const clearance::Checker &checker, const Truth &truth) {
  std::vector<std::size_t> different(4, 1);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < different.size(); ++i) {
    threads.emplace_back([&, i] { different[i] = differences(checker, truth); });
  }
  for (std::thread &thread : threads) {
    thread.join();
  }
  for (const std::size_t count : different) {
    CHECK(count == 0);
  }

  clearance::Workspace shared(checker);
  std::vector<std::size_t> wrong(2, 1);
  threads.clear();
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    threads.emplace_back([&, i] {
      wrong[i] = 0;
      for (const StateTruth &state : truth.states) {
        try {
          wrong[i] += checker.is_free(state.q, shared) == state.is_free ? 0 : 1;
        } catch (const clearance::Error &error) {
          const bool names_it = std::string(error.what()).find("each thread needs a workspace") != std::string::npos;
          wrong[i] += names_it && error.status() == CLEARANCE_STATUS_ARGUMENT ? 0 : 1;
        }
      }
    });
  }
  for (std::thread &thread : threads) {
    thread.join();
  }
  CHECK(wrong[0] == 0 && wrong[1] == 0);
}

// The last error is one of each thread.
void check_error_threads() {
  CHECK(clearance_robot_joint_count(nullptr) == 0);
  const std::string here = clearance_last_error();
  std::string there = "not empty";
  std::thread([&] { there = clearance_last_error(); }).join();
  CHECK(there.empty());
  CHECK(here == clearance_last_error());
}

}  // namespace

int main(int count, char **arguments) {
  try {
    std::ifstream file(count > 1 ? arguments[1] : "");
    const Truth truth(file);
    const auto robot = clearance::Robot::from_urdf("urdf/demo_arm/demo_arm.urdf", "urdf/demo_arm/demo_arm.srdf");
    clearance::CheckerOptions options;
    options.group = "arm";
    options.padding = 0.01;
    const clearance::Checker checker(robot, clearance::World::from_file("config/demo_world.yaml", robot), options);
    CHECK(checker.size() == truth.n);
    CHECK(differences(checker, truth) == 0);
    check_batches(checker, truth);
    check_threads(checker, truth);
    check_error_threads();
  } catch (const std::exception &error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  std::cout << failed_checks << " checks failed\n";
  return failed_checks == 0 ? 0 : 1;
}
