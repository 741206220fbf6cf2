#include "sextant/config/moved_keys.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_files.hpp"
#include "sextant/config/load_config.hpp"

namespace sextant {
namespace {

using ::testing::HasSubstr;

/// A whole table has moved.
bool is_table(const MovedKey& moved) {
  return moved.from.find('.') == std::string_view::npos;
}

TEST(MovedKeys, AreEachNamedWithTheirNewPlace) {
  ASSERT_GE(moved_keys().size(), 12U);
  const ConfigFiles files;
  for (const MovedKey& moved : moved_keys()) {
    const std::string from{moved.from};
    SCOPED_TRACE(from);
    const std::string sentence = from + ": moved to " + std::string{moved.to};
    const std::string key = is_table(moved) ? from + ".timeout_ms" : from;
    const std::string file =
        files.write("old.toml", "machine = \"" + shipped_machine + "\"\n" + key + " = 1\n");
    EXPECT_EQ(ecu_refusal(file), file + ":2: " + sentence);
    EXPECT_EQ(ecu_refusal(shipped_ecu, {key + "=1"}), "--set: " + sentence);
  }
}

TEST(MovedKeys, LeadToKeysThatThereAre) {
  EcuConfig config;
  Schema schema;
  describe(Section{schema}, config);
  for (const MovedKey& moved : moved_keys()) {
    int found = 0;
    for (const Field& field : schema.fields) {
      found += field.path == moved.to || field.path.starts_with(std::string{moved.to} + ".") ? 1 : 0;
      EXPECT_NE(field.path, moved.from) << "a key cannot have moved and be there";
    }
    EXPECT_GT(found, 0) << moved.to;
  }
}

TEST(MovedKeys, OfAnotherKindOfFileAreUnknown) {
  try {
    (void)load_plant_config(shipped_plant, {"control.period_us=25"});
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--set: control: unknown key; the nearest known one is"));
  }
}

}  // namespace
}  // namespace sextant
