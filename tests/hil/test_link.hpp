#pragma once

#include <atomic>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

#include "sextant/hil/hil_parameters.hpp"

namespace sextant::test {

/// Parameters of a link with a name that no other test has at the same time; its memory is removed at the
/// end.
class TestLink {
 public:
  TestLink() {
    static std::atomic<int> count{0};
    parameters.link = "sextant_test_" + std::to_string(getpid()) + "_" + std::to_string(++count);
  }
  TestLink(const TestLink&) = delete;
  TestLink& operator=(const TestLink&) = delete;
  ~TestLink() { shm_unlink(path().c_str()); }

  [[nodiscard]] std::string path() const { return "/" + parameters.link; }

  HilParameters parameters{};
};

}  // namespace sextant::test
