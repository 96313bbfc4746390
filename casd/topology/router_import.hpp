// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "casd/topology/router_config.hpp"

namespace cas::casd {

/// A topology made from the configuration of mavlink-router, with what casd does otherwise.
struct ImportedTopology {
  std::string yaml;                ///< a topology file; its head has the notes as comments
  std::vector<std::string> notes;  ///< "FILE:LINE: key: " and how casd differs, by line
};

/// casd's topology of a configuration of mavlink-router (main.conf: General, UartEndpoint,
/// UdpEndpoint, TcpEndpoint).
/// @param files  one at least
/// @throws base::ConfigError "FILE:LINE: sentence"
ImportedTopology import_mavlink_router(const std::vector<RouterFile>& files);

}  // namespace cas::casd
