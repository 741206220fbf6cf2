#include "expected.hpp"

#include "number_text.hpp"

namespace sextant {
namespace {

std::string range_text(Range<double> r) {
  return number_text(r.min) + " to " + number_text(r.max);
}

struct Expected {
  std::string operator()(const NumberField& f) const { return "a number from " + range_text(f.range); }
  std::string operator()(const IntegerField& f) const {
    return "an integer from " + std::to_string(f.range.min) + " to " + std::to_string(f.range.max);
  }
  std::string operator()(const FlagField&) const { return "true or false"; }
  std::string operator()(const TextField& f) const {
    return f.may_be_empty ? "a string" : "a string, not empty";
  }
  std::string operator()(const ChoiceField& f) const {
    std::string text;
    for (const std::string& name : f.names) text += (text.empty() ? "\"" : " or \"") + name + "\"";
    return text;
  }
  std::string operator()(const PointsField& f) const {
    return "a list of [" + f.first_name + ", " + f.second_name + "] pairs, " + f.first_name + " from " +
           range_text(f.first_range) + ", " + f.second_name + " from " + range_text(f.second_range);
  }
  std::string operator()(const FileField& f) const {
    return "the path of a CSV file with the columns " + f.columns;
  }
  std::string operator()(const NamesField& f) const { return "a list, not empty, of " + f.what; }
};

}  // namespace

std::string expected(const FieldKind& kind) {
  return std::visit(Expected{}, kind);
}

}  // namespace sextant
