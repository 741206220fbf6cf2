#include "dds_configuration.hpp"

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "support/source_directory.hpp"

namespace sextant {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string refusal(const std::string& configuration) {
  try {
    check_dds_configuration(configuration);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

/// A file that lives as long as this.
class ConfigurationFile {
 public:
  explicit ConfigurationFile(const std::string& text) { std::ofstream{path_} << text; }
  ConfigurationFile(const ConfigurationFile&) = delete;
  ConfigurationFile& operator=(const ConfigurationFile&) = delete;
  ~ConfigurationFile() { std::filesystem::remove(path_); }

  [[nodiscard]] std::string uri() const { return "file://" + path_.string(); }

 private:
  std::filesystem::path path_{std::filesystem::temp_directory_path() /
                              ("sextant_dds_" + std::to_string(getpid()) + ".xml")};
};

TEST(DdsConfiguration, TakesWhatCycloneDdsDocuments) {
  for (const char* const good :
       {"", " , ", "<CycloneDDS/>", "<CycloneDDS><Domain Id=\"any\"/></CycloneDDS>",
        "<!-- of this machine --><CycloneDDS>\n<Domain>\n</Domain>\n</CycloneDDS>\n",
        "<General><AllowMulticast>false</></>", "<Tracing><V>fine</V></Tracing>,<General/>,<Discovery></>",
        "<A/><B/>", "file:///no/such/file.xml", "<A/>,file:///no/such/file.xml,<B></B>",
        "file://" SEXTANT_SOURCE_DIR "/configs/cyclonedds_loopback.xml"}) {
    EXPECT_EQ(refusal(good), "") << good;
  }
}

TEST(DdsConfiguration, RefusesWhatIsNotClosed) {
  for (const char* const bad :
       {"<CycloneDDS><Domain>", "<CycloneDDS><Domain></>", "<CycloneDDS><Domain>, <A/>",
        "<A/>,<CycloneDDS><Domain", "<A></A>,<General><AllowMulticast>false</>"}) {
    EXPECT_THAT(refusal(bad), HasSubstr("no well-formed XML")) << bad;
  }
  EXPECT_THAT(refusal("<A/>,<CycloneDDS>\n<Domain>"),
              AllOf(HasSubstr("\"<CycloneDDS>\""), HasSubstr("line 2: <Domain> is not closed")));
}

TEST(DdsConfiguration, RefusesWhatIsNoXml) {
  for (const char* const bad : {"<A></B>", "<A b></A>", "<A>&nonsense;</A>", "<", "<>", "</>", "</A>"}) {
    EXPECT_THAT(refusal(bad), HasSubstr("no well-formed XML")) << bad;
  }
}

TEST(DdsConfiguration, NamesTheFileAndTheLine) {
  const ConfigurationFile file{"<CycloneDDS>\n<Domain>\n"};
  EXPECT_THAT(refusal("<A/>," + file.uri()),
              AllOf(HasSubstr(file.uri()), HasSubstr("<Domain> is not closed"), HasSubstr("line 3")));
  const ConfigurationFile closed_anonymously{"<CycloneDDS></>"};
  EXPECT_THAT(refusal(closed_anonymously.uri()), HasSubstr("line 1"));
}

TEST(DdsConfiguration, RefusesAFileWithoutEnd) {
  EXPECT_THAT(refusal("file:///dev/zero"), HasSubstr("more than 1 MiB"));
}

}  // namespace
}  // namespace sextant
