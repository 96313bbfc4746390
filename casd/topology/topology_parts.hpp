// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {

/// One entry of `links`. @throws ConfigError
LinkConfig parse_link(const base::ConfigNode& node);

/// One entry of `routes`; `from` and `to` take a name, a list of names or `any`, so that it stands
/// for several routes. @throws ConfigError
std::vector<RouteConfig> parse_route(const base::ConfigNode& node,
                                     const std::vector<LinkConfig>& links);

/// One message or a list of them, by name or by number. @throws ConfigError
std::vector<std::uint32_t> parse_messages(const base::ConfigNode& node);

/// `key` of `node`: one id from 0 to 255 or a list of them; empty without the key.
/// @throws ConfigError
std::vector<std::uint8_t> parse_bytes(const base::ConfigNode& node, std::string_view key);

/// `accept` and `signing` of a link. @throws ConfigError
AcceptRule parse_accept(const base::ConfigNode& node);
SigningConfig parse_signing(const base::ConfigNode& node);

}  // namespace cas::casd
