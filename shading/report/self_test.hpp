// Whether this build on this machine gives the bits every build must give: a small fixed picture rendered
// with each thread count, and its hash held against the one recorded for this version.
#pragma once

#include <string>

namespace aluminate::report {

struct SelfTest {
  bool passed = false;
  std::string text;  // lines for people: versions, CPU, threads, hashes
};

SelfTest self_test();

}  // namespace aluminate::report
