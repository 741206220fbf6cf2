#include "sextant/files/text_lines.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/text_files.hpp"

namespace sextant {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> lines_of(const std::string& file) {
  TextLines lines{file};
  std::vector<std::string> all;
  for (std::string line; lines.next(line);) {
    all.push_back(line);
    EXPECT_EQ(lines.number(), static_cast<int>(all.size()));
  }
  return all;
}

TEST(TextLines, GivesEachLineOnceWithoutItsEnd) {
  const TextFiles files;
  EXPECT_THAT(lines_of(files.write("a", "one\n\n three \r\nfour")),
              ElementsAre("one", "", " three ", "four"));
  EXPECT_THAT(lines_of(files.write("a", "one\r\rthree\r")), ElementsAre("one", "", "three"));
  EXPECT_THAT(lines_of(files.write("a", "\xef\xbb\xbfone\n\xef\xbb\xbf")),
              ElementsAre("one", "\xef\xbb\xbf"));
  EXPECT_THAT(lines_of(files.write("a", "one\n")), ElementsAre("one"));
  EXPECT_THAT(lines_of(files.write("a", "\n")), ElementsAre(""));
  EXPECT_THAT(lines_of(files.write("a", "")), ElementsAre());
  EXPECT_THAT(lines_of(files.write("a", std::string{"a\0b\nc", 5})),
              ElementsAre(std::string{"a\0b", 3}, "c"));
}

TEST(TextLines, ALineHasItsLongestLength) {
  const TextFiles files;
  const std::string longest(TextLines::longest_line, 'x');
  EXPECT_THAT(lines_of(files.write("a", longest)), ElementsAre(longest));
  EXPECT_THAT(lines_of(files.write("a", "1\n" + longest + "\n3")), ElementsAre("1", longest, "3"));
  const std::string file = files.write("a", "1\n" + longest + "x\n3\n");
  EXPECT_EQ(refusal([&file] { (void)lines_of(file); }),
            file + ":2: the line is longer than 4096 bytes; is it a text file?");
}

TEST(TextLines, APipeWithoutALineEndsEarly) {
  const TextFiles files;
  const std::string file = files.path("pipe");
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  std::thread writer{[&file] { std::ofstream{file} << std::string(TextLines::longest_line + 1, '\0'); }};
  EXPECT_THAT(refusal([&file] { (void)lines_of(file); }), HasSubstr(":1: the line is longer than"));
  writer.join();
}

TEST(TextLines, APipeIsReadToItsEnd) {
  const TextFiles files;
  const std::string file = files.path("pipe");
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  std::thread writer{[&file] { std::ofstream{file} << "one\ntwo\n"; }};
  EXPECT_THAT(lines_of(file), ElementsAre("one", "two"));
  writer.join();
}

TEST(TextLines, ThereAreNotMoreLinesThanAReaderHasRoomFor) {
  const TextFiles files;
  const std::string file = files.write("a", std::string(std::size_t{TextLines::most_lines} + 1, '\n'));
  TextLines lines{file};
  std::string line;
  while (lines.number() < TextLines::most_lines) ASSERT_TRUE(lines.next(line));
  EXPECT_EQ(refusal([&] { (void)lines.next(line); }),
            file + ":10000001: more than 10000000 lines; cut the file");
}

TEST(TextLines, DevicesAndDirectoriesAreNoTextFiles) {
  const TextFiles files;
  for (const char* device : {"/dev/zero", "/dev/null", "/dev/full"}) {
    EXPECT_EQ(refusal([device] { (void)lines_of(device); }),
              std::string{device} + " cannot be read: it is a device; name a file or a pipe");
  }
  EXPECT_EQ(refusal([&files] { (void)lines_of(files.path("")); }),
            files.path("") + " cannot be read: it is a directory");
  EXPECT_EQ(refusal([&files] { (void)lines_of(files.path("none")); }),
            files.path("none") + " cannot be read: No such file or directory");
  EXPECT_EQ(why_unreadable(files.write("a", "")), "");
}

TEST(TextLines, AnErrorOfReadingIsNoEndOfTheFile) {
  // Its first byte is at address zero, where nothing can be read.
  EXPECT_EQ(refusal([] { (void)lines_of("/proc/self/mem"); }),
            "/proc/self/mem cannot be read to its end: an error behind line 0");
}

}  // namespace
}  // namespace sextant
