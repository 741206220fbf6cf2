#include "dds_configuration.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <expat.h>

namespace sextant {
namespace {

constexpr std::string_view separators = ", \t\r\n";
constexpr std::string_view anonymous_close = "</>";

/// Reads one element with all that is in it.
class ElementReader {
 public:
  explicit ElementReader(std::string_view text) : text_{text} {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &ElementReader::on_open, &ElementReader::on_close);
  }

  /// A whole document: nothing but comments may follow its element.
  void read_document() {
    if (!feed(text_, true)) fail();
  }

  /// An element at the beginning of the text, with the closing tags that Cyclone DDS allows in fragments; the
  /// length of its text. [-]
  [[nodiscard]] std::size_t read_fragment() {
    stop_at_end_ = true;
    std::string_view left = text_;
    while (!ended()) {
      const std::size_t close = left.find(anonymous_close);
      const bool last = close == std::string_view::npos;
      if (!feed(left.substr(0, close), last) && !ended()) fail();
      if (last || ended()) break;
      left.remove_prefix(close + anonymous_close.size());
      close_innermost();
    }
    return end_;
  }

 private:
  using Parser = std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)>;

  [[nodiscard]] bool ended() const noexcept { return end_ > 0; }

  bool feed(std::string_view text, bool last) {
    return XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), last ? 1 : 0) ==
           XML_STATUS_OK;
  }

  void close_innermost() {
    const std::string tag = open_.empty() ? std::string{anonymous_close} : "</" + open_.back() + ">";
    inserted_ += tag.size() - anonymous_close.size();
    if (!feed(tag, false) && !ended()) fail();
  }

  static void on_open(void* self, const XML_Char* name, const XML_Char** /*attributes*/) {
    static_cast<ElementReader*>(self)->open_.emplace_back(name);
  }

  static void on_close(void* self, const XML_Char* /*name*/) { static_cast<ElementReader*>(self)->close(); }

  void close() {
    open_.pop_back();
    if (!open_.empty() || !stop_at_end_) return;
    const XML_Index end =
        XML_GetCurrentByteIndex(parser_.get()) + XML_Index{XML_GetCurrentByteCount(parser_.get())};
    end_ = static_cast<std::size_t>(end) - inserted_;
    XML_StopParser(parser_.get(), XML_FALSE);
  }

  [[noreturn]] void fail() const {
    const XML_Error error = XML_GetErrorCode(parser_.get());
    const std::string line = "line " + std::to_string(XML_GetCurrentLineNumber(parser_.get())) + ": ";
    const bool cut = error == XML_ERROR_NO_ELEMENTS || error == XML_ERROR_UNCLOSED_TOKEN;
    if (cut && !open_.empty()) throw std::runtime_error{line + "<" + open_.back() + "> is not closed"};
    throw std::runtime_error{line + XML_ErrorString(error)};
  }

  std::string_view text_;
  Parser parser_{XML_ParserCreate(nullptr), &XML_ParserFree};
  std::vector<std::string> open_{};
  bool stop_at_end_{false};
  std::size_t inserted_{0};
  std::size_t end_{0};
};

/// The beginning of a fragment, for people.
std::string head_of(std::string_view fragment) {
  constexpr std::size_t enough = 40;
  const std::string_view line = fragment.substr(0, fragment.find('\n'));
  return "\"" + std::string{line.substr(0, enough)} + (line.size() > enough ? "…\"" : "\"");
}

[[noreturn]] void fail_in(const std::string& place, const std::exception& problem) {
  throw std::runtime_error{"the configuration is no well-formed XML: " + place + ", " + problem.what()};
}

std::size_t check_fragment(std::string_view text) {
  try {
    return ElementReader{text}.read_fragment();
  } catch (const std::exception& problem) {
    fail_in(head_of(text), problem);
  }
}

constexpr std::size_t largest_file = std::size_t{1} << 20;  // [bytes]

void check_file(std::string_view uri) {
  constexpr std::string_view scheme = "file://";
  const bool is_uri = uri.substr(0, scheme.size()) == scheme;
  std::ifstream file{std::string{is_uri ? uri.substr(scheme.size()) : uri}, std::ios::binary};
  if (!file) return;
  std::string text(largest_file + 1, '\0');
  file.read(text.data(), std::streamsize(text.size()));
  text.resize(std::size_t(file.gcount()));
  if (text.size() > largest_file) {
    throw std::runtime_error{std::string{uri} + " is no configuration: it has more than 1 MiB"};
  }
  try {
    ElementReader{text}.read_document();
  } catch (const std::exception& problem) {
    fail_in(std::string{uri}, problem);
  }
}

}  // namespace

void check_dds_configuration(std::string_view configuration) {
  for (;;) {
    const std::size_t begin = configuration.find_first_not_of(separators);
    if (begin == std::string_view::npos) return;
    configuration.remove_prefix(begin);
    std::size_t length = 0;
    if (configuration.front() == '<') {
      length = check_fragment(configuration);
    } else {
      length = std::min(configuration.find(','), configuration.size());
      check_file(configuration.substr(0, length));
    }
    configuration.remove_prefix(length);
  }
}

}  // namespace sextant
