#include "telemetry/contract_json.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "sextant/comms/telemetry_samples.hpp"
#include "sextant/comms/waveform_batch.hpp"
#include "sextant/core/telemetry_record.hpp"

namespace sextant {
namespace {

/// The contract's name of a type in C++.
template <class X>
struct ContractType;

#define SEXTANT_TYPE(cpp, contract)                \
  template <>                                      \
  struct ContractType<cpp> {                       \
    static std::string name() { return contract; } \
  };
SEXTANT_TYPE(bool, "boolean")
SEXTANT_TYPE(std::uint8_t, "octet")
SEXTANT_TYPE(std::int32_t, "long")
SEXTANT_TYPE(std::uint32_t, "unsigned long")
SEXTANT_TYPE(std::int64_t, "long long")
SEXTANT_TYPE(std::uint64_t, "unsigned long long")
SEXTANT_TYPE(float, "float")
SEXTANT_TYPE(double, "double")
SEXTANT_TYPE(std::string_view, "string<64>")
SEXTANT_TYPE(FaultSet, "unsigned long long")
SEXTANT_TYPE(std::optional<Fault>, "long")
SEXTANT_TYPE(DriveState, "DriveStateKind")
SEXTANT_TYPE(WaitMode, "WaitKind")
SEXTANT_TYPE(SchedulingPolicy, "SchedulingKind")
#undef SEXTANT_TYPE

template <class X, std::size_t most>
struct ContractType<BoundedSequence<X, most>> {
  static std::string name() {
    return "sequence<" + ContractType<X>::name() + ", " + std::to_string(most) + ">";
  }
};

/// The texts of the contract need no escape.
std::string quoted(std::string_view text) {
  return '"' + std::string{text} + '"';
}

/// Members of a JSON object or array, on a line each.
class Lines {
 public:
  explicit Lines(std::string indent) : indent_{std::move(indent)} {}

  void add(const std::string& line) { text_ += (text_.empty() ? "\n" : ",\n") + indent_ + line; }
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  std::string indent_;
  std::string text_{};
};

/// The members of a topic, first those that the publisher adds.
class Topic {
 public:
  /// samples: what its writer counts.
  explicit Topic(const std::string& samples) {
    lines_.add(member("drive_id", ContractType<std::uint32_t>::name(), "1", "identity of the drive", true));
    add<std::uint64_t>("sequence", "1", "counts the " + samples + " of this writer");
  }

  template <class X>
  void add(const char* name, const char* unit, const std::string& text) {
    lines_.add(member(name, ContractType<X>::name(), unit, text, false));
  }

  [[nodiscard]] std::string json() const { return "[" + lines_.text() + "\n    ]"; }

 private:
  static std::string member(std::string_view name, std::string_view type, std::string_view unit,
                            std::string_view text, bool is_key) {
    return "{\"name\": " + quoted(name) + ", \"type\": " + quoted(type) + ", \"unit\": " + quoted(unit) +
           ", \"text\": " + quoted(text) + (is_key ? ", \"key\": true}" : "}");
  }

  Lines lines_{"      "};
};

#define SEXTANT_MEMBER(member, unit, text) topic.add<decltype(Record::member)>(#member, unit, text);

std::string telemetry() {
  using Record = TelemetryIntervalRecord<float>;
  Topic topic{"samples"};
  topic.add<std::uint32_t>("dropped", "1",
                           "control periods lost between control thread and publisher since start");
  SEXTANT_TELEMETRY_MEMBERS(SEXTANT_MEMBER)
  return topic.json();
}

std::string state() {
  using Record = DriveStateSample;
  Topic topic{"samples"};
  SEXTANT_DRIVE_STATE_MEMBERS(SEXTANT_MEMBER)
  return topic.json();
}

std::string statistics() {
  using Record = RealTimeSample;
  Topic topic{"samples"};
  SEXTANT_REAL_TIME_MEMBERS(SEXTANT_MEMBER)
  return topic.json();
}

std::string waveform() {
  using Record = WaveformBatch;
  Topic topic{"batches"};
  topic.add<std::uint64_t>("dropped", "1",
                           "control periods lost between control and telemetry thread since start");
  SEXTANT_WAVEFORM_MEMBERS(SEXTANT_MEMBER)
  return topic.json();
}

#undef SEXTANT_MEMBER

#define SEXTANT_ENUMERATOR(type, enumerator, of_contract) \
  names += (names.empty() ? "\"" : ", \"") + std::string{#of_contract "\""};

std::string enumerations() {
  Lines lines{"    "};
  std::string names;
  SEXTANT_DRIVE_STATES(SEXTANT_ENUMERATOR)
  lines.add(quoted(ContractType<DriveState>::name()) + ": [" + names + "]");
  names.clear();
  SEXTANT_WAIT_MODES(SEXTANT_ENUMERATOR)
  lines.add(quoted(ContractType<WaitMode>::name()) + ": [" + names + "]");
  names.clear();
  SEXTANT_SCHEDULING_POLICIES(SEXTANT_ENUMERATOR)
  lines.add(quoted(ContractType<SchedulingPolicy>::name()) + ": [" + names + "]");
  return "{" + lines.text() + "\n  }";
}

#undef SEXTANT_ENUMERATOR

}  // namespace

std::string telemetry_contract_json() {
  Lines topics{"    "};
  topics.add("\"DriveTelemetry\": " + telemetry());
  topics.add("\"DriveState\": " + state());
  topics.add("\"RealTimeStatistics\": " + statistics());
  topics.add("\"DriveWaveform\": " + waveform());
  return "{\n  \"enumerations\": " + enumerations() + ",\n  \"topics\": {" + topics.text() + "\n  }\n}\n";
}

}  // namespace sextant
