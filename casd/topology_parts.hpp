// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "base/config.hpp"
#include "casd/topology.hpp"

namespace cas::casd {

/// One entry of `links`. @throws ConfigError
LinkConfig parse_link(const base::ConfigNode& node);

/// One entry of `routes`; `from` and `to` take a name, a list of names or `any`, so that it stands
/// for several routes. @throws ConfigError
std::vector<RouteConfig> parse_route(const base::ConfigNode& node,
                                     const std::vector<LinkConfig>& links);

}  // namespace cas::casd
