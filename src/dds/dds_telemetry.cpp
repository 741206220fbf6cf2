#include "sextant/dds/dds_telemetry.hpp"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dds_configuration.hpp"
#include "dds_entity.hpp"
#include "telemetry_conversion.hpp"

namespace sextant {
namespace {

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

Qos keep_last_qos(dds_reliability_kind_t reliability, dds_durability_kind_t durability) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(qos.get(), reliability, DDS_MSECS(100));
  dds_qset_durability(qos.get(), durability);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  return qos;
}

/// Keeps the log of Cyclone DDS during its lifetime instead of printing it, so that one sentence can report
/// why DDS cannot start.
class LogCapture {
 public:
  LogCapture() { dds_set_log_sink(&LogCapture::on_log, &text_); }
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;
  ~LogCapture() { dds_set_log_sink(nullptr, nullptr); }

  /// The first line, without its end.
  [[nodiscard]] std::string first_line() const { return text_.substr(0, text_.find('\n')); }

 private:
  static void on_log(void* text, const dds_log_data_t* data) {
    static_cast<std::string*>(text)->append(data->message, data->size);
  }

  std::string text_;
};

[[noreturn]] void fail(const DdsTelemetry::Parameters& parameters, const std::string& what) {
  std::string text = "DDS cannot start on domain " + std::to_string(parameters.domain_id) + ": " + what;
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  if (!parameters.configuration_source.empty()) {
    text += "; the configuration comes from " + parameters.configuration_source;
  } else if (parameters.configuration.empty() && uri != nullptr) {
    text += "; the configuration comes from the environment, CYCLONEDDS_URI=" + std::string(uri);
  }
  throw std::runtime_error(text);
}

[[noreturn]] void fail(const DdsTelemetry::Parameters& parameters, const std::string& what,
                       dds_return_t error, const LogCapture& log) {
  const std::string line = log.first_line();
  fail(parameters, what + ": " + dds_strretcode(error) + (line.empty() ? "" : " (" + line + ")"));
}

void check_configuration(const DdsTelemetry::Parameters& parameters) {
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  try {
    check_dds_configuration(!parameters.configuration.empty() ? parameters.configuration
                            : uri != nullptr                  ? std::string_view{uri}
                                                              : std::string_view{});
  } catch (const std::runtime_error& problem) {
    fail(parameters, problem.what());
  }
}

dds_entity_t create_domain(const DdsTelemetry::Parameters& parameters, const LogCapture& log) {
  if (parameters.configuration.empty()) return 0;
  const dds_entity_t domain = dds_create_domain(parameters.domain_id, parameters.configuration.c_str());
  if (domain == DDS_RETCODE_PRECONDITION_NOT_MET) {
    fail(parameters, "the domain already runs in this process with its own configuration", domain, log);
  }
  if (domain < 0) fail(parameters, "the configuration was refused", domain, log);
  return domain;
}

dds_entity_t create_participant(const DdsTelemetry::Parameters& parameters, const LogCapture& log) {
  const dds_entity_t participant = dds_create_participant(parameters.domain_id, nullptr, nullptr);
  if (participant < 0) fail(parameters, "no participant", participant, log);
  return participant;
}

/// The same type, announced by its name alone.
dds_topic_descriptor_t without_type_information(const dds_topic_descriptor_t& type) {
  return {.m_size = type.m_size,
          .m_align = type.m_align,
          .m_flagset = type.m_flagset & ~DDS_TOPIC_XTYPES_METADATA,
          .m_nkeys = type.m_nkeys,
          .m_typename = type.m_typename,
          .m_keys = type.m_keys,
          .m_nops = type.m_nops,
          .m_ops = type.m_ops,
          .m_meta = type.m_meta,
          .type_information = {},
          .type_mapping = {},
          .restrict_data_representation = type.restrict_data_representation};
}

dds_entity_t create_topic(const DdsTelemetry::Parameters& parameters, dds_entity_t participant,
                          const dds_topic_descriptor_t& full_type, const char* name, const LogCapture& log) {
  const dds_topic_descriptor_t type =
      parameters.type_information ? full_type : without_type_information(full_type);
  const dds_entity_t topic = dds_create_topic(participant, &type, name, nullptr, nullptr);
  if (topic < 0) fail(parameters, std::string("topic ") + name, topic, log);
  return topic;
}

/// A topic's writer with the one instance that this drive has in it.
template <class Sample>
class InstanceWriter {
 public:
  InstanceWriter(const DdsTelemetry::Parameters& parameters, dds_entity_t participant, dds_entity_t topic,
                 const char* name, const Qos& qos, const LogCapture& log)
      : writer_(dds_create_writer(participant, topic, qos.get(), nullptr)) {
    if (writer_.get() < 0) fail(parameters, std::string("the writer of ") + name, writer_.get(), log);
    sample_.drive_id = parameters.drive_id;
    dds_instance_handle_t instance = 0;
    const dds_return_t registered = dds_register_instance(writer_.get(), &instance, &sample_);
    if (registered < 0) fail(parameters, std::string("the instance of ") + name, registered, log);
  }

  template <class... In>
  DdsWrite write(DdsTelemetryCounts& counts, std::optional<std::uint64_t> sequence,
                 const In&... in) noexcept {
    sample_.sequence = sequence.value_or(sample_.sequence);
    if (!convert(in..., sample_)) {
      ++counts.refused;
      ++sample_.sequence;
      return DdsWrite::refused;
    }
    const bool written = dds_write(writer_.get(), &sample_) == DDS_RETCODE_OK;
    ++sample_.sequence;  // readers see a sample that was not published as a gap
    ++(written ? counts.written : counts.failed);
    return written ? DdsWrite::ok : DdsWrite::failed;
  }

  [[nodiscard]] std::uint32_t incompatible_readers() const noexcept {
    dds_offered_incompatible_qos_status_t status{};
    return dds_get_offered_incompatible_qos_status(writer_.get(), &status) == DDS_RETCODE_OK
               ? status.total_count
               : 0;
  }

  [[nodiscard]] std::uint32_t readers() const noexcept {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(writer_.get(), &status) == DDS_RETCODE_OK ? status.current_count
                                                                                        : 0;
  }

 private:
  DdsEntity writer_;
  Sample sample_{};
};

}  // namespace

/// What the drives of a process share: domain, participant and topics.
struct DdsTelemetry::Session {
  Session(const Parameters& given, const LogCapture& log)
      : parameters(given),
        domain(create_domain(given, log)),
        participant(create_participant(given, log)),
        telemetry(topic(sextant_DriveTelemetry_desc, telemetry_name, log)),
        state(topic(sextant_DriveState_desc, state_name, log)),
        statistics(topic(sextant_RealTimeStatistics_desc, statistics_name, log)),
        waveform(topic(sextant_DriveWaveform_desc, waveform_name, log)) {}

  [[nodiscard]] dds_entity_t topic(const dds_topic_descriptor_t& type, const char* name,
                                   const LogCapture& log) const {
    return create_topic(parameters, participant.get(), type, name, log);
  }

  static constexpr const char* telemetry_name = "sextant/DriveTelemetry";
  static constexpr const char* state_name = "sextant/DriveState";
  static constexpr const char* statistics_name = "sextant/RealTimeStatistics";
  static constexpr const char* waveform_name = "sextant/DriveWaveform";
  Parameters parameters;
  DdsEntity domain;
  DdsEntity participant;
  dds_entity_t telemetry, state, statistics, waveform;  // end with the participant
  std::vector<std::uint32_t> drive_ids{};               // of the existing drives
};

struct DdsTelemetry::Impl {
  Impl(std::shared_ptr<Session> shared, std::uint32_t id, const LogCapture& log)
      : session(std::move(shared)),
        parameters(for_drive(*session, id)),
        telemetry(parameters, session->participant.get(), session->telemetry, Session::telemetry_name,
                  keep_last_qos(DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE), log),
        state(parameters, session->participant.get(), session->state, Session::state_name,
              keep_last_qos(DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL), log),
        statistics(parameters, session->participant.get(), session->statistics, Session::statistics_name,
                   keep_last_qos(DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL), log),
        waveform(parameters, session->participant.get(), session->waveform, Session::waveform_name,
                 keep_last_qos(DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE), log) {
    session->drive_ids.push_back(id);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { std::erase(session->drive_ids, parameters.drive_id); }

  /// Readers would see two writers of one key as one drive with two clocks and two counts.
  static Parameters for_drive(const Session& session, std::uint32_t id) {
    if (std::ranges::find(session.drive_ids, id) != session.drive_ids.end()) {
      throw std::runtime_error("this process already publishes a drive with the id " + std::to_string(id) +
                               "; give each drive its own drive_id");
    }
    Parameters parameters = session.parameters;
    parameters.drive_id = id;
    return parameters;
  }

  std::shared_ptr<Session> session;  // ends after the writers
  Parameters parameters;
  InstanceWriter<sextant_DriveTelemetry> telemetry;
  InstanceWriter<sextant_DriveState> state;
  InstanceWriter<sextant_RealTimeStatistics> statistics;
  InstanceWriter<sextant_DriveWaveform> waveform;
  DdsTelemetryCounts counts{};
};

DdsTelemetry::DdsTelemetry(const Parameters& parameters) {
  if (const char* const error = parameters.validate()) throw std::runtime_error(error);
  check_configuration(parameters);
  const LogCapture log;
  impl_ = std::make_unique<Impl>(std::make_shared<Session>(parameters, log), parameters.drive_id, log);
}

DdsTelemetry::DdsTelemetry(const DdsTelemetry& first, std::uint32_t drive_id) {
  const LogCapture log;
  impl_ = std::make_unique<Impl>(first.impl_->session, drive_id, log);
}

DdsTelemetry::~DdsTelemetry() = default;

DdsWrite DdsTelemetry::write(const TelemetryIntervalRecord<double>& record, std::uint64_t dropped,
                             std::optional<std::uint64_t> sequence) noexcept {
  return impl_->telemetry.write(impl_->counts, sequence, record, dropped);
}

DdsWrite DdsTelemetry::write(const DriveStateSample& sample, std::optional<std::uint64_t> sequence) noexcept {
  return impl_->state.write(impl_->counts, sequence, sample);
}

DdsWrite DdsTelemetry::write(const RealTimeSample& sample, std::optional<std::uint64_t> sequence) noexcept {
  return impl_->statistics.write(impl_->counts, sequence, sample);
}

DdsWrite DdsTelemetry::write(const WaveformBatch& batch, std::uint64_t dropped,
                             std::optional<std::uint64_t> sequence) noexcept {
  return impl_->waveform.write(impl_->counts, sequence, batch, dropped);
}

DdsTelemetryCounts DdsTelemetry::counts() const noexcept {
  return impl_->counts;
}

std::uint32_t DdsTelemetry::readers() const noexcept {
  return impl_->telemetry.readers();
}

std::uint32_t DdsTelemetry::waveform_readers() const noexcept {
  return impl_->waveform.readers();
}

std::uint32_t DdsTelemetry::incompatible_readers() const noexcept {
  return impl_->telemetry.incompatible_readers() + impl_->state.incompatible_readers() +
         impl_->statistics.incompatible_readers() + impl_->waveform.incompatible_readers();
}

}  // namespace sextant
