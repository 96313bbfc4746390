// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/export.hpp"

namespace cas::base {

/// Runtime folder of casd as a service: the unit's RuntimeDirectory.
inline constexpr const char* kServiceFolder = "/run/cas";

/// Folder of one user's links of emulated lines and sockets. The first of
///   $CAS_RUNTIME_DIR
///   $XDG_RUNTIME_DIR/cas      where that folder is there and may be written to
///   `service_folder`          where it may be written to: that of casd.service
///   /tmp/cas-UID              made, mode 0700; a folder of another user is refused
/// The folder need not exist yet. @throws ConfigError
CAS_BASE_EXPORT std::filesystem::path runtime_folder(
    const std::filesystem::path& service_folder = kServiceFolder);

/// `text` with the value of an environment variable for each ${NAME}; for ${CAS_RUNTIME_DIR}, where
/// it is not set, runtime_folder(). @throws ConfigError "environment variable NAME is not set"
CAS_BASE_EXPORT std::string expand_variables(std::string_view text);

}  // namespace cas::base
