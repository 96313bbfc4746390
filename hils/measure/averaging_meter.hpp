// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

namespace cas::hils {

/// What the message inspector of QGroundControl 3, the instrument of [HILS] Table 4, would have
/// shown: it counts in periods of one second and shows an exponential mean with gain 0.2 that
/// starts at zero; the first message is not counted. A true 500 Hz reads 446 after 10 s.
///
/// @param arrivals_ns  moments of arrival, in order
/// @param until_ns     moment of reading
double averaging_meter_hz(std::span<const std::int64_t> arrivals_ns, std::int64_t until_ns);

}  // namespace cas::hils
