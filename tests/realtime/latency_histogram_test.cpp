#include "sextant/realtime/latency_histogram.hpp"

#include <random>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sextant/realtime/latest_value.hpp"

namespace sextant {
namespace {

/// Nearest-rank percentile of sorted samples, from its definition.
std::int64_t exact_percentile(const std::vector<std::int64_t>& sorted, double percent) {
  const auto rank = static_cast<std::size_t>(std::ceil(percent / 100.0 * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

void expect_percentiles_within_two_percent(std::vector<std::int64_t> samples) {
  LatencyHistogram histogram;
  double sum = 0.0;
  for (const std::int64_t s : samples) {
    histogram.record(s);
    sum += static_cast<double>(s);
  }
  std::sort(samples.begin(), samples.end());
  for (const double percent : {0.1, 1.0, 10.0, 50.0, 90.0, 99.0, 99.9, 99.99, 100.0}) {
    SCOPED_TRACE(percent);
    const auto exact = static_cast<double>(exact_percentile(samples, percent));
    EXPECT_NEAR(static_cast<double>(histogram.percentile_ns(percent)), exact, 0.02 * exact);
  }
  EXPECT_EQ(histogram.max_ns(), samples.back());
  EXPECT_EQ(histogram.count(), samples.size());
  EXPECT_NEAR(histogram.mean_ns(), sum / static_cast<double>(samples.size()), 1e-9 * sum);
}

TEST(LatencyHistogram, PercentilesAgreeWithSortedSamples) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random{seed};
    std::lognormal_distribution<double> microseconds{3.0, 1.5};
    std::uniform_int_distribution<std::int64_t> small{0, 300};
    std::uniform_real_distribution<double> exponent{0.0, 39.0};
    std::vector<std::int64_t> latencies, near_zero, all_octaves;
    for (int i = 0; i < 20'000; ++i) {
      latencies.push_back(static_cast<std::int64_t>(1e3 * microseconds(random)));
      near_zero.push_back(small(random));
      all_octaves.push_back(static_cast<std::int64_t>(std::exp2(exponent(random))));
    }
    expect_percentiles_within_two_percent(std::move(latencies));
    expect_percentiles_within_two_percent(std::move(near_zero));
    expect_percentiles_within_two_percent(std::move(all_octaves));
  }
}

TEST(LatencyHistogram, EverySingleValueIsWithinTwoPercentOfItself) {
  // A second sample far above keeps the maximum from hiding the bucket's own value.
  for (std::int64_t v = 1; v < (std::int64_t{1} << 39); v += 1 + v / 97) {
    LatencyHistogram histogram;
    histogram.record(v);
    histogram.record(std::int64_t{1} << 39);
    ASSERT_NEAR(static_cast<double>(histogram.percentile_ns(50.0)), static_cast<double>(v),
                0.008 * static_cast<double>(v))
        << v;
  }
}

TEST(LatencyHistogram, ValuesBelow128NsAreExact) {
  for (std::int64_t v = 0; v < 128; ++v) {
    LatencyHistogram histogram;
    histogram.record(v);
    histogram.record(1'000);
    ASSERT_EQ(histogram.percentile_ns(50.0), v);
  }
}

TEST(LatencyHistogram, ValuesOutsideTheRangeAreKeptAtItsEnds) {
  LatencyHistogram histogram;
  histogram.record(-5);
  EXPECT_EQ(histogram.percentile_ns(100.0), 0);
  constexpr std::int64_t hour_ns = 3'600'000'000'000;
  histogram.record(hour_ns);
  EXPECT_EQ(histogram.max_ns(), hour_ns);
  EXPECT_EQ(histogram.percentile_ns(100.0), hour_ns);
  EXPECT_EQ(histogram.percentile_ns(50.0), 0);
}

TEST(LatencyHistogram, EmptyAndResetReadZero) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.percentile_ns(99.0), 0);
  histogram.record(1'000);
  histogram.reset();
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.max_ns(), 0);
  EXPECT_EQ(histogram.percentile_ns(99.0), 0);
  EXPECT_EQ(histogram.mean_ns(), 0.0);
}

TEST(LatencyHistogram, CrossesThreadsThroughALatestValue) {
  LatestValue<LatencyHistogram> cell;
  constexpr std::uint64_t samples = 20'000;
  std::thread recorder{[&cell] {
    LatencyHistogram histogram;
    for (std::uint64_t i = 1; i <= samples; ++i) {
      histogram.record(static_cast<std::int64_t>(i));
      if (i % 100 == 0) cell.store(histogram);
    }
  }};
  std::uint64_t count = 0;
  while (count < samples) {
    const LatencyHistogram& histogram = cell.latest();
    ASSERT_GE(histogram.count(), count);
    count = histogram.count();
    ASSERT_EQ(static_cast<std::uint64_t>(histogram.max_ns()), count) << "a whole, consistent snapshot";
  }
  recorder.join();
  EXPECT_NEAR(static_cast<double>(cell.latest().summary().p50_ns), 10'000.0, 200.0);
}

TEST(LatencyHistogram, TheSummaryGoesOutToOneInTenThousand) {
  LatencyHistogram histogram;
  for (int i = 0; i < 100'000; ++i)
    histogram.record(i < 99'910 ? 10 : i < 99'991 ? 100 : i < 99'999 ? 1'000 : 10'000);
  const LatencySummary s = histogram.summary();
  EXPECT_EQ(s.p50_ns, 10);
  EXPECT_EQ(s.p99_ns, 10);
  EXPECT_EQ(s.p99_9_ns, 10);
  EXPECT_EQ(histogram.percentile_ns(99.92), 100);
  EXPECT_EQ(s.p99_99_ns, 100);
  EXPECT_NEAR(double(histogram.percentile_ns(99.995)), 1'000.0, 8.0);
  EXPECT_EQ(s.max_ns, 10'000);
}

TEST(LatencyHistogram, ItsBucketsHoldEverySampleInOrder) {
  LatencyHistogram histogram;
  for (const std::int64_t ns : {5, 5, 100, 90'000, 1'000'000}) histogram.record(ns);
  std::vector<std::pair<std::int64_t, std::uint64_t>> buckets;
  histogram.for_each_bucket([&](std::int64_t ns, std::uint64_t count) { buckets.emplace_back(ns, count); });
  ASSERT_EQ(buckets.size(), 4U);
  EXPECT_EQ(buckets[0], std::make_pair(std::int64_t{5}, std::uint64_t{2}));
  EXPECT_EQ(buckets[1], std::make_pair(std::int64_t{100}, std::uint64_t{1}));
  EXPECT_NEAR(double(buckets[2].first), 90'000.0, 90'000.0 / 128.0);
  EXPECT_NEAR(double(buckets[3].first), 1e6, 1e6 / 128.0);
}

}  // namespace
}  // namespace sextant
