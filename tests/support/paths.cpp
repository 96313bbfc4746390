// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/paths.hpp"

namespace cas::test {

const std::string& source_dir() {
  static const std::string folder = CAS_SOURCE_DIR;
  return folder;
}

const std::string& binary_dir() {
  static const std::string folder = CAS_BINARY_DIR;
  return folder;
}

}  // namespace cas::test
