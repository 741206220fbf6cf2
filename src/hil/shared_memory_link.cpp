#include "sextant/hil/shared_memory_link.hpp"

#include <atomic>
#include <stdexcept>
#include <system_error>

namespace sextant {
namespace {

LinkFile::Lock presence_of(LinkRole role) {
  return role == LinkRole::plant ? LinkFile::Lock::plant_is_there : LinkFile::Lock::drive_is_there;
}

const char* name_of(LinkRole role) {
  return role == LinkRole::plant ? "plant" : "drive";
}

LinkRole opposite(LinkRole role) {
  return role == LinkRole::plant ? LinkRole::drive : LinkRole::plant;
}

}  // namespace

SharedMemoryLink::SharedMemoryLink(const HilParameters& parameters, LinkRole role, std::int64_t period_ns)
    : role_{role} {
  // The last side of a run may remove the memory between opening and locking it here.
  while (!try_attach(parameters, period_ns)) {
  }
}

void SharedMemoryLink::announce_end() noexcept {
  if (role_ == LinkRole::drive) memory().gate_enable.store(0, std::memory_order_release);
  own().present.store(0, std::memory_order_release);
}

SharedMemoryLink::~SharedMemoryLink() {
  announce_end();
  // A side that fails while attaching leaves the memory in place.
  if (file_->wait_for(LinkFile::Lock::attaching) && !other_is_attached()) file_->remove();
}

bool SharedMemoryLink::try_attach(const HilParameters& parameters, std::int64_t period_ns) {
  file_ = std::make_unique<LinkFile>(parameters.link);
  file_->lock(LinkFile::Lock::attaching);
  if (file_->is_removed()) return false;
  LinkHeader found{};
  file_->read_beginning(&found, sizeof found);
  const bool is_new = !check_header(found, file_->bytes());
  if (!file_->try_lock(presence_of(role_))) {
    throw std::runtime_error(std::string{"hil.link: \""} + parameters.link + "\" already has a " +
                             name_of(role_) + "; stop that one, or choose another name for both sides");
  }
  if (is_new) file_->resize(sizeof(LinkMemory));
  map();
  join(parameters, period_ns);
  file_->unlock(LinkFile::Lock::attaching);
  return true;
}

bool SharedMemoryLink::check_header(const LinkHeader& found, std::int64_t file_bytes) const {
  if (file_bytes == 0) return false;
  // A start that was killed before it had written the header; the size distinguishes it from a foreign file.
  const bool was_never_made = found.magic == 0 && file_bytes == std::int64_t{sizeof(LinkMemory)};
  if (was_never_made && !other_is_attached()) return false;
  const std::string memory = file_->sentence_start();
  const std::string remedy = "; stop the program that uses it and remove it, or choose another name";
  if (found.magic != link_magic) throw std::runtime_error(memory + " is none of Sextant's" + remedy);
  if (found.layout_version != link_layout_version) {
    throw std::runtime_error(memory + " has layout version " + std::to_string(found.layout_version) +
                             ", this program has " + std::to_string(link_layout_version) + remedy);
  }
  if (found.size_bytes != sizeof(LinkMemory) || file_bytes != std::int64_t{sizeof(LinkMemory)}) {
    throw std::runtime_error(memory + " has a size of " + std::to_string(file_bytes) +
                             " bytes and a header with " + std::to_string(found.size_bytes) +
                             ", this program needs " + std::to_string(sizeof(LinkMemory)) + remedy);
  }
  return true;
}

void SharedMemoryLink::map() {
  try {
    memory_ = std::make_unique<MappedObject<LinkMemory>>(file_->descriptor());
  } catch (const std::system_error& problem) {
    throw std::runtime_error(file_->sentence_start() + " cannot be mapped: " + problem.code().message());
  }
}

void SharedMemoryLink::join(const HilParameters& parameters, std::int64_t period_ns) {
  if (other_is_attached()) {
    check_other(parameters, period_ns);
  } else {
    begin_anew(parameters, period_ns);
  }
  if (role_ == LinkRole::drive) memory().gate_enable.store(0, std::memory_order_release);
  generation_ = own().generation.load(std::memory_order_relaxed) + 1;
  own().asleep.store(0, std::memory_order_relaxed);
  own().generation.store(generation_, std::memory_order_release);
  own().present.store(1, std::memory_order_release);
}

void SharedMemoryLink::check_other(const HilParameters& parameters, std::int64_t period_ns) const {
  const LinkHeader& theirs = memory().header;
  if (theirs.period_ns != period_ns) {
    throw std::runtime_error("hil.link: the other side of \"" + parameters.link +
                             "\" runs with a period of " + std::to_string(theirs.period_ns) +
                             " ns, this one with " + std::to_string(period_ns) + " ns; give both the same");
  }
  if (theirs.pacing != static_cast<std::uint32_t>(parameters.pacing)) {
    throw std::runtime_error("hil.pacing: one side of \"" + parameters.link +
                             "\" runs in real time and the other in lockstep; give both the same");
  }
}

/// Clears the memory of an earlier run; to be called while no side is attached.
void SharedMemoryLink::begin_anew(const HilParameters& parameters, std::int64_t period_ns) {
  const std::uint32_t plants = memory().plant.generation.load(std::memory_order_relaxed);
  const std::uint32_t drives = memory().drive.generation.load(std::memory_order_relaxed);
  memory_->renew();
  memory().plant.generation.store(plants, std::memory_order_relaxed);
  memory().drive.generation.store(drives, std::memory_order_relaxed);
  const auto pacing = static_cast<std::uint32_t>(parameters.pacing);
  memory().header = {0, link_layout_version, sizeof(LinkMemory), period_ns, pacing, 0};
  // Last, so that memory of a start that was killed before counts as not made.
  std::atomic_signal_fence(std::memory_order_seq_cst);
  memory().header.magic = link_magic;
}

LinkSide& SharedMemoryLink::own() const noexcept {
  return role_ == LinkRole::plant ? memory().plant : memory().drive;
}

LinkSide& SharedMemoryLink::other() const noexcept {
  return role_ == LinkRole::plant ? memory().drive : memory().plant;
}

bool SharedMemoryLink::other_is_attached() const noexcept {
  return file_->is_held_by_another(presence_of(opposite(role_)));
}

}  // namespace sextant
