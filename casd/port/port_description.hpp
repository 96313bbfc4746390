// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/rpc/description.hpp"

namespace cas::casd {

/// What casd's methods and topics are, for `rpc.discover`. tests/python compares it with
/// docs/protocol.md and with what a running casd takes and answers.
///
/// @param version  of casd
base::rpc::Description port_description(std::string version);

}  // namespace cas::casd
