#pragma once

#include <array>
#include <string>

#include <pugixml.hpp>

namespace sextant::reports {

/// Attributes with counts of test cases, of a suite and of a file.
inline constexpr std::array junit_counts{"tests", "failures", "errors", "skipped"};

/// A time as JUnit has it; 0 for none. [s]
[[nodiscard]] std::string junit_seconds(double time_s);

/// Appends an attribute, with what XML can hold of its value.
void append_attribute(pugi::xml_node node, const char* name, const std::string& value);

/// A JUnit test suite while its cases are added.
class JUnitSuite {
 public:
  /// Makes the node a suite without cases, whatever it was.
  JUnitSuite(pugi::xml_node node, const std::string& name, double time_s);

  void add_property(const char* name, const std::string& value);

  /// A case that passes, until one of the functions below says otherwise.
  pugi::xml_node add(const std::string& name, double time_s = 0);

  void fail(pugi::xml_node test, const std::string& type, const std::string& message);
  void error(pugi::xml_node test, const std::string& type, const std::string& message);
  void skip(pugi::xml_node test, const std::string& message);

 private:
  pugi::xml_node report(pugi::xml_node test, const char* kind, const char* count, const std::string& message);
  void count(const char* name);

  pugi::xml_node node_;
  pugi::xml_node properties_;
};

}  // namespace sextant::reports
