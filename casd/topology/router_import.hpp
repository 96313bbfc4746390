// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cas::casd {

struct ImportedTopology {
  std::string yaml;                ///< a topology file; its head has the notes as comments
  std::vector<std::string> notes;  ///< "LINE: key: what casd does otherwise or not at all"
};

/// casd's topology of a configuration of mavlink-router (main.conf: General, UartEndpoint,
/// UdpEndpoint, TcpEndpoint). Names of sections and keys may have any case.
/// @param file  for errors
/// @throws base::ConfigError "FILE:LINE: sentence"
ImportedTopology import_mavlink_router(std::string_view text, const std::string& file);

}  // namespace cas::casd
