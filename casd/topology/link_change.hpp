// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// The topology with one more link, the last of its links.
///
/// `request` has an `entry` like those of `links`. It may have `endpoint` in place of type and
/// addresses (parse_endpoint); the name is then optional. `routes` is a list as in a topology, each
/// entry from or to the new link. The defaults are narrow: without `accept` the link takes in the
/// traffic of ground stations, but nothing with the id of one of `vehicles` or of casd; without
/// `routes` it exchanges everything but HIL messages with every other link. `accept: everything`
/// takes in all packets.
///
/// @throws base::ConfigError "NAME:LINE: entry.key: sentence"
Topology with_link(Topology topology, const base::ConfigNode& request,
                   const std::vector<std::uint8_t>& vehicles);

/// The topology without a link and its routes.
/// @throws base::ConfigError when there is no link of that name, or it is the only one
Topology without_link(Topology topology, const std::string& name);

}  // namespace cas::casd
