// Seeded violations, one of each kind that scripts/check_tidy --self-test must find.
#include <string>
#include <utility>
#include <vector>

namespace sextant {

std::string use_after_move(std::string text) {
  const std::string taken = std::move(text);
  return taken + text;  // bugprone-use-after-move
}

std::size_t copied_in_a_loop(const std::vector<std::string>& words) {
  std::size_t letters = 0;
  for (const std::string word : words) letters += word.size();  // performance-for-range-copy
  return letters;
}

double BadName(double x) {
  return x;
}  // readability-identifier-naming

}  // namespace sextant
