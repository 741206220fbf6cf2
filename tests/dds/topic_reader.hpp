#pragma once

#include <chrono>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <thread>

#include <dds/dds.h>

#include "support/source_directory.hpp"

namespace sextant::testing {

inline std::string loopback_configuration() {
  std::ifstream file(SEXTANT_SOURCE_DIR "/configs/cyclonedds_loopback.xml");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Samples of one topic, read as any C program would.
template <class Sample>
class TopicReader {
 public:
  TopicReader(std::uint32_t domain, const dds_topic_descriptor_t& type, const char* topic,
              dds_reliability_kind_t reliability, dds_durability_kind_t durability)
      : participant_(dds_create_participant(domain, nullptr, nullptr)) {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, reliability, DDS_SECS(1));
    dds_qset_durability(qos, durability);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
    reader_ = dds_create_reader(participant_, dds_create_topic(participant_, &type, topic, nullptr, nullptr),
                                qos, nullptr);
    dds_delete_qos(qos);
  }
  TopicReader(const TopicReader&) = delete;
  TopicReader& operator=(const TopicReader&) = delete;
  ~TopicReader() { dds_delete(participant_); }

  /// The next sample; nothing when none comes within a minute.
  std::optional<Sample> take() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes{1};
    do {
      Sample sample{};
      void* samples[] = {&sample};
      dds_sample_info_t info{};
      if (dds_take(reader_, samples, &info, 1, 1) == 1 && info.valid_data) return sample;
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
    } while (std::chrono::steady_clock::now() < deadline);
    return {};
  }

 private:
  dds_entity_t participant_;
  dds_entity_t reader_{0};
};

}  // namespace sextant::testing
