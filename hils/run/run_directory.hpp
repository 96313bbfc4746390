// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace cas::hils {

/// A private folder with a short path, for sockets and the PTY's link; removed at the end.
class RunDirectory {
 public:
  /// Below XDG_RUNTIME_DIR, else below the temporary folder. @throws base::ConfigError
  RunDirectory();
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// UDP ports of 127.0.0.1 that are free now, all different. @throws base::ConfigError
std::vector<std::uint16_t> free_udp_ports(std::size_t count);

}  // namespace cas::hils
