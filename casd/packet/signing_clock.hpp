// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

#include "mavlink_gen/runtime/signing.hpp"

namespace cas::casd {

/// How far the time of signatures may be ahead of the clock before casd's log, link.list and
/// `casctl doctor` call it wrong. Each restart puts it a minute ahead, so ten in a row are borne.
inline constexpr mav::SigningTime kMaxPlausibleLead = 600 * mav::kSigningUnitsPerSecond;

/// The wall clock as signatures count it.
inline mav::SigningTime signing_clock() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(since_1970).count();
  return mav::signing_time(us < 0 ? 0 : static_cast<std::uint64_t>(us));
}

}  // namespace cas::casd
