// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace router_load {

/// Reads every link until g_rxstop; also drops the PTY and brings it back (g_swap).
void rx_thread();

}  // namespace router_load
