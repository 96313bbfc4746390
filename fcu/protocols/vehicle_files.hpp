// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fcu/params/params.hpp"
#include "mavlink_gen/services/ftp_server.hpp"

namespace cas::fcu {

/// The files that the controller serves, read only: `params.txt`, which has all parameters as "NAME
/// VALUE" lines, and the files that the shell adds as folder `files`.
class VehicleFiles final : public mav::services::ReadOnlyFtpStore {
 public:
  using Failure = mav::services::FtpFailure;

  explicit VehicleFiles(const ParamStore& params) : params_(params) {}

  /// @param folder  outlives this one
  void add(FtpStore& folder) { folder_ = &folder; }

  Failure list(const std::string& folder, std::vector<mav::services::FtpEntry>& entries) override;
  Failure length(const std::string& path, std::uint32_t& bytes) override;
  Failure read(const std::string& path, std::uint32_t offset,
               std::span<std::uint8_t>& out) override;

 private:
  std::optional<std::string> in_folder(const std::string& path) const;
  const std::string& params_text();

  const ParamStore& params_;
  FtpStore* folder_ = nullptr;
  std::string text_;  ///< of revision_
  std::optional<std::uint64_t> revision_;
};

}  // namespace cas::fcu
