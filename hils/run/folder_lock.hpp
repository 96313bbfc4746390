// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "base/os/descriptor.hpp"

namespace cas::hils {

/// Keeps other runs out of a folder of results until it is destroyed, or the process ends in any
/// way.
class FolderLock {
 public:
  /// @param folder  that exists @throws base::ConfigError if another run has it
  explicit FolderLock(const std::filesystem::path& folder);

 private:
  base::Descriptor folder_;
};

}  // namespace cas::hils
