// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstdint>

#include "base/os/mutex.hpp"

namespace cas::casd {

/// A set of 64 slots, bit i for slot i: the peers of a server link, or 64 links of a LinkMask.
using SlotMask = std::uint64_t;
inline constexpr int kSlots = 64;

constexpr SlotMask slot_bit(std::uint8_t slot) { return SlotMask{1} << slot; }

/// Calls visit(slot) for each slot of the set, the lowest first. `visit` may require a lock
/// (CAS_REQUIRES), which its caller holds.
template <class Visit>
constexpr void for_each_slot(SlotMask slots, Visit&& visit)
    CAS_THREAD_SAFETY(no_thread_safety_analysis) {
  for (; slots != 0; slots &= slots - 1) visit(static_cast<std::uint8_t>(std::countr_zero(slots)));
}

}  // namespace cas::casd
