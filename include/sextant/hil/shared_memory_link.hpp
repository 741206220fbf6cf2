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

/// One side's hold on the shared memory of a link. Either side comes first, and then makes it; the last that
/// leaves removes it. Locks on bytes of the file tell who is there, so that a side that was killed is gone at
/// once and its memory is used again.
class SharedMemoryLink {
 public:
  /// Throws std::runtime_error with one sentence when the memory is another user's, another program's or
  /// another version's, when other users may reach it, when a lock on it is never given up, when the other
  /// side runs with another period or pacing, or when this role is taken.
  SharedMemoryLink(const HilParameters& parameters, LinkRole role, std::int64_t period_ns);
  SharedMemoryLink(const SharedMemoryLink&) = delete;
  SharedMemoryLink& operator=(const SharedMemoryLink&) = delete;
  ~SharedMemoryLink();

  [[nodiscard]] LinkMemory& memory() const noexcept { return memory_->get(); }
  /// This side's start, from 1.
  [[nodiscard]] std::uint32_t generation() const noexcept { return generation_; }
  [[nodiscard]] LinkSide& own() const noexcept;
  [[nodiscard]] LinkSide& other() const noexcept;

  /// Says that this side leaves in order, and takes the gate-enable line with it; once, at the end.
  void say_goodbye() noexcept;

  /// Whether a process holds the other role now; asks the kernel, so not for the control thread.
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
