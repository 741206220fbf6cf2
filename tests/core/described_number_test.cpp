#include "sextant/core/described_number.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

template <class T>
class DescribedNumber : public ::testing::Test {};
using Scalars = ::testing::Types<double, float>;
TYPED_TEST_SUITE(DescribedNumber, Scalars);

TYPED_TEST(DescribedNumber, ReadsAndSetsItsMember) {
  TypeParam x{2.5};
  const NumberMember member{x};
  EXPECT_EQ(member.get(), 2.5);
  member.set(-4);
  EXPECT_EQ(x, TypeParam(-4));
  EXPECT_EQ(NumberValue{x}.get(), -4);
}

TYPED_TEST(DescribedNumber, IsANumberOfItsUnits) {
  TypeParam seconds{0.25};
  const NumberMember ms{seconds, 0.0009765625};  // 2^-10 s: exact in both scalars
  EXPECT_EQ(ms.get(), 256);
  ms.set(64);
  EXPECT_EQ(seconds, TypeParam(0.0625));
}

TYPED_TEST(DescribedNumber, MayBeLeftOpen) {
  std::optional<TypeParam> x;
  const NumberMember member{x};
  EXPECT_EQ(member.get(), std::nullopt);
  member.set(0);
  EXPECT_EQ(x, TypeParam(0));
  EXPECT_EQ(member.get(), 0);
}

TYPED_TEST(DescribedNumber, IsNoneWhereInfinityStandsForNone) {
  TypeParam x = std::numeric_limits<TypeParam>::infinity();
  const NumberMember member = NumberMember::unless_infinite(x);
  EXPECT_EQ(member.get(), std::nullopt);
  EXPECT_TRUE(NumberMember{x}.get().has_value());
  member.set(3);
  EXPECT_EQ(x, TypeParam(3));
  EXPECT_EQ(member.get(), 3);
}

TEST(DescribedTime, IsRoundedToNanosecondsAndEndsWithItsType) {
  std::int32_t ns = 25'000;
  const NumberMember us{ns, 1e3};
  EXPECT_EQ(us.get(), 25);
  us.set(0.0016);
  EXPECT_EQ(ns, 2) << "1.6 ns";
  us.set(-0.0016);
  EXPECT_EQ(ns, -2);
  us.set(1e9);
  EXPECT_EQ(ns, std::numeric_limits<std::int32_t>::max()) << "10^12 ns";
  us.set(-1e9);
  EXPECT_EQ(ns, std::numeric_limits<std::int32_t>::min());
  std::int64_t long_ns = 0;
  NumberMember{long_ns, 1e6}.set(1e6);
  EXPECT_EQ(long_ns, 1'000'000'000'000);
}

// What is bound by reference must not be gone before it is read.
static_assert(std::is_constructible_v<NumberValue, const double&>);
static_assert(!std::is_constructible_v<NumberValue, double>);
static_assert(!std::is_constructible_v<NumberValue, const float>);

TEST(DescribedInteger, ReadsAndSetsItsMember) {
  std::uint32_t x = 3;
  const IntegerMember member{x};
  EXPECT_EQ(member.get(), 3);
  member.set(4'000'000'000);
  EXPECT_EQ(x, 4'000'000'000U);
}

}  // namespace
}  // namespace sextant
