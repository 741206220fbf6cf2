#pragma once

#include <dds/dds.h>

namespace sextant {

/// A DDS entity that deletes itself and its children.
class DdsEntity {
 public:
  DdsEntity() noexcept = default;
  explicit DdsEntity(dds_entity_t handle) noexcept : handle_(handle) {}
  DdsEntity(DdsEntity&& other) noexcept : handle_(other.handle_) { other.handle_ = 0; }
  DdsEntity(const DdsEntity&) = delete;
  DdsEntity& operator=(const DdsEntity&) = delete;
  DdsEntity& operator=(DdsEntity&&) = delete;
  ~DdsEntity() {
    if (handle_ > 0) dds_delete(handle_);
  }

  [[nodiscard]] dds_entity_t get() const noexcept { return handle_; }

 private:
  dds_entity_t handle_{0};
};

}  // namespace sextant
