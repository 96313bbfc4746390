// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cas::casd {

/// How often a vehicle is to send a message.
struct MessageRate {
  std::uint32_t message_id = 0;
  double hz = 0;  ///< 0: not at all

  friend bool operator==(const MessageRate&, const MessageRate&) = default;
};

}  // namespace cas::casd
