// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/export.hpp"

namespace cas::base::rpc {

/// Reads the first line of a secret's file. @throws ConfigError when it cannot be read, it belongs
/// to another user than root, this one and that of the service, others than its owner may read or
/// write it, or the secret has fewer than 16 characters
CAS_BASE_EXPORT std::string read_token(const std::filesystem::path& file);

/// Makes a secret's file with 256 random bits of the kernel as 64 hexadecimal digits, mode 0600, if
/// the path is free. An existing entry stays, even a dangling symlink.
/// @return whether it was made @throws ConfigError when it cannot be made
CAS_BASE_EXPORT bool make_token(const std::filesystem::path& file);

/// Compares in a time that depends on the length of `given` alone.
CAS_BASE_EXPORT bool same_token(std::string_view expected, std::string_view given);

}  // namespace cas::base::rpc
