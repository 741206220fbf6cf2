#include "sextant/files/resolved_path.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "support/text_files.hpp"

namespace sextant {
namespace {

namespace fs = std::filesystem;

class ResolvedPath : public testing::Test {
 protected:
  /// A file of the directory, which may itself be reached over a link.
  [[nodiscard]] fs::path path(const std::string& name) const { return fs::canonical(files_.path("")) / name; }

  TextFiles files_;
};

TEST_F(ResolvedPath, OfWhatIsNotThereYet) {
  EXPECT_EQ(resolved_path(path("new") / ".." / "file"), path("file"));
  EXPECT_EQ(resolved_path("no such file"), fs::canonical(fs::current_path()) / "no such file");
}

TEST_F(ResolvedPath, FollowsLinksAlsoToWhatIsNotThereYet) {
  fs::create_symlink("second", path("first"));
  fs::create_symlink(path("target"), path("second"));
  EXPECT_EQ(resolved_path(path("first")), path("target"));
  (void)files_.write("target", "");
  EXPECT_EQ(resolved_path(path("first")), path("target"));
}

TEST_F(ResolvedPath, IsThePathWhereItCannotBeResolved) {
  fs::create_symlink("ring", path("ring"));
  EXPECT_EQ(resolved_path(path("ring")), path("ring"));
}

}  // namespace
}  // namespace sextant
