#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "sextant/core/description.hpp"

namespace sextant {

/// Least and largest value allowed, both included.
template <class T>
struct Range {
  T min;
  T max;
};

/// What a key may hold, and the way to and from the member that it sets. A `get` that has nothing to give
/// belongs to an optional member that is not set.
struct NumberField {
  Range<double> range;
  std::function<std::optional<double>()> get;
  std::function<void(double)> set;
};
struct IntegerField {
  Range<std::int64_t> range;
  std::function<std::optional<std::int64_t>()> get;
  std::function<void(std::int64_t)> set;
};
struct FlagField {
  std::function<bool()> get;
  std::function<void(bool)> set;
};
struct TextField {
  bool may_be_empty;
  std::function<std::string()> get;
  std::function<void(std::string)> set;
};
struct ChoiceField {
  std::vector<std::string> names;
  std::function<std::string()> get;
  std::function<void(std::string_view)> set;
};
/// A list of pairs, written [[first, second], …].
struct PointsField {
  using Pairs = std::vector<std::pair<double, double>>;
  Range<double> first_range;
  Range<double> second_range;
  std::function<Pairs()> get;
  std::function<void(const Pairs&)> set;
  std::string first_name{"time"};    ///< of the first member of a pair, as a message names it
  std::string second_name{"value"};  ///< of the second one
};
/// The path of a CSV file, relative to the file that names it; on the command line, to the working directory.
struct FileField {
  std::string columns;                          ///< as a message names them
  std::function<std::string()> get;             ///< absolute path; empty where none is set
  std::function<std::string(std::string)> set;  ///< reads the file; empty, or what is wrong with it
};
/// A list of names out of those that are known.
struct NamesField {
  std::vector<std::string> known;
  std::string what;  ///< the known names, as a message sums them up
  std::function<std::vector<std::string>()> get;
  std::function<void(std::vector<std::string>)> set;
};
using FieldKind = std::variant<NumberField, IntegerField, FlagField, TextField, ChoiceField, PointsField,
                               FileField, NamesField>;

/// One key of a configuration file.
struct Field {
  std::string path{};     ///< dotted, from the file's root
  std::string unit{};     ///< empty where there is none
  std::string meaning{};  ///< one line for the reader of the file
  FieldKind kind;
  bool required{false};  ///< the file must set it; there is no default
  bool derived{false};   ///< its default follows from machine and link
  Changes changes{Changes::never};
};

/// Two keys for one quantity; a file may use one of them.
struct Alternative {
  std::string first{};
  std::string second{};
  bool required{false};
};

/// A condition on the values of a section: empty when it holds, else one sentence.
struct Check {
  std::string path{};
  std::function<std::string()> problem;
  std::string optional_table{};     ///< table that may be unused; empty: the check always counts
  std::function<bool()> is_used{};  ///< whether that table is in use
  bool decides{false};              ///< what is described after it follows from what it judges

  /// False for an unused table of which no key is given: its defaults have no effect.
  [[nodiscard]] bool counts(bool is_table_given) const {
    return optional_table.empty() || is_table_given || is_used();
  }
};

struct Schema;

/// A list of tables, written [[path]]; its items are described once it is known how many there are.
struct TableList {
  std::string path{};
  std::function<std::size_t()> size;                          ///< items that there are
  std::function<void(Schema& schema, std::size_t n)> expand;  ///< makes n items and describes them

  /// Path of an item: `path[k]`.
  [[nodiscard]] std::string item(std::size_t k) const { return path + "[" + std::to_string(k) + "]"; }
};

/// All keys of a kind of configuration file, bound to the members of one struct tree. Reader, printer and
/// tests use this one description.
struct Schema {
  std::vector<Field> fields{};
  std::vector<TableList> lists{};
  std::vector<Alternative> alternatives{};
  std::vector<std::function<void()>> derivations{};  ///< run in order when everything has been read
  std::vector<Check> checks{};                       ///< run after the derivations
};

/// A table of the file while it is being described. Members are bound by reference and must outlive the
/// schema.
class Section {
 public:
  explicit Section(Schema& schema) : schema_{&schema} {}

  [[nodiscard]] Section section(const std::string& name) const { return {*schema_, path(name)}; }

  void number(const std::string& key, NumberMember member, Range<double> range, const char* unit,
              const char* meaning) {
    add(key, unit, meaning,
        NumberField{range, [member] { return member.get(); }, [member](double x) { member.set(x); }});
  }

  /// A number whose default follows from machine and link: `rule` gives it once everything has been read and
  /// the derivations described before have run. Where no value within the range follows, the file must
  /// set the key; `otherwise` is the possible reason, for the message. The member is the file's value times
  /// `scale`; `rule` gives the member's.
  void derived(const std::string& key, double& member, Range<double> range, const char* unit,
               const char* meaning, const std::function<double()>& rule,
               const std::string& otherwise = "no usable value follows from machine and link",
               double scale = 1.0) {
    const auto is_given = std::make_shared<bool>(false);
    add(key, unit, meaning,
        NumberField{range, [&member, scale] { return member / scale; },
                    [&member, scale, is_given](double x) {
                      member = x * scale;
                      *is_given = true;
                    }});
    schema_->fields.back().derived = true;
    derive([&member, is_given, rule] {
      if (!*is_given) member = rule();
    });
    check_basis(key, [&member, is_given, range, otherwise, scale]() -> std::string {
      if (*is_given || (member >= range.min * scale && member <= range.max * scale)) return {};
      return "missing: " + otherwise;
    });
  }

  /// A number that follows from others unless it is given: a derivation leads from `given` to `value`. Where
  /// no value within the range follows, the file must set the key, as above.
  void derived(const std::string& key, NumberMember given, NumberValue value, Range<double> range,
               const char* unit, const char* meaning) {
    add(key, unit, meaning,
        NumberField{range, [value] { return std::optional{value.get()}; },
                    [given](double x) { given.set(x); }});
    schema_->fields.back().derived = true;
    check_basis(key, [given, value, range]() -> std::string {
      if (given.get() || (value.get() >= range.min && value.get() <= range.max)) return {};
      return "missing: no usable value follows from machine and link";
    });
  }

  /// A time whose default `rule` gives [ns] once everything has been read.
  template <std::signed_integral I>
  void derived_time(const std::string& key, I& member, double unit_ns, Range<double> range, const char* unit,
                    const char* meaning, const std::function<I()>& rule) {
    const auto is_given = std::make_shared<bool>(false);
    add(key, unit, meaning,
        NumberField{range,
                    [&member, unit_ns] { return std::optional{static_cast<double>(member) / unit_ns}; },
                    [member = NumberMember{member, unit_ns}, is_given](double x) {
                      member.set(x);
                      *is_given = true;
                    }});
    schema_->fields.back().derived = true;
    derive([&member, is_given, rule] {
      if (!*is_given) member = rule();
    });
  }

  /// A time, kept as integer nanoseconds; `unit_ns` is the length of the key's unit [ns].
  template <std::signed_integral I>
  void time(const std::string& key, I& member, double unit_ns, Range<double> range, const char* unit,
            const char* meaning) {
    number(key, NumberMember{member, unit_ns}, range, unit, meaning);
  }

  void integer(const std::string& key, IntegerMember member, Range<std::int64_t> range, const char* unit,
               const char* meaning) {
    add(key, unit, meaning,
        IntegerField{range, [member] { return std::optional{member.get()}; },
                     [member](std::int64_t x) { member.set(x); }});
  }

  void integer(const std::string& key, std::optional<int>& member, Range<std::int64_t> range,
               const char* unit, const char* meaning) {
    add(key, unit, meaning,
        IntegerField{range,
                     [&member] { return member ? std::optional<std::int64_t>{*member} : std::nullopt; },
                     [&member](std::int64_t x) { member = static_cast<int>(x); }});
  }

  void flag(const std::string& key, bool& member, const char* meaning) {
    add(key, "", meaning, FlagField{[&member] { return member; }, [&member](bool x) { member = x; }});
  }

  void text(const std::string& key, std::string& member, const char* meaning, bool may_be_empty = false) {
    add(key, "", meaning,
        TextField{may_be_empty, [&member] { return member; },
                  [&member](std::string x) { member = std::move(x); }});
  }

  template <class E>
  void choice(const std::string& key, E& member, const std::vector<Choice<E>>& choices, const char* meaning) {
    std::vector<Choice<std::int64_t>> values;
    values.reserve(choices.size());
    for (const Choice<E>& c : choices) values.push_back({c.name, static_cast<std::int64_t>(c.value)});
    choice(key, IntegerMember{member}, std::move(values), meaning);
  }

  /// The same of the values of any member.
  void choice(const std::string& key, IntegerMember member, std::vector<Choice<std::int64_t>> choices,
              const char* meaning) {
    std::vector<std::string> names;
    names.reserve(choices.size());
    for (const Choice<std::int64_t>& c : choices) names.emplace_back(c.name);
    const auto get = [member, choices] {
      for (const Choice<std::int64_t>& c : choices) {
        if (c.value == member.get()) return std::string{c.name};
      }
      return std::string{};
    };
    const auto set = [member, choices = std::move(choices)](std::string_view name) {
      for (const Choice<std::int64_t>& c : choices) {
        if (c.name == name) member.set(c.value);
      }
    };
    add(key, "", meaning, ChoiceField{std::move(names), get, set});
  }

  /// A CSV file. `member` keeps its path; `read` takes what is in it and throws std::runtime_error with a
  /// sentence when it cannot.
  void file(const std::string& key, std::string& member, const char* columns, const char* meaning,
            std::function<void(const std::string&)> read) {
    const auto set = [&member, read = std::move(read)](const std::string& path) -> std::string {
      try {
        read(path);
      } catch (const std::runtime_error& problem) {
        return problem.what();
      }
      member = std::filesystem::absolute(path).lexically_normal().string();
      return {};
    };
    add(key, "", meaning, FileField{columns, [&member] { return member; }, set});
  }

  /// A list of names, each one of `known`, which `what` sums up.
  void names(const std::string& key, std::vector<std::string>& member, std::vector<std::string> known,
             std::string what, const char* meaning) {
    add(key, "", meaning,
        NamesField{std::move(known), std::move(what), [&member] { return member; },
                   [&member](std::vector<std::string> x) { member = std::move(x); }});
  }

  /// A list of tables, [[key]]; `describe_item` describes the section of one of them.
  template <class Item>
  void list(const std::string& key, std::vector<Item>& items,
            std::function<void(Section, Item&)> describe_item) {
    TableList list{path(key), [&items] { return items.size(); }, {}};
    list.expand = [&items, describe_item = std::move(describe_item), at = list](Schema& schema,
                                                                                std::size_t n) {
      items.resize(n);
      for (std::size_t k = 0; k < n; ++k) describe_item(Section{schema, at.item(k)}, items[k]);
    };
    schema_->lists.push_back(std::move(list));
  }

  /// Any other way to and from a member.
  void add(const std::string& key, const char* unit, const char* meaning, FieldKind kind) {
    schema_->fields.push_back({path(key), unit, meaning, std::move(kind), false});
  }

  /// When the key described last may change while the drive runs; never unless it is said.
  void changes(Changes when) { schema_->fields.back().changes = when; }
  /// The keys described so far within this section may change then, or earlier where it is said.
  void change_at_least(Changes when) {
    for (Field& field : schema_->fields) {
      if (field.path.starts_with(path_ + ".")) field.changes = std::max(field.changes, when);
    }
  }

  /// The key described last must be set.
  void required() { schema_->fields.back().required = true; }

  void alternative(const std::string& first, const std::string& second, bool is_required) {
    schema_->alternatives.push_back({path(first), path(second), is_required});
  }

  /// Values that follow from what was read.
  void derive(std::function<void()> f) { schema_->derivations.push_back(std::move(f)); }

  void check(std::function<std::string()> problem) { schema_->checks.push_back({path_, std::move(problem)}); }

  /// A check of what other values follow from, of a key or of the section: where it fails, what is described
  /// after it is not judged.
  void check_basis(const std::string& key, std::function<std::string()> problem) {
    schema_->checks.push_back(
        {.path = key.empty() ? path_ : path(key), .problem = std::move(problem), .decides = true});
  }

  /// The checks described so far within this section count where `is_used` holds or a file gives one of its
  /// keys. The ranges of keys always count.
  void optional(const std::function<bool()>& is_used) {
    for (Check& check : schema_->checks) {
      if (check.path != path_ && !check.path.starts_with(path_ + ".")) continue;
      check.optional_table = path_;
      check.is_used = is_used;
    }
  }

  /// The parameter struct's own validate(). The struct must outlive the schema.
  template <class Parameters>
  void check(const Parameters& parameters)
    requires requires { parameters.validate(); }
  {
    check([&parameters]() -> std::string {
      if constexpr (std::same_as<decltype(parameters.validate()), const char*>) {
        const char* problem = parameters.validate();
        return problem == nullptr ? "" : problem;
      } else {
        return parameters.validate();
      }
    });
  }

 private:
  Section(Schema& schema, std::string path) : schema_{&schema}, path_{std::move(path)} {}

  [[nodiscard]] std::string path(const std::string& key) const {
    return path_.empty() ? key : path_ + "." + key;
  }

  Schema* schema_;
  std::string path_{};
};

}  // namespace sextant
