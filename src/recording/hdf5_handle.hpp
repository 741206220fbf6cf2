#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <hdf5.h>

namespace sextant::hdf5 {

/// The innermost message of HDF5's error stack, which is the one that names the cause; of one about a file,
/// the error of the operating system.
[[nodiscard]] inline std::string last_error() {
  std::string cause{"unknown reason"};
  const auto keep = [](unsigned n, const H5E_error2_t* error, void* text) -> herr_t {
    if (n == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep, &cause);
  constexpr std::string_view quoted = "error message = '";
  if (const auto begin = cause.find(quoted); begin != std::string::npos) {
    cause.erase(0, begin + quoted.size());
    cause.erase(std::min(cause.find('\''), cause.size()));
  }
  return cause;
}

/// Keeps HDF5 from printing its error stack during its lifetime; the caller reports errors itself.
class Quiet {
 public:
  Quiet() noexcept {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

 private:
  H5E_auto2_t function_{};
  void* data_{};
};

/// Owns one HDF5 identifier.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Handle() noexcept = default;

  /// Throws std::runtime_error with HDF5's reason if `id` is none.
  Handle(hid_t id, Close close_function) : id_{id}, close_{close_function} {
    if (id < 0) throw std::runtime_error{last_error()};
  }
  Handle(Handle&& o) noexcept : id_{std::exchange(o.id_, H5I_INVALID_HID)}, close_{o.close_} {}
  Handle& operator=(Handle&& o) noexcept {
    std::swap(id_, o.id_);
    std::swap(close_, o.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }

  [[nodiscard]] hid_t get() const noexcept { return id_; }
  [[nodiscard]] explicit operator bool() const noexcept { return id_ >= 0; }

  /// Gives the identifier up without closing it.
  hid_t release() noexcept { return std::exchange(id_, H5I_INVALID_HID); }

  /// Closes now. Throws std::runtime_error with HDF5's reason if that fails.
  void close() {
    if (id_ >= 0 && close_(std::exchange(id_, H5I_INVALID_HID)) < 0) throw std::runtime_error{last_error()};
  }

 private:
  hid_t id_{H5I_INVALID_HID};
  Close close_{};
};

/// Throws std::runtime_error with HDF5's reason if a call failed.
inline void check(herr_t status) {
  if (status < 0) throw std::runtime_error{last_error()};
}

/// An attribute of fixed-length UTF-8 text.
inline void write_attribute(hid_t object, const char* name, const std::string& text) {
  const Handle type{H5Tcopy(H5T_C_S1), H5Tclose};
  check(H5Tset_size(type.get(), text.size() + 1));
  check(H5Tset_cset(type.get(), H5T_CSET_UTF8));
  const Handle space{H5Screate(H5S_SCALAR), H5Sclose};
  const Handle attribute{H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose};
  check(H5Awrite(attribute.get(), type.get(), text.c_str()));
}

/// An attribute of one 64-bit integer.
inline void write_attribute(hid_t object, const char* name, long long value) {
  const Handle space{H5Screate(H5S_SCALAR), H5Sclose};
  const Handle attribute{H5Acreate2(object, name, H5T_NATIVE_LLONG, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose};
  check(H5Awrite(attribute.get(), H5T_NATIVE_LLONG, &value));
}

}  // namespace sextant::hdf5
