#include "reader.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "expected.hpp"

namespace sextant {
namespace {

bool within(double x, Range<double> r) {
  return x >= r.min && x <= r.max;
}  // false for NaN

std::optional<double> number(const toml::node& node, Range<double> range) {
  if (!node.is_number()) return std::nullopt;
  const auto x = node.value<double>();
  return x && within(*x, range) ? x : std::nullopt;
}

/// Levenshtein distance: insertions, deletions and replacements from a to b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0U : 1U);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// The name that is written most like `word`.
template <class Names>
std::string nearest(const Names& names, std::string_view word) {
  std::string best;
  std::size_t least = std::string::npos;
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(word, name);
    if (distance >= least) continue;
    least = distance;
    best = name;
  }
  return best;
}

/// What the node holds, where the key may hold that.
struct Taken {
  const toml::node& node;
  const Layer& layer;
  std::string why{};  ///< further reason of a refusal; may be empty

  std::optional<Value> operator()(const NumberKind& k) const { return number(node, k.range); }
  std::optional<Value> operator()(const IntegerKind& k) const {
    const auto x = node.value_exact<std::int64_t>();
    return x && *x >= k.range.min && *x <= k.range.max ? x : std::nullopt;
  }
  std::optional<Value> operator()(const FlagKind&) const { return node.value_exact<bool>(); }
  std::optional<Value> operator()(const TextKind& k) const { return text(k.may_be_empty); }
  std::optional<Value> operator()(const ChoiceKind& k) const {
    const auto name = text(true);
    return name && std::ranges::find(k.names, *name) != k.names.end() ? name : std::nullopt;
  }
  std::optional<Value> operator()(const FileKind&) const {
    const auto path = text(false);
    return path ? std::optional<Value>{layer.resolved(*path)} : std::nullopt;
  }
  std::optional<Value> operator()(const NamesKind& k) {
    const toml::array* list = node.as_array();
    if (list == nullptr || list->empty()) return {};
    Names names;
    for (const toml::node& item : *list) {
      const auto name = item.value<std::string>();
      if (!name) return {};
      if (std::ranges::find(k.known, *name) == k.known.end()) {
        why = "there is no \"" + *name + "\"; the nearest known one is \"" + nearest(k.known, *name) + "\"";
        return {};
      }
      names.push_back(*name);
    }
    return names;
  }
  std::optional<Value> operator()(const PointsKind& k) const {
    const toml::array* list = node.as_array();
    if (list == nullptr) return {};
    Points points;
    for (const toml::node& item : *list) {
      const toml::array* pair = item.as_array();
      if (pair == nullptr || pair->size() != 2) return {};
      const auto first = number(*pair->get(0), {k.first.min, k.first.max});
      const auto second = number(*pair->get(1), {k.second.min, k.second.max});
      if (!first || !second) return {};
      points.emplace_back(*first, *second);
    }
    return points;
  }

  [[nodiscard]] std::optional<std::string> text(bool may_be_empty) const {
    auto text = node.value_exact<std::string>();
    return text && text->empty() && !may_be_empty ? std::nullopt : text;
  }
};

/// Sets the key; where it may not hold that, why, as a message ends.
std::optional<std::string> refusal(const Field& field, const toml::node& node, const Layer& layer) {
  Taken taken{node, layer};
  try {
    if (const auto value = std::visit(taken, field.kind)) {
      field.member.set(*value);
      return {};
    }
  } catch (const std::runtime_error& problem) {
    taken.why = problem.what();
  }
  return taken.why.empty() ? "" : ": " + taken.why;
}

class Reader {
 public:
  Reader(const Schema& schema, const std::vector<Layer>& layers) : schema_{schema}, layers_{layers} {
    for (const Field& field : schema.fields) {
      keys_.insert(field.path);
      for (std::size_t dot = field.path.find('.'); dot != std::string::npos;
           dot = field.path.find('.', dot + 1)) {
        tables_.insert(field.path.substr(0, dot));
      }
    }
    for (const TableList& list : schema.lists) tables_.insert(list.path);
  }

  void read() {
    for (const Layer& layer : layers_) read_layer(layer);
    check_required();
    finish();
    for (const auto& derive : schema_.derivations) derive();
    run_checks();
    finish();
  }

 private:
  void read_layer(const Layer& layer) {
    const auto first = static_cast<std::ptrdiff_t>(problems_.size());
    check_keys(layer, layer.table, layer.prefix);
    for (const Field& field : schema_.fields) {
      const toml::node* node = layer.find(field.path);
      if (node == nullptr) continue;
      given_.insert(field.path);
      const std::optional<std::string> why = refusal(field, *node, layer);
      if (!why) continue;
      problems_.push_back(layer.problem(node, field.path,
                                        "expected " + expected(field.kind) + ", got " + shown(*node) + *why));
    }
    for (const Alternative& a : schema_.alternatives) {
      const toml::node* second = layer.find(a.second);
      if (layer.find(a.first) == nullptr || second == nullptr) continue;
      problems_.push_back(
          layer.problem(second, a.second, "give this or " + layer.local_path(a.first) + ", not both"));
    }
    const auto is_before = [](const ConfigProblem& a, const ConfigProblem& b) { return a.line < b.line; };
    const auto begin = problems_.begin() + first;
    for (auto next = begin; next != problems_.end(); ++next)  // each to its line, behind those of the same
      std::rotate(std::upper_bound(begin, next, *next, is_before), next, next + 1);
  }

  /// Every key of the table is known, and what should be a table is one.
  void check_keys(const Layer& layer, const toml::table& table, const std::string& path) {
    for (auto&& [key, node] : table) {
      const std::string inner = (path.empty() ? "" : path + ".") + std::string{key.str()};
      if (keys_.contains(inner)) continue;
      if (check_list(layer, node, inner)) continue;
      if (!tables_.contains(inner)) {
        problems_.push_back(layer.problem(&node, inner, unknown(layer, inner)));
      } else if (const toml::table* inner_table = node.as_table()) {
        check_keys(layer, *inner_table, inner);
      } else {
        problems_.push_back(layer.problem(&node, inner, "expected a table, got " + shown(node)));
      }
    }
  }

  /// True where a list of tables belongs: its items are walked, or what is there instead is a problem.
  bool check_list(const Layer& layer, const toml::node& node, const std::string& path) {
    const auto list = std::find_if(schema_.lists.begin(), schema_.lists.end(),
                                   [&path](const TableList& l) { return l.path == path; });
    if (list == schema_.lists.end()) return false;
    const toml::array* items = node.as_array();
    if (items == nullptr || !is_list_of_tables(*items)) {
      problems_.push_back(layer.problem(&node, path, "expected a list of tables, got " + shown(node)));
      return true;
    }
    for (std::size_t k = 0; k < items->size(); ++k)
      check_keys(layer, *items->get(k)->as_table(), list->item(k));
    return true;
  }

  static bool is_list_of_tables(const toml::array& items) {
    return std::all_of(items.begin(), items.end(), [](const toml::node& item) { return item.is_table(); });
  }

  /// Why a path is not known.
  [[nodiscard]] std::string unknown(const Layer& layer, const std::string& path) const {
    const std::string found = nearest_path(path);
    if (!path.starts_with(found + ".")) {
      return "unknown key; the nearest known one is " + layer.local_path(found);
    }
    return fmt::format("unknown key; those of {} are {}", layer.local_path(found),
                       fmt::join(names_in(schema_, found), ", "));
  }

  [[nodiscard]] std::string nearest_path(const std::string& path) const {
    std::vector<std::string> names{keys_.begin(), keys_.end()};
    names.insert(names.end(), tables_.begin(), tables_.end());
    return nearest(names, path);
  }

  void check_required() {
    for (const Field& field : schema_.fields) {
      if (field.required && !given_.contains(field.path)) {
        problems_.push_back(missing(field.path, "missing, expected " + expected(field.kind)));
      }
    }
    for (const Alternative& a : schema_.alternatives) {
      if (a.is_required() && !given_.contains(a.first) && !given_.contains(a.second)) {
        ConfigProblem problem = missing(a.first, "missing, expected a number here or in ");
        problem.message += a.second.substr(a.second.rfind('.') + 1);
        problems_.push_back(std::move(problem));
      }
    }
  }

  /// A missing key is laid at the door of the first file it could stand in.
  [[nodiscard]] ConfigProblem missing(const std::string& path, std::string message) const {
    const auto home = std::find_if(layers_.begin(), layers_.end(), [&path](const Layer& layer) {
      return !layer.is_override && (layer.prefix.empty() || path.starts_with(layer.prefix + "."));
    });
    return home->problem(nullptr, path, std::move(message));
  }

  /// True when a layer sets a key of the table.
  [[nodiscard]] bool is_table_given(const std::string& table) const {
    return std::any_of(given_.begin(), given_.end(),
                       [&table](const std::string& key) { return key.starts_with(table + "."); });
  }

  /// In order, up to a problem of what other values follow from, which is told only where there is none
  /// before it: it may follow from that.
  void run_checks() {
    for (const Check& check : schema_.checks) {
      const std::size_t before = problems_.size();
      run(check);
      if (!check.decides || problems_.size() == before) continue;
      if (before > 0) problems_.pop_back();
      return;
    }
  }

  void run(const Check& check) {
    if (!check.counts(is_table_given(check.optional_table))) return;
    std::string message = check.problem();
    if (message.empty() || (!check.decides && is_told_of_part(check.path, message))) return;
    told_.emplace_back(check.path, message);
    const auto home = std::find_if(layers_.rbegin(), layers_.rend(), [&check](const Layer& layer) {
      return layer.find(check.path) != nullptr;
    });
    if (home == layers_.rend() || check.path.empty()) {
      problems_.push_back(missing(check.path, std::move(message)));
    } else {
      problems_.push_back(home->problem(home->find(check.path), check.path, std::move(message)));
    }
  }

  /// True where a part of the section has the same problem: a section's parameters check those of its parts.
  [[nodiscard]] bool is_told_of_part(const std::string& section, const std::string& message) const {
    return std::any_of(told_.begin(), told_.end(), [&](const auto& told) {
      return told.second == message && told.first.starts_with(section + ".");
    });
  }

  void finish() {
    if (!problems_.empty()) throw ConfigError{std::move(problems_)};
  }

  const Schema& schema_;
  const std::vector<Layer>& layers_;
  std::set<std::string> keys_{};
  std::set<std::string> tables_{};
  std::set<std::string> given_{};
  std::vector<ConfigProblem> problems_{};
  std::vector<std::pair<std::string, std::string>> told_{};  // path and message of each check that fails
};

}  // namespace

void read(const Schema& schema, const std::vector<Layer>& layers) {
  Schema whole = schema;
  for (const TableList& list : schema.lists) {
    std::size_t items = 0;
    for (const Layer& layer : layers) {
      const toml::node* node = layer.find(list.path);
      if (node != nullptr && node->is_array()) items = std::max(items, node->as_array()->size());
    }
    list.expand(whole, items);
  }
  Reader{whole, layers}.read();
}

}  // namespace sextant
