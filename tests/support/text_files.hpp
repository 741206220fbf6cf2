#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace sextant {

/// A directory of its own for each test, removed with its files.
class TextFiles {
 public:
  TextFiles() {
    std::string name = (std::filesystem::temp_directory_path() / "sextant_text_XXXXXX").string();
    directory_ = mkdtemp(name.data());
  }
  TextFiles(const TextFiles&) = delete;
  TextFiles& operator=(const TextFiles&) = delete;
  ~TextFiles() { std::filesystem::remove_all(directory_); }

  /// Writes a file and returns its path.
  [[nodiscard]] std::string write(const std::string& name, const std::string& text) const {
    std::ofstream{path(name)} << text;
    return path(name);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return directory_ + "/" + name; }

 private:
  std::string directory_;
};

/// Why something was refused; a failure where it was not.
inline std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return {};
}

}  // namespace sextant
