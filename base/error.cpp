// SPDX-License-Identifier: BSD-3-Clause
#include "base/error.hpp"

#include <cstdio>
#include <cstdlib>
#include <system_error>

namespace cas::base {

std::string error_text(int error) { return std::generic_category().message(error); }

void check_failed(const char* file, int line, const char* condition) {
  std::fprintf(stderr, "%s:%d: check failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace cas::base
