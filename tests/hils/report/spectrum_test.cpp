// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/spectrum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cas::hils {
namespace {

constexpr double kRate_hz = 500;

std::vector<double> sine(double amplitude, double hz, std::size_t count, double offset = 0) {
  std::vector<double> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double turns = hz * static_cast<double>(i) / kRate_hz;
    samples[i] = offset + amplitude * std::sin(2 * std::numbers::pi * turns);
  }
  return samples;
}

std::size_t peak_of(const Spectrum& spectrum) {
  return static_cast<std::size_t>(std::ranges::max_element(spectrum.amplitude) -
                                  spectrum.amplitude.begin());
}

TEST(Spectrum, ReadsASinesAmplitudeAtItsFrequency) {
  constexpr double kBin_hz = kRate_hz / 1024;
  constexpr double kHz = 82 * kBin_hz;  // on a value of the spectrum: nothing leaks
  const Spectrum spectrum = amplitude_spectrum(sine(0.3, kHz, 15'000, 7.0), kRate_hz);
  EXPECT_DOUBLE_EQ(spectrum.resolution_hz, kBin_hz);
  ASSERT_EQ(spectrum.amplitude.size(), 513U);  // 0 Hz to half of the rate
  EXPECT_EQ(peak_of(spectrum), 82U);
  EXPECT_NEAR(spectrum.amplitude[82], 0.3, 1e-6);
  EXPECT_NEAR(spectrum.amplitude[0], 0, 1e-6);  // the mean is no oscillation
  EXPECT_LT(spectrum.amplitude[90], 1e-6);
}

TEST(Spectrum, FindsASineBetweenTwoOfItsValues) {
  const Spectrum spectrum = amplitude_spectrum(sine(2.0, 40.3, 15'000), kRate_hz);
  const double hz = static_cast<double>(peak_of(spectrum)) * spectrum.resolution_hz;
  EXPECT_NEAR(hz, 40.3, spectrum.resolution_hz / 2);
  constexpr double kHannScallop = 0.15;  // 1.4 dB at most, half a value away
  EXPECT_NEAR(*std::ranges::max_element(spectrum.amplitude), 2.0, 2.0 * kHannScallop);
}

TEST(Spectrum, TellsTwoSinesApart) {
  std::vector<double> samples = sine(1.0, 50, 15'000);
  const std::vector<double> other = sine(0.5, 60, 15'000);
  std::ranges::transform(samples, other, samples.begin(), std::plus<>());
  const Spectrum spectrum = amplitude_spectrum(samples, kRate_hz);
  const auto at = [&spectrum](double hz) {
    return spectrum.amplitude[static_cast<std::size_t>(std::lround(hz / spectrum.resolution_hz))];
  };
  EXPECT_NEAR(at(50), 1.0, 0.15);
  EXPECT_NEAR(at(60), 0.5, 0.08);
  EXPECT_LT(at(55), 0.01);
}

TEST(Spectrum, IsEmptyWithoutSamples) {
  EXPECT_TRUE(amplitude_spectrum({}, kRate_hz).amplitude.empty());
  EXPECT_TRUE(amplitude_spectrum(sine(1, 50, 15), kRate_hz).amplitude.empty());
  EXPECT_TRUE(amplitude_spectrum(sine(1, 50, 100), 0).amplitude.empty());
}

TEST(Spectrum, TakesAShortStretchWhole) {
  const Spectrum spectrum = amplitude_spectrum(sine(1, 125, 100), kRate_hz);
  EXPECT_DOUBLE_EQ(spectrum.resolution_hz, kRate_hz / 64);
  EXPECT_EQ(peak_of(spectrum), 16U);
}

}  // namespace
}  // namespace cas::hils
