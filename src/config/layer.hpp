#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sextant/config/config_error.hpp"
#include "toml++/toml.h"

namespace sextant {

/// One source of configuration values: a file or one override. Later layers win.
struct Layer {
  std::string file{};    ///< as shown in messages
  std::string prefix{};  ///< where its root lies in the whole tree: "" or a section
  bool is_override{false};
  toml::table table{};

  /// The node at a path of the whole tree; nullptr where this layer does not set it.
  [[nodiscard]] const toml::node* find(std::string_view path) const;

  /// A problem of this layer; `path` is shown as the layer itself names it.
  [[nodiscard]] ConfigProblem problem(const toml::node* node, std::string_view path,
                                      std::string message) const;

  /// A path of the file system that this layer names, seen from the working directory.
  [[nodiscard]] std::string resolved(const std::string& path) const;

  /// The path as this layer's own file writes it.
  [[nodiscard]] std::string local_path(std::string_view path) const;
};

/// Throws ConfigError when the file cannot be read or is not TOML.
[[nodiscard]] Layer read_layer(const std::string& file, const std::string& prefix = {});
/// The same from a text; `file` names it in messages.
[[nodiscard]] Layer text_layer(const std::string& text, const std::string& file,
                               const std::string& prefix = {});

/// "key=value". Throws ConfigError when it is not of that form.
[[nodiscard]] Layer override_layer(const std::string& text);

/// Takes the path of the file that holds a section ("machine", "drive.inverter") out of the layers and puts
/// the file's own layer before them. Throws ConfigError when it is not a path or the file is bad.
void insert_section_layer(std::vector<Layer>& layers, const std::string& section);

/// Takes `base = "path"`, the file that the first layer changes, out of it and puts that file's layer before
/// it, and so on with the base of that file. Throws ConfigError when one is not a path, a file is bad, or
/// they are more than eight.
void insert_base_layers(std::vector<Layer>& layers);

/// The value as a message shows it.
[[nodiscard]] std::string shown(const toml::node& node);

}  // namespace sextant
