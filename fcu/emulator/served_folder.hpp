// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mavlink_gen/services/ftp_server.hpp"

namespace cas::fcu {

/// A folder of this machine for an FtpServer, read only. Links that lead out of the folder are
/// hidden; of a folder at most 8192 entries are listed.
class ServedFolder final : public mav::services::ReadOnlyFtpStore {
 public:
  using Failure = mav::services::FtpFailure;

  /// @throws base::ConfigError when there is no such folder
  explicit ServedFolder(const std::filesystem::path& folder);

  Failure list(const std::string& folder, std::vector<mav::services::FtpEntry>& entries) override;
  Failure length(const std::string& path, std::uint32_t& bytes) override;
  Failure read(const std::string& path, std::uint32_t offset,
               std::span<std::uint8_t>& out) override;

 private:
  std::optional<std::filesystem::path> inside(const std::filesystem::path& path) const;

  std::filesystem::path folder_;  ///< without symbolic links
};

}  // namespace cas::fcu
