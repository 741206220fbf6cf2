#include "sextant/realtime/processor_latency.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace sextant {
namespace {

class ProcessorLatencyTest : public testing::Test {
 protected:
  ProcessorLatencyTest() { std::ofstream{path} << "xxxxyyyy"; }
  ~ProcessorLatencyTest() override { std::filesystem::remove(path); }

  [[nodiscard]] std::string content() const {
    std::ifstream file{path, std::ios::binary};
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::string path{testing::TempDir() + "processor_latency." + std::to_string(getpid())};
};

TEST_F(ProcessorLatencyTest, AsksForZeroMicrosecondsAsABinaryNumber) {
  const ProcessorLatency request{true, path};
  EXPECT_TRUE(request.granted());
  EXPECT_EQ(content(), std::string(4, '\0') + "yyyy");
}

TEST_F(ProcessorLatencyTest, AsksForNothingWhereItIsNotWanted) {
  const ProcessorLatency request{false, path};
  EXPECT_FALSE(request.granted());
  EXPECT_EQ(content(), "xxxxyyyy");
}

TEST_F(ProcessorLatencyTest, AMachineWithoutTheFileIsNoError) {
  const ProcessorLatency request{true, path + ".absent"};
  EXPECT_FALSE(request.granted());
}

}  // namespace
}  // namespace sextant
