// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/step_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace cas::hils {
namespace {

constexpr double kDt = 0.001;

std::vector<ResponseSample> sampled(const std::function<double(double)>& value, double end_s) {
  std::vector<ResponseSample> samples;
  for (int i = -1000; i * kDt <= end_s; ++i) samples.push_back({i * kDt, value(i * kDt)});
  return samples;
}

// y = 2 (1 - exp(-t / T)): rise T ln 9, settling T ln 20, integral of the error 2 T.
TEST(StepResponse, OfAFirstOrderLagIsAsInTheBooks) {
  constexpr double kT = 0.5;
  const auto samples = sampled([](double t) { return t < 0 ? 0 : 2 * (1 - std::exp(-t / kT)); }, 8);
  const StepResponse response = respond(samples, 0, 0, 2);
  ASSERT_TRUE(response.rise_s);
  ASSERT_TRUE(response.settling_s);
  EXPECT_NEAR(*response.rise_s, kT * std::log(9), 2 * kDt);
  EXPECT_NEAR(*response.settling_s, kT * std::log(20), 2 * kDt);
  EXPECT_NEAR(response.integrated_error, 2 * kT, 0.01);
  EXPECT_DOUBLE_EQ(response.overshoot_pct, 0);
}

// Damping d, frequency 1: overshoot exp(-pi d / sqrt(1 - d^2)).
TEST(StepResponse, OfASecondOrderSystemOvershootsByItsDamping) {
  constexpr double kD = 0.4;
  const double w = std::sqrt(1 - kD * kD);
  const auto samples = sampled(
      [w](double t) {
        if (t < 0) return 1.0;
        return 1 - 3 * (1 - std::exp(-kD * t) * (std::cos(w * t) + kD / w * std::sin(w * t)));
      },
      30);
  const StepResponse response = respond(samples, 0, 1, -2);  // downwards
  EXPECT_NEAR(response.overshoot_pct, 100 * std::exp(-M_PI * kD / w), 0.1);
}

TEST(StepResponse, HasNoRiseOrSettlingWhenItNeverArrives) {
  const auto samples = sampled([](double) { return 0.0; }, 5);
  const StepResponse response = respond(samples, 0, 0, 1);
  EXPECT_FALSE(response.rise_s);
  EXPECT_FALSE(response.settling_s);
  EXPECT_NEAR(response.integrated_error, 5, 0.01);
}

}  // namespace
}  // namespace cas::hils
