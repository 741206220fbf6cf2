#include "sextant/files/replace_file.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

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

TEST_F(ReplaceFile, ALinkStaysAndItsTargetIsReplaced) {
  fs::create_directory(folder_ / "far");
  fs::create_symlink(fs::path{"far"} / "target", folder_ / "link");
  for (const char* text : {"made", "replaced"}) {
    replace_file(folder_ / "link", text, "the report");
    EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
    EXPECT_EQ(read(folder_ / "far" / "target"), text);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator{folder_ / "far"}, {}), 1);
}

TEST_F(ReplaceFile, ThePermissionsOfTheOldFileAreKept) {
  const fs::path file = folder_ / "report.xml";
  replace_file(file, "old", "the report");
  const fs::perms owner = fs::perms::owner_read | fs::perms::owner_write;
  for (const fs::perms permissions : {owner, owner | fs::perms::group_read | fs::perms::group_write}) {
    fs::permissions(file, permissions);
    replace_file(file, "new", "the report");
    EXPECT_EQ(fs::status(file).permissions(), permissions);
  }
}

TEST_F(ReplaceFile, APipeIsWrittenIntoAndStays) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  replace_file(pipe, "text", "the report");
  std::string text(10, '\0');
  const ssize_t length = ::read(reader, text.data(), text.size());
  ::close(reader);
  EXPECT_EQ(text.substr(0, std::size_t(std::max<ssize_t>(length, 0))), "text");
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(std::distance(fs::directory_iterator{folder_}, {}), 1);
}

TEST_F(ReplaceFile, ALinkToAPipeWithoutANameIsWrittenIntoAndStays) {
  int ends[2]{};
  ASSERT_EQ(::pipe(ends), 0);
  const fs::path link = folder_ / "link";
  fs::create_symlink("/proc/self/fd/" + std::to_string(ends[1]), link);
  replace_file(link, "text", "the report");
  ::close(ends[1]);
  std::string text(10, '\0');
  EXPECT_EQ(::read(ends[0], text.data(), text.size()), 4);
  ::close(ends[0]);
  EXPECT_TRUE(fs::is_symlink(link));
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
  fs::create_symlink("ring", folder_ / "ring");
  refuse(folder_ / "ring", "Too many levels of symbolic links");
  EXPECT_EQ(std::distance(fs::directory_iterator{folder_}, {}), 2);
}

}  // namespace
}  // namespace sextant
