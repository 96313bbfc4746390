// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/config/config.hpp"
#include "base/export.hpp"

namespace cas::base {

/// The kinds of YAML files that programs of CAS read.
enum class FileKind { kScenario, kTopology, kVehicle, kWorld, kStudy };

/// Refuses a file of another kind than a program wants, known by a key that only that kind has: a
/// sentence that says what it is helps more than the first key that is missing.
/// @throws ConfigError
CAS_BASE_EXPORT void expect_file(const ConfigNode& root, FileKind wanted);

}  // namespace cas::base
