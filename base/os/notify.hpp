// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "base/export.hpp"

namespace cas::base {

/// Sends a state such as "READY=1\nSTATUS=udp 14560" to NOTIFY_SOCKET (systemd's protocol, also
/// spoken by hils). Does nothing without that variable. @return false when sending failed
CAS_BASE_EXPORT bool notify(std::string_view state);

}  // namespace cas::base
