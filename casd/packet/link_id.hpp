// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cas::casd {

/// Slot of a link in the router, 0..63. A link keeps its slot for life, also over a reload.
using LinkId = std::uint8_t;
/// A set of links, bit i for link i.
using LinkMask = std::uint64_t;

inline constexpr int kMaxLinks = 64;
/// casd's own station (commander): the last slot, never used by a real link.
inline constexpr LinkId kLocalLink = 63;
inline constexpr LinkId kNoLink = 255;

constexpr LinkMask bit(LinkId link) { return LinkMask{1} << link; }

}  // namespace cas::casd
