// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/rpc/description.hpp"

namespace cas::casd {

/// Description of casd's methods and topics, for `rpc.discover`. tests/python compares it with
/// docs/develop/protocol.md and with the calls and answers of a running casd.
///
/// @param version  of casd
base::rpc::Description port_description(std::string version);

}  // namespace cas::casd
