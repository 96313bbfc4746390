// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>

#include "casd/topology/link_config.hpp"

namespace cas::casd {

struct CommandPortConfig;

/// Whether the link cannot be beside these others of the same casd: it listens where one of them
/// listens, or one sends to the other on this machine, so that each packet would come back for
/// ever. Addresses are compared as they are written; names other than localhost are not looked up.
/// @return the sentence; nothing if there is no conflict
std::optional<std::string> endpoint_conflict(const LinkConfig& link,
                                             std::span<const LinkConfig> others);
/// Whether the link listens at the command port. @return the sentence; nothing if it does not
std::optional<std::string> endpoint_conflict(const LinkConfig& link, const CommandPortConfig& port);

}  // namespace cas::casd
