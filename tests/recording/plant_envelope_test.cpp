#include "sextant/recording/plant_envelope.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace sextant {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

PlantSample sample(double torque, double psi, double current) {
  // Directions that are no axis, so that a magnitude is told from a component.
  return {.torque = torque,
          .tau_l = 0.5 * torque,
          .psi_s = polar(psi, 1.0 + torque),
          .i_abc = inverse_clarke(polar(current, -2.0 + torque))};
}

TEST(PlantEnvelope, WithoutASegmentItIsOneInstant) {
  PlantEnvelope envelope;
  const PlantRow row = envelope.row(sample(8, 0.9, 11));
  EXPECT_EQ(row.torque_nm, 8);
  EXPECT_EQ(row.torque_mean_nm, 8);
  EXPECT_EQ(row.torque_min_nm, 8);
  EXPECT_EQ(row.torque_max_nm, 8);
  EXPECT_DOUBLE_EQ(row.psi_s_wb, 0.9);
  EXPECT_DOUBLE_EQ(row.flux_mean_wb, 0.9);
  EXPECT_NEAR(row.current_min_a, 11, 1e-12);
  EXPECT_NEAR(row.current_max_a, 11, 1e-12);
  EXPECT_EQ(row.tau_l_nm, 4);
}

TEST(PlantEnvelope, SegmentsWeighByTheirDurationAndBothEndsCount) {
  PlantEnvelope envelope;
  envelope.add_segment(sample(0, 1.0, 1), sample(4, 1.2, 30), 3e-6);
  envelope.add_segment(sample(4, 1.2, 30), sample(2, 0.8, 2), 1e-6);
  const PlantRow row = envelope.row(sample(2, 0.8, 2));
  EXPECT_NEAR(row.torque_mean_nm, (2.0 * 3 + 3.0 * 1) / 4, 1e-12);
  EXPECT_NEAR(row.flux_mean_wb, (1.1 * 3 + 1.0 * 1) / 4, 1e-12);
  EXPECT_EQ(row.torque_min_nm, 0);
  EXPECT_EQ(row.torque_max_nm, 4);
  EXPECT_NEAR(row.flux_min_wb, 0.8, 1e-12);
  EXPECT_NEAR(row.flux_max_wb, 1.2, 1e-12);
  EXPECT_NEAR(row.current_min_a, 1, 1e-12);
  EXPECT_NEAR(row.current_max_a, 30, 1e-12);
}

TEST(PlantEnvelope, BeginsAnewAfterAReset) {
  PlantEnvelope envelope;
  envelope.add_segment(sample(100, 9, 90), sample(100, 9, 90), 1);
  envelope.reset();
  envelope.add_segment(sample(1, 1, 1), sample(1, 1, 1), 1);
  const PlantRow row = envelope.row(sample(1, 1, 1));
  EXPECT_EQ(row.torque_mean_nm, 1);
  EXPECT_EQ(row.torque_max_nm, 1);
  EXPECT_DOUBLE_EQ(row.flux_max_wb, 1);
  EXPECT_NEAR(row.current_max_a, 1, 1e-12);
}

TEST(PlantEnvelope, ANanShowsInTheMeanAndLeavesTheLimitsToTheNumbers) {
  PlantEnvelope envelope;
  PlantSample broken = sample(2, 1, 1);
  broken.torque = nan;
  envelope.add_segment(sample(2, 1, 1), broken, 1);
  EXPECT_TRUE(std::isnan(envelope.row(broken).torque_mean_nm));
  EXPECT_EQ(envelope.row(broken).torque_min_nm, 2);
  EXPECT_EQ(envelope.row(broken).torque_max_nm, 2);
  PlantEnvelope nothing;
  nothing.add_segment(broken, broken, 1);
  EXPECT_TRUE(std::isnan(nothing.row(broken).torque_min_nm));
  EXPECT_TRUE(std::isnan(nothing.row(broken).torque_max_nm));
}

}  // namespace
}  // namespace sextant
