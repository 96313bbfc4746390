// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace cas::hils {

/// Entries of a ledger on the virtual clock: about two minutes of flight.
inline constexpr std::size_t kLedgerEntries = 1 << 17;

}  // namespace cas::hils
