// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cas::fcu {

struct FcuCore;
struct MixerResult;

/// Sends U1..U4 as shares of their full scales (HIL_CONTROLS), or the four motor outputs
/// (HIL_ACTUATOR_CONTROLS) where CAS_HIL_ACT says so.
///
/// @param time_usec  stamp of the HIL_SENSOR that the answer was computed from; it is echoed
void send_answer(const MixerResult& output, std::uint64_t time_usec, FcuCore& core);

}  // namespace cas::fcu
