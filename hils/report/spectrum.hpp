// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

namespace cas::hils {

/// Amplitude over frequency, from 0 to half of the sample rate.
struct Spectrum {
  double resolution_hz = 0;       ///< from one value to the next
  std::vector<double> amplitude;  ///< value i is at i * resolution_hz; in the samples' unit
};

/// Amplitude spectrum of samples at even distances: a sine of amplitude A reads A at its frequency.
///
/// Segments of some 3 s, each overlapping half of the one before, less their mean, through a Hann
/// window and a fast Fourier transform; the root mean square of their amplitudes (Welch's method).
/// The level of noise depends on the resolution. Content above half the sample rate aliases below
/// it.
///
/// @return empty with fewer than 16 samples
Spectrum amplitude_spectrum(std::span<const double> samples, double rate_hz);

}  // namespace cas::hils
