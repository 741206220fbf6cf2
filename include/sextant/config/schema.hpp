#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
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

/// What a key may hold.
struct NumberKind {
  Range<double> range;
};
struct IntegerKind {
  Range<std::int64_t> range;
};
struct FlagKind {};
struct TextKind {
  bool may_be_empty;
};
struct ChoiceKind {
  std::vector<std::string> names;
};
/// A list of pairs, written [[first, second], …].
struct PointsKind {
  Axis first;
  Axis second;
};
/// The path of a CSV file, relative to the file that names it; on the command line, to the working directory.
struct FileKind {
  std::string columns;  ///< as a message names them
};
/// A list of names out of those that are known.
struct NamesKind {
  std::vector<std::string> known;
  std::string what;  ///< the known names, as a message sums them up
};
using FieldKind =
    std::variant<NumberKind, IntegerKind, FlagKind, TextKind, ChoiceKind, PointsKind, FileKind, NamesKind>;

/// What a key holds: a text, a choice and a file are strings.
using Points = std::vector<PointsMember::Point>;
using Names = std::vector<std::string>;
using Value = std::variant<double, std::int64_t, bool, std::string, Points, Names>;

/// The way to and from the member that a key sets.
struct Access {
  std::function<std::optional<Value>()> get;  ///< nothing where an optional member is not set
  std::function<void(const Value&)> set;      ///< throws std::runtime_error with a sentence where it cannot
};

/// One key of a configuration file.
struct Field {
  std::string path{};     ///< dotted, from the file's root
  std::string unit{};     ///< empty where there is none
  std::string meaning{};  ///< one line for the reader of the file
  FieldKind kind;
  Access member{};
  bool required{false};  ///< the file must set it; there is no default
  bool derived{false};   ///< its default follows from machine and link
  Changes changes{Changes::never};
};

/// Two keys for one quantity; a file may use one of them.
struct Alternative {
  std::string first{};
  std::string second{};
  std::function<bool()> is_required{};  ///< asked when all files are read
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
  std::vector<std::string> files{};  ///< paths of the tables that may be files of their own
  std::vector<Alternative> alternatives{};
  std::vector<std::function<void()>> derivations{};  ///< run in order when everything has been read
  std::vector<Check> checks{};                       ///< run after the derivations
};

/// What a `validate()` says as a text; empty where nothing is wrong.
[[nodiscard]] inline std::string sentence(const char* problem) {
  return problem == nullptr ? "" : problem;
}
[[nodiscard]] inline std::string sentence(std::string problem) {
  return problem;
}

/// The keys and then the tables that stand in a table itself, each in alphabetic order; in the file's root by
/// an empty name.
[[nodiscard]] std::vector<std::string> names_in(const Schema& schema, const std::string& table);

/// A table of the file while it is being described. Members are bound by reference and must outlive the
/// schema.
class Section final : public Description {
 public:
  using Description::choice;
  using Description::defaulted;
  using Description::flag;
  using Description::integer;

  explicit Section(Schema& schema) : schema_{&schema} {}

  [[nodiscard]] Section section(const std::string& name) const { return {*schema_, path(name)}; }
  /// The same of a table that may be a file of its own: `name = "FILE"`.
  [[nodiscard]] Section section_or_file(const std::string& name) const {
    schema_->files.push_back(path(name));
    return section(name);
  }

  void number(const char* key, NumberMember x, const Quantity& q) override {
    add(key, q, x, [x] { return x.get(); });
  }

  /// A derivation leads from `given` to `value`. Where no value within the range follows, the file must set
  /// the key.
  void derived(const char* key, NumberMember given, NumberValue value, const Quantity& q) override {
    add(key, q, given, [value] { return value.get(); });
    schema_->fields.back().derived = true;
    require_usable(
        key, [given] { return given.get().has_value(); }, [value] { return value.get(); }, q,
        no_usable_value);
  }

  void defaulted(const char* key, NumberMember x, NumberDefault by_default, const Quantity& q,
                 const char* otherwise) override {
    defaulted_by(key, x, [by_default] { by_default.set(); }, q, otherwise);
  }

  /// A number that `set_default` sets unless it is given, once everything has been read and the derivations
  /// described before have run. Where it sets none within the range, the file must set the key; `otherwise`
  /// is the possible reason, for the message.
  void defaulted_by(const char* key, NumberMember x, const std::function<void()>& set_default,
                    const Quantity& q, const char* otherwise = no_usable_value) {
    const auto is_given = std::make_shared<bool>(false);
    add(key, q.unit, q.meaning, NumberKind{{q.min, q.max}},
        {[x] { return x.get(); },
         [x, is_given](const Value& value) {
           x.set(std::get<double>(value));
           *is_given = true;
         }},
        q.changes);
    schema_->fields.back().derived = true;
    derive([is_given, set_default] {
      if (!*is_given) set_default();
    });
    require_usable(key, [is_given] { return *is_given; }, [x] { return *x.get(); }, q, otherwise);
  }

  void integer(const char* key, IntegerMember x, const char* unit, std::int64_t min, std::int64_t max,
               const char* meaning, Changes changes) override {
    add(key, unit, meaning, IntegerKind{{min, max}},
        {[x] { return x.get(); }, [x](const Value& value) { x.set(std::get<std::int64_t>(value)); }},
        changes);
  }

  void flag(const char* key, bool& x, const char* meaning, Changes changes) override {
    add(key, "", meaning, FlagKind{}, access(x), changes);
  }

  void text(const char* key, TextMember x, const char* meaning, bool may_be_empty) override {
    add(key, "", meaning, TextKind{may_be_empty},
        {[x] { return std::string{x.get()}; },
         [x](const Value& value) { x.set(std::get<std::string>(value)); }});
  }

  void choice(const char* key, IntegerMember x, std::span<const Choice<std::int64_t>> choices,
              const char* meaning, Changes changes) override {
    choose(
        key, {choices.begin(), choices.end()}, meaning, [x] { return std::optional{x.get()}; },
        [x](std::int64_t value) { x.set(value); });
    schema_->fields.back().changes = changes;
  }

  /// The same of a member that may be left out. unset: the name of that; null: the key is not set then.
  template <class E>
  void choice(const char* key, std::optional<E>& x, std::type_identity_t<std::span<const Choice<E>>> choices,
              const std::string& meaning, const char* unset) {
    std::optional<std::int64_t> none;
    std::vector<Choice<std::int64_t>> known;
    for (const Choice<E>& c : choices) {
      known.push_back({c.name, std::int64_t(c.value)});
      if (unset != nullptr && std::string_view{c.name} == unset) none = known.back().value;
    }
    if (unset != nullptr && !none) known.insert(known.begin(), {unset, *(none = -1)});
    choose(
        key, known, meaning, [&x, none] { return x ? std::optional{std::int64_t(*x)} : none; },
        [&x](std::int64_t value) {
          if (value < 0)
            x.reset();
          else
            x = E(value);
        });
  }

  /// One of `names`, as a string.
  void name(const char* key, std::string& x, Names names, const std::string& meaning) {
    add(key, "", meaning, ChoiceKind{std::move(names)}, access(x));
  }

  void points(const char* key, PointsMember x, const Axis& first, const Axis& second, const char* unit,
              const char* meaning) override {
    const auto get = [x] {
      Points points;
      for (std::size_t k = 0; k < x.size(); ++k) points.push_back(x.get(k));
      return points;
    };
    add(key, unit, meaning, PointsKind{first, second},
        {get, [x](const Value& points) { x.set(std::get<Points>(points)); }});
  }

  void enter(const char* table) override { path_ = path(table); }
  void leave() override {
    const std::size_t dot = path_.rfind('.');
    path_.erase(dot == std::string::npos ? 0 : dot);
  }

  /// A CSV file. `member` keeps its path; `read` takes what is in it and throws std::runtime_error with a
  /// sentence when it cannot.
  void file(const std::string& key, std::string& member, const char* columns, const char* meaning,
            std::function<void(const std::string&)> read) {
    add(key, "", meaning, FileKind{columns},
        {[&member] { return member.empty() ? std::nullopt : std::optional<Value>{member}; },
         [&member, read = std::move(read)](const Value& value) {
           const auto& path = std::get<std::string>(value);
           read(path);
           member = std::filesystem::absolute(path).lexically_normal().string();
         }});
  }

  /// A list of names, each one of `known`, which `what` sums up.
  void names(const std::string& key, Names& member, Names known, std::string what, const char* meaning) {
    add(key, "", meaning, NamesKind{std::move(known), std::move(what)}, access(member));
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
  void add(const std::string& key, const char* unit, const std::string& meaning, FieldKind kind,
           Access member, Changes changes = Changes::never) {
    schema_->fields.push_back({.path = path(key),
                               .unit = unit,
                               .meaning = meaning,
                               .kind = std::move(kind),
                               .member = std::move(member),
                               .changes = changes});
  }

  /// The keys described so far within this section may change then, or earlier where it is said.
  void change_at_least(Changes when) {
    for (Field& field : schema_->fields) {
      if (field.path.starts_with(path_ + ".")) field.changes = std::max(field.changes, when);
    }
  }

  /// The key described last must be set.
  void required() { schema_->fields.back().required = true; }

  void alternative(const std::string& first, const std::string& second, std::function<bool()> is_required) {
    schema_->alternatives.push_back({path(first), path(second), std::move(is_required)});
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
    check([&parameters] { return sentence(parameters.validate()); });
  }

 private:
  /// One of several names, each for a number.
  void choose(const char* key, const std::vector<Choice<std::int64_t>>& known, const std::string& meaning,
              std::function<std::optional<std::int64_t>()> get, std::function<void(std::int64_t)> set) {
    Names names;
    for (const Choice<std::int64_t>& c : known) names.emplace_back(c.name);
    const auto name_now = [known, get = std::move(get)]() -> std::optional<Value> {
      const std::optional<std::int64_t> now = get();
      for (const Choice<std::int64_t>& c : known) {
        if (now == c.value) return c.name;
      }
      return {};
    };
    const auto take = [known, set = std::move(set)](const Value& name) {
      for (const Choice<std::int64_t>& c : known) {
        if (std::get<std::string>(name) == c.name) set(c.value);
      }
    };
    add(key, "", meaning, ChoiceKind{std::move(names)}, {name_now, take});
  }

  /// To and from a member that is a value itself.
  template <class T>
  static Access access(T& x) {
    return {[&x] { return x; }, [&x](const Value& value) { x = std::get<T>(value); }};
  }

  void add(const char* key, const Quantity& q, NumberMember x, std::function<std::optional<Value>()> get) {
    add(key, q.unit, q.meaning, NumberKind{{q.min, q.max}},
        {std::move(get), [x](const Value& value) { x.set(std::get<double>(value)); }}, q.changes);
  }

  Section(Schema& schema, std::string path) : schema_{&schema}, path_{std::move(path)} {}

  /// The number of a key is given, or what follows for it is within its range.
  void require_usable(const std::string& key, const std::function<bool()>& is_given,
                      const std::function<double()>& value, const Quantity& q, const std::string& otherwise) {
    check_basis(key, [is_given, value, least = q.min, most = q.max, otherwise]() -> std::string {
      if (is_given() || (value() >= least && value() <= most)) return {};
      return "missing: " + otherwise;
    });
  }

  [[nodiscard]] std::string path(const std::string& key) const {
    return path_.empty() ? key : path_ + "." + key;
  }

  Schema* schema_;
  std::string path_{};
};

/// The table of a struct of parameters, and its own check of them.
template <class Parameters>
void describe_parameters(Section s, Parameters& parameters) {
  describe(s, parameters);
  s.check(parameters);
}

/// The table of what a user says of parameters, and the check of those in force.
template <class Setup, class Parameters>
void describe_parameters(Section s, Setup& setup, const Parameters& resolved) {
  describe(s, setup, resolved);
  s.check(resolved);
}

}  // namespace sextant
