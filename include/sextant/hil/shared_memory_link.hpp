#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "sextant/hil/hil_parameters.hpp"
#include "sextant/hil/link_file.hpp"
#include "sextant/hil/link_memory.hpp"
#include "sextant/hil/mapped_object.hpp"

namespace sextant {

enum class LinkRole : std::uint8_t { plant, drive };

/// One side's hold on the shared memory of a link. The first side makes it, the last one removes it. Each
/// side holds a lock on a byte of the file, so that a killed side counts as absent at once and its memory is
/// reused.
class SharedMemoryLink {
 public:
  /// Throws std::runtime_error with one sentence when the memory is another user's, another program's or
  /// another version's, when other users may reach it, when a lock on it is not released, when the other side
  /// runs with another period or pacing, or when this role is taken.
  SharedMemoryLink(const HilParameters& parameters, LinkRole role, std::int64_t period_ns);
  SharedMemoryLink(const SharedMemoryLink&) = delete;
  SharedMemoryLink& operator=(const SharedMemoryLink&) = delete;
  ~SharedMemoryLink();

  [[nodiscard]] LinkMemory& memory() const noexcept { return memory_->get(); }
  /// Number of this side's start, from 1.
  [[nodiscard]] std::uint32_t generation() const noexcept { return generation_; }
  [[nodiscard]] LinkSide& own() const noexcept;
  [[nodiscard]] LinkSide& other() const noexcept;

  /// Announces the orderly end of this side and clears the gate-enable line; once, at the end.
  void announce_end() noexcept;

  /// Whether a process holds the other role. Makes a system call, so not for the control thread.
  [[nodiscard]] bool other_is_attached() const noexcept;

 private:
  [[nodiscard]] bool try_attach(const HilParameters& parameters, std::int64_t period_ns);
  void join(const HilParameters& parameters, std::int64_t period_ns);
  void check_other(const HilParameters& parameters, std::int64_t period_ns) const;
  void begin_anew(const HilParameters& parameters, std::int64_t period_ns);
  [[nodiscard]] bool check_header(const LinkHeader& found, std::int64_t file_bytes) const;
  void map();

  LinkRole role_;
  std::unique_ptr<LinkFile> file_{};
  std::unique_ptr<MappedObject<LinkMemory>> memory_{};
  std::uint32_t generation_{0};
};

}  // namespace sextant
