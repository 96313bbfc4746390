// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cas::casd {

struct ImportedTopology {
  std::string yaml;                ///< a topology file; its head has the notes as comments
  std::vector<std::string> notes;  ///< "FILE:LINE: key: " and how casd differs
};

/// One file of mavlink-router's configuration.
struct RouterFile {
  std::string name;  ///< for errors
  std::string text;
};

/// main.conf and the files of config.d beside it, in the order of their names as mavlink-router
/// reads them. @throws base::ConfigError when one cannot be read
std::vector<RouterFile> read_router_files(const std::filesystem::path& main);

/// casd's topology of a configuration of mavlink-router (main.conf: General, UartEndpoint,
/// UdpEndpoint, TcpEndpoint). Names of sections and keys may have any case; of a key that comes
/// again the last value counts.
/// @param files  one at least
/// @throws base::ConfigError "FILE:LINE: sentence"
ImportedTopology import_mavlink_router(const std::vector<RouterFile>& files);

}  // namespace cas::casd
