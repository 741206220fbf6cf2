#include "sextant/files/replace_file.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sextant {
namespace {

namespace fs = std::filesystem;

class ReplaceFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "sextant_replace_XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] static std::string read(const fs::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
  }

  fs::path folder_;
};

TEST_F(ReplaceFile, WritesAndReplacesTheWholeFileAndLeavesNothingElse) {
  const fs::path file = folder_ / "report.xml";
  replace_file(file, "a longer first text", "the report");
  replace_file(file, "short", "the report");
  EXPECT_EQ(read(file), "short");
  EXPECT_EQ(std::distance(fs::directory_iterator{folder_}, {}), 1);
}

TEST_F(ReplaceFile, AReaderKeepsTheOldFile) {
  const fs::path file = folder_ / "report.xml";
  replace_file(file, "old", "the report");
  std::ifstream reader{file};
  replace_file(file, "new", "the report");
  EXPECT_EQ((std::string{std::istreambuf_iterator<char>{reader}, {}}), "old");
}

TEST_F(ReplaceFile, ALinkIsReplacedNotFollowed) {
  replace_file(folder_ / "target", "kept", "the report");
  fs::create_symlink(folder_ / "target", folder_ / "link");
  replace_file(folder_ / "link", "new", "the report");
  EXPECT_EQ(read(folder_ / "target"), "kept");
  EXPECT_EQ(read(folder_ / "link"), "new");
}

TEST_F(ReplaceFile, RefusesInASentenceAndLeavesNothing) {
  const auto refuse = [&](const fs::path& file, const char* reason) {
    EXPECT_THAT(
        [&] { replace_file(file, "text", "the report"); },
        testing::ThrowsMessage<std::runtime_error>(file.string() + ": cannot write the report: " + reason));
  };
  refuse(folder_ / "missing" / "report.xml", "No such file or directory");
  fs::create_directories(folder_ / "directory" / "with_content");
  refuse(folder_ / "directory", "Is a directory");
  EXPECT_EQ(std::distance(fs::directory_iterator{folder_}, {}), 1);
}

}  // namespace
}  // namespace sextant
