// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "casd/routing/routing_rules.hpp"

namespace cas::base {
class ConfigNode;
struct KeyRow;
}  // namespace cas::base

namespace cas::casd {

struct LinkConfig;

/// One entry of `routes`, with the names of its links.
struct RouteConfig {
  std::string from;
  std::string to;
  ForwardRule rule;  ///< its link ids are filled in by make_plan()

  friend bool operator==(const RouteConfig&, const RouteConfig&) = default;
};

/// The routes of one entry of `routes`: `from` and `to` take a name, a list of names or `any`.
/// @throws base::ConfigError
std::vector<RouteConfig> parse_route(const base::ConfigNode& node,
                                     const std::vector<LinkConfig>& links);
/// Routes of a topology without `routes`: every link talks to every other one.
std::vector<RouteConfig> routes_between_all(const std::vector<LinkConfig>& links);

/// A route's filters as `casd --check` prints them: "only HIL_SENSOR, not systems 2".
std::string rule_text(const ForwardRule& rule);

/// Keys of one entry of `routes`.
std::vector<base::KeyRow> route_rows();

}  // namespace cas::casd
