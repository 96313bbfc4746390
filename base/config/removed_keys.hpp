// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <string>

#include "base/config/config.hpp"

namespace cas::base {

/// A key of earlier versions that files may still have.
struct RemovedKey {
  const char* name;
  const char* now;  ///< the rule in its place: "a system is kept for 60 s"
};

/// Refuses a block that has one of the keys. Without this a removed key would be reported as a
/// misspelt one.
/// @throws ConfigError "FILE:LINE: key.path: is no longer a key: NOW"
inline void refuse_removed(const ConfigNode& block, std::initializer_list<RemovedKey> keys) {
  for (const RemovedKey& key : keys) {
    if (const auto node = block.find(key.name)) {
      node->fail(std::string("is no longer a key: ") + key.now);
    }
  }
}

}  // namespace cas::base
