// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "mavlink_gen/runtime/signing.hpp"

namespace cas::casd {

/// Reads a key of MAVLink 2 signing from the first line of a file: 64 hexadecimal digits are the
/// key itself, anything else of 16 characters or more is a pass phrase as in ground stations.
/// @throws base::ConfigError when it cannot be read, is too short, or others than its owner may
/// read or write it
mav::SigningKey read_signing_key(const std::filesystem::path& file);

/// Where the time of signatures outlives a restart: a small text file with the bound that no
/// signature has reached yet.
class SigningTimeFile {
 public:
  /// Beside the key file, or in systemd's $STATE_DIRECTORY where there is one.
  explicit SigningTimeFile(const std::filesystem::path& key_file);

  /// The stored bound; 0 when there is none or it cannot be read as one.
  mav::SigningTime load() const;
  /// Replaces it as a whole. @return false when it cannot be written
  bool store(mav::SigningTime bound) const;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace cas::casd
