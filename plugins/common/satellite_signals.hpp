// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace cas::sim {

/// C/N0 of satellite `index` of `count` in view, dB-Hz: from the highest, 6 dB above the mean, to
/// the lowest, 6 dB below it, in equal steps. The spread is assumed.
inline double satellite_cn0_db_hz(double mean_db_hz, int index, int count) {
  constexpr double kHalfSpread_db = 6;
  return mean_db_hz + kHalfSpread_db * (1 - (2 * index + 1.0) / count);
}

/// Below this a receiver does not hold a satellite's signal, dB-Hz; assumed.
inline constexpr double kLeastCn0_db_hz = 28;

/// Fall of C/N0 by a jammer of broadband noise, dB, of J/N in dB: the noise in the receiver's band
/// becomes (1 + J/N) times its own.
inline double jammer_loss_db(double jammer_to_noise_db) {
  return 10 * std::log10(1 + std::pow(10, jammer_to_noise_db / 10));
}

}  // namespace cas::sim
