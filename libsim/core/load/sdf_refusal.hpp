// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// Says why a file that libsdformat has refused is no world. @throws base::ConfigError always, with
/// the line where there is one, and the remedy
[[noreturn]] void refuse_sdf(const std::filesystem::path& file, const sdf::Errors& errors);

}  // namespace cas::sim
