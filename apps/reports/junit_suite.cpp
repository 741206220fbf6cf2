#include "reports/junit_suite.hpp"

#include <cmath>

#include <fmt/format.h>

#include "reports/xml_text.hpp"

namespace sextant::reports {

std::string junit_seconds(double time_s) {
  return fmt::format("{:.6f}", std::isfinite(time_s) ? time_s : 0.0);
}

void append_attribute(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(xml_text(value).c_str());
}

JUnitSuite::JUnitSuite(pugi::xml_node node, const std::string& name, double time_s) : node_{node} {
  node_.remove_attributes();
  node_.remove_children();
  append_attribute(node_, "name", name);
  for (const char* count : junit_counts) node_.append_attribute(count) = 0;
  append_attribute(node_, "time", junit_seconds(time_s));
}

void JUnitSuite::add_property(const char* name, const std::string& value) {
  if (!properties_) properties_ = node_.prepend_child("properties");
  pugi::xml_node property = properties_.append_child("property");
  append_attribute(property, "name", name);
  append_attribute(property, "value", value);
}

pugi::xml_node JUnitSuite::add(const std::string& name, double time_s) {
  pugi::xml_node test = node_.append_child("testcase");
  append_attribute(test, "classname", node_.attribute("name").value());
  append_attribute(test, "name", name);
  append_attribute(test, "time", junit_seconds(time_s));
  count("tests");
  return test;
}

void JUnitSuite::fail(pugi::xml_node test, const std::string& type, const std::string& message) {
  append_attribute(report(test, "failure", "failures", message), "type", type);
}

void JUnitSuite::error(pugi::xml_node test, const std::string& type, const std::string& message) {
  append_attribute(report(test, "error", "errors", message), "type", type);
}

void JUnitSuite::skip(pugi::xml_node test, const std::string& message) {
  report(test, "skipped", "skipped", message);
}

pugi::xml_node JUnitSuite::report(pugi::xml_node test, const char* kind, const char* count,
                                  const std::string& message) {
  pugi::xml_node result = test.append_child(kind);
  append_attribute(result, "message", message);
  this->count(count);
  return result;
}

void JUnitSuite::count(const char* name) {
  pugi::xml_attribute attribute = node_.attribute(name);
  attribute = attribute.as_int() + 1;
}

}  // namespace sextant::reports
