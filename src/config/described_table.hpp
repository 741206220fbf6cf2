#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sextant/config/schema.hpp"
#include "sextant/core/description.hpp"

namespace sextant {

/// Makes the keys of a table of what is described.
class DescribedTable final : public Description {
 public:
  explicit DescribedTable(const Section& table) : tables_{table} {}

  void number(const char* name, NumberMember x, const Quantity& q) override {
    tables_.back().number(name, x, {q.min, q.max}, q.unit, q.meaning);
    tables_.back().changes(q.changes);
  }
  void derived(const char* name, NumberMember given, NumberValue value, const Quantity& q) override {
    tables_.back().derived(name, given, value, {q.min, q.max}, q.unit, q.meaning);
    tables_.back().changes(q.changes);
  }
  void integer(const char* name, IntegerMember x, const char* unit, std::int64_t min, std::int64_t max,
               const char* meaning, Changes changes) override {
    tables_.back().integer(name, x, {min, max}, unit, meaning);
    tables_.back().changes(changes);
  }
  void flag(const char* name, bool& x, const char* meaning, Changes changes) override {
    tables_.back().flag(name, x, meaning);
    tables_.back().changes(changes);
  }
  void choice(const char* name, IntegerMember x, std::span<const Choice<std::int64_t>> choices,
              const char* meaning, Changes changes) override {
    tables_.back().choice(name, x, {choices.begin(), choices.end()}, meaning);
    tables_.back().changes(changes);
  }
  void enter(const char* table) override { tables_.push_back(tables_.back().section(table)); }
  void leave() override { tables_.pop_back(); }

 private:
  std::vector<Section> tables_;  ///< each within the one before
};

/// The table of a struct of parameters, and its own check of them.
template <class Parameters>
void describe_parameters(Section s, Parameters& parameters) {
  DescribedTable table{s};
  describe(table, parameters);
  s.check(parameters);
}

/// The table of what a user says of parameters, and the check of those in force.
template <class Setup, class Parameters>
void describe_parameters(Section s, Setup& setup, const Parameters& resolved) {
  DescribedTable table{s};
  describe(table, setup, resolved);
  s.check(resolved);
}

}  // namespace sextant
