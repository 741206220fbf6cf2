#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace sextant::bench {

/// How much longer `ours` takes than `reference`. Both run in turns in blocks of a few microseconds, so that
/// whatever the machine does to the clock or the cache it does to both; the medians over the blocks are
/// compared.
template <class Reference, class Ours>
double paired_ratio(Reference&& reference, Ours&& ours, std::size_t pairs = 4000) {
  const auto time = [](auto& block) {
    const auto begin = std::chrono::steady_clock::now();
    block();
    return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
  };
  const auto median = [](std::vector<double>& times) {
    const auto middle = times.begin() + std::ptrdiff_t(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    return *middle;
  };
  std::vector<double> reference_ns;
  std::vector<double> ours_ns;
  for (std::size_t n = 0; n < pairs; ++n) {
    reference_ns.push_back(time(reference));
    ours_ns.push_back(time(ours));
  }
  return median(ours_ns) / median(reference_ns);
}

}  // namespace sextant::bench
