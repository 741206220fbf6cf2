#include "ecu/telemetry/dds_settings.hpp"

#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>

#include "support/source_directory.hpp"

namespace sextant::ecu {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

std::string loopback_file() {
  std::ifstream file{SEXTANT_SOURCE_DIR "/configs/cyclonedds_loopback.xml"};
  std::string text{std::istreambuf_iterator<char>{file}, {}};
  text.erase(text.find_last_not_of('\n') + 1);
  return text;
}

TEST(DdsSettings, WithoutAnyWordTheLoopbackInterfaceAsTheScriptsHaveIt) {
  const DdsSettings settings = dds_settings({}, nullptr);
  EXPECT_THAT(settings.configuration, EndsWith("," + loopback_file()));
  EXPECT_THAT(settings.source, HasSubstr("the default"));
}

TEST(DdsSettings, TheEnvironmentDecidesWhereTheFileIsSilent) {
  const DdsSettings settings = dds_settings({}, "file:///own.xml");
  EXPECT_THAT(settings.configuration, EndsWith(",file:///own.xml"));
  EXPECT_THAT(settings.configuration, Not(HasSubstr("127.0.0.1")));
  EXPECT_EQ(settings.source, "the environment, CYCLONEDDS_URI=file:///own.xml");
}

TEST(DdsSettings, AnEmptyEnvironmentIsTheLibrarysDefault) {
  const DdsSettings settings = dds_settings({}, "");
  EXPECT_THAT(settings.configuration, Not(HasSubstr("127.0.0.1")));
  EXPECT_THAT(settings.configuration, EndsWith("</CycloneDDS>"));
}

TEST(DdsSettings, TheFileHasTheLastWord) {
  const DdsSettings settings = dds_settings({.config_uri = "file:///mine.xml"}, "file:///own.xml");
  EXPECT_THAT(settings.configuration, EndsWith(",file:///mine.xml"));
  EXPECT_EQ(settings.source, "dds.config_uri = \"file:///mine.xml\"");
}

}  // namespace
}  // namespace sextant::ecu
