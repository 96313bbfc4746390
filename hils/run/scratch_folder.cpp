// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/scratch_folder.hpp"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/error.hpp"

namespace cas::hils {

std::filesystem::path fresh_folder(const std::filesystem::path& parent, const std::string& prefix) {
  std::error_code exists;
  std::filesystem::create_directories(parent, exists);
  std::string name = (parent / (prefix + "-XXXXXX")).string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw base::ConfigError(name + ": cannot be made: " + std::strerror(errno));
  }
  return name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace cas::hils
