// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

#include "base/export.hpp"

namespace cas::base {

/// A flag, file or library that the program cannot be built from. `what()` is one sentence that
/// names the place (file, line and key path where there is one); `main` prints it and exits
/// with 78.
class CAS_BASE_EXPORT ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A value of errno in words: "No such file or directory".
CAS_BASE_EXPORT std::string error_text(int error);

/// Exit codes of the daemons (sysexits.h where one fits).
enum ExitCode : int {
  kExitOk = 0,            ///< stopped in good order
  kExitInternal = 70,     ///< EX_SOFTWARE: internal error
  kExitCommandPort = 71,  ///< EX_OSERR: the command port cannot be bound
  kExitConfig = 78,       ///< EX_CONFIG: flags or configuration
};

/// Prints file, line and the failed condition, then aborts. Used through CAS_CHECK.
[[noreturn]] CAS_BASE_EXPORT void check_failed(const char* file, int line, const char* condition);

}  // namespace cas::base

/// Aborts with file and line in every build type when a condition that only a bug can break is
/// false.
#define CAS_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::cas::base::check_failed(__FILE__, __LINE__, #condition))
