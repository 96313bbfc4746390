// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace cas::hils {

/// Version of the project.
inline constexpr std::string_view kVersion = CAS_VERSION;

}  // namespace cas::hils
