// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/spectrum.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace cas::hils {

namespace {

constexpr double kSegment_s = 3;
constexpr std::size_t kLeastSamples = 16;

std::vector<double> hann(std::size_t size) {
  std::vector<double> window(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double turn = static_cast<double>(i) / static_cast<double>(size);
    window[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * turn);
  }
  return window;
}

double sum(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

Spectrum amplitude_spectrum(std::span<const double> samples, double rate_hz) {
  if (samples.size() < kLeastSamples || !(rate_hz > 0)) return {};
  const auto wanted = static_cast<std::size_t>(kSegment_s * rate_hz);
  const std::size_t size = std::bit_floor(std::clamp(wanted, kLeastSamples, samples.size()));
  const std::vector<double> window = hann(size);
  const double scale = 2 / sum(window);

  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<double> segment(size);
  std::vector<std::complex<double>> transform;
  std::vector<double> squares(size / 2 + 1, 0.0);
  std::size_t segments = 0;
  for (std::size_t begin = 0; begin + size <= samples.size(); begin += size / 2, ++segments) {
    const std::span<const double> part = samples.subspan(begin, size);
    const double mean = sum(part) / static_cast<double>(size);
    for (std::size_t i = 0; i < size; ++i) segment[i] = (part[i] - mean) * window[i];
    fft.fwd(transform, segment);
    for (std::size_t i = 0; i < squares.size(); ++i) squares[i] += std::norm(scale * transform[i]);
  }

  Spectrum spectrum{.resolution_hz = rate_hz / static_cast<double>(size), .amplitude = {}};
  for (const double square : squares) {
    spectrum.amplitude.push_back(std::sqrt(square / static_cast<double>(segments)));
  }
  return spectrum;
}

}  // namespace cas::hils
