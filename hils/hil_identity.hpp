// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

/// The stamp that, with the message id, is a HIL packet's identity in every ledger; nothing for
/// other packets.
std::optional<std::uint64_t> hil_time_usec(const mav::PacketView& packet);

}  // namespace cas::hils
