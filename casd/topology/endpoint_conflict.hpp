// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>

#include "casd/topology/link_config.hpp"

namespace cas::casd {

struct CommandPortConfig;

/// Reason why the link cannot run beside these others of the same casd: it listens where one of
/// them listens, or one sends to the other on this machine, so that packets would come back for
/// ever. Addresses are compared as they are written: names, and this machine's own addresses in a
/// network, are not looked up.
/// @return a sentence; nullopt if it can
std::optional<std::string> endpoint_conflict(const LinkConfig& link,
                                             std::span<const LinkConfig> others);
/// The same for the command port, at which a TCP server cannot listen.
std::optional<std::string> endpoint_conflict(const LinkConfig& link, const CommandPortConfig& port);

/// The link that leads to this link's peer already, by the same path: a second one would bring each
/// packet twice, and send the peer's own back to it. @return nullptr: there is none
const LinkConfig* link_to_same_peer(const LinkConfig& link, std::span<const LinkConfig> others);

}  // namespace cas::casd
