// The protocol of README.md, spoken by a contestant on standard input and output.
#pragma once
#include <time.h>

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include "neutral.hpp"

namespace protocol {

inline long long cpu_nanoseconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec * 1000000000LL + t.tv_nsec;
}

// Keeps the compiler from dropping work whose answer nobody reads.
template <class T>
void keep(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

// The answer to a line. A contestant is made from a file, takes others, and is asked questions about sets of states.
template <class Contestant>
std::string reply(const std::vector<std::string>& w, std::unique_ptr<Contestant>& contestant) {
  if (w[0] == "load") {
    contestant = std::make_unique<Contestant>(w.at(1));
    return "ok\t";
  }
  if (!contestant) throw std::runtime_error("nothing is loaded");
  bool known = true;
  std::string out;
  if (w[0] == "pass") {
    const long long start = cpu_nanoseconds();
    for (long n = std::stol(w.at(3)); n > 0 && known; --n)
      known = contestant->ask(w.at(1), w.at(2), [](const auto& answer) { keep(answer); });
    out = "\t" + std::to_string(cpu_nanoseconds() - start);
  } else if (w[0] == "answers") {
    known = contestant->ask(w.at(1), w.at(2), [&](const auto& answer) { out += "\t" + contestant->say(answer); });
  } else {
    known = w.size() == 2 && contestant->take(w[0], w[1]);
    out = "\t";
  }
  return known ? "ok" + out : "unsupported";
}

template <class Contestant>
int serve() {
  std::unique_ptr<Contestant> contestant;
  for (std::string line; std::getline(std::cin, line);) {
    try {
      std::cout << reply(neutral::words(line), contestant) << std::endl;
    } catch (const std::exception& e) {
      std::cout << "error\t" << e.what() << std::endl;
    }
  }
  return 0;
}

}  // namespace protocol
