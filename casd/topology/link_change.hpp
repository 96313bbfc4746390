// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// The topology with one more link, the last of its links.
///
/// `request` has an `entry` as `links` has them; `endpoint` stands for its type and place
/// (parse_endpoint), and then a name is found for it. `routes` is a list as in a topology, each of
/// whose entries has to do with the new link. What is left out is narrow: without `accept` the link
/// takes in what ground stations say and nobody who claims to be one of `vehicles` or casd; without
/// `routes` it exchanges everything but HIL messages with every other link. `accept: everything`
/// says that nothing is left out.
///
/// @throws base::ConfigError "NAME:LINE: entry.key: sentence"
Topology with_link(Topology topology, const base::ConfigNode& request,
                   const std::vector<std::uint8_t>& vehicles);

/// The topology without a link and its routes.
/// @throws base::ConfigError when there is none of that name, or no other
Topology without_link(Topology topology, const std::string& name);

}  // namespace cas::casd
