// Straight motions in joint space, and the states at which they are looked at.
#pragma once
#include <cmath>
#include <deque>

#include "neutral.hpp"

namespace neutral {

struct Edge {
  State from, to;

  // Into how many equal steps it is cut so that none is longer than `step`.
  size_t steps(double step) const {
    double squares = 0;
    for (size_t k = 0; k < from.size(); ++k) squares += (to[k] - from[k]) * (to[k] - from[k]);
    return std::max(1.0, std::ceil(std::sqrt(squares) / step - 1e-9));
  }

  void at(double t, State& q) const {
    q.resize(from.size());
    for (size_t k = 0; k < q.size(); ++k) q[k] = from[k] + t * (to[k] - from[k]);
  }
};

using Edges = std::map<std::string, std::vector<Edge>>;

inline Edges edges(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot open " + file);
  const auto state = [&in] {
    std::string line;
    std::getline(in, line);
    State s;
    for (const auto& word : words(line)) s.push_back(number(word));
    return s;
  };
  Edges out;
  for (std::string head; std::getline(in, head);) {
    const auto w = words(head);
    if (w[0] != "edges") throw std::runtime_error(file + ": no edges in '" + head + "'");
    auto& set = out[w.at(1)];
    for (size_t n = std::stoul(w.at(2)); n > 0; --n) {
      State from = state();
      set.push_back({std::move(from), state()});
    }
  }
  return out;
}

// 0 to `steps` one after the other.
inline std::vector<size_t> in_turn(size_t steps) {
  std::vector<size_t> out;
  for (size_t i = 0; i <= steps; ++i) out.push_back(i);
  return out;
}

// The ends, then the middles of ever shorter pieces: van der Corput's order, which finds a hit somewhere soonest. The
// end first, for it is the start of which planners know that it is free.
inline std::vector<size_t> van_der_corput(size_t steps) {
  std::vector<size_t> out{steps, 0};
  std::deque<std::pair<size_t, size_t>> pieces{{0, steps}};
  for (; !pieces.empty(); pieces.pop_front()) {
    const auto [low, high] = pieces.front();
    const size_t middle = (low + high) / 2;
    if (middle == low) continue;
    out.push_back(middle);
    pieces.emplace_back(low, middle);
    pieces.emplace_back(middle, high);
  }
  return out;
}

}  // namespace neutral
