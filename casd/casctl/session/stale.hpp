// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::casctl {

/// Older values are shown as old, or not at all: vehicles send the slowest of the messages that
/// casctl shows every other second.
inline constexpr double kStale_s = 3;

}  // namespace cas::casctl
