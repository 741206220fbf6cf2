#include "expected.hpp"

#include "number_text.hpp"

namespace sextant {
namespace {

std::string range_text(Range<double> r) {
  return number_text(r.min) + " to " + number_text(r.max);
}

struct Expected {
  std::string operator()(const NumberKind& f) const { return "a number from " + range_text(f.range); }
  std::string operator()(const IntegerKind& f) const {
    return "an integer from " + std::to_string(f.range.min) + " to " + std::to_string(f.range.max);
  }
  std::string operator()(const FlagKind&) const { return "true or false"; }
  std::string operator()(const TextKind& f) const {
    return f.may_be_empty ? "a string" : "a string, not empty";
  }
  std::string operator()(const ChoiceKind& f) const {
    std::string text;
    for (const std::string& name : f.names) text += (text.empty() ? "\"" : " or \"") + name + "\"";
    return text;
  }
  std::string operator()(const PointsKind& f) const {
    const std::string first = f.first.name;
    const std::string second = f.second.name;
    return "a list of [" + first + ", " + second + "] pairs, " + first + " from " +
           range_text({f.first.min, f.first.max}) + ", " + second + " from " +
           range_text({f.second.min, f.second.max});
  }
  std::string operator()(const FileKind& f) const {
    return "the path of a CSV file with the columns " + f.columns;
  }
  std::string operator()(const NamesKind& f) const { return "a list, not empty, of " + f.what; }
};

}  // namespace

std::string expected(const FieldKind& kind) {
  return std::visit(Expected{}, kind);
}

}  // namespace sextant
