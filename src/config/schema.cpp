#include "sextant/config/schema.hpp"

#include <set>

namespace sextant {

std::vector<std::string> names_in(const Schema& schema, const std::string& table) {
  std::set<std::string> keys;
  std::set<std::string> tables;
  const std::string before = table.empty() ? "" : table + ".";
  const auto note = [&](const std::string& path, std::set<std::string>& end) {
    if (!path.starts_with(before)) return;
    const std::string name = path.substr(before.size(), path.find('.', before.size()) - before.size());
    (name.size() + before.size() == path.size() ? end : tables).insert(name);
  };
  for (const Field& field : schema.fields) note(field.path, keys);
  for (const TableList& list : schema.lists) note(list.path, tables);
  std::vector<std::string> names{keys.begin(), keys.end()};
  names.insert(names.end(), tables.begin(), tables.end());
  return names;
}

}  // namespace sextant
