// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <string>

#include "base/config/config.hpp"

namespace cas::base {

/// A key that files written for earlier versions may have.
struct RemovedKey {
  const char* name;
  const char* now;  ///< what holds without it: "a system is kept for 60 s"
};

/// Refuses the first of these that a block has, so that it is not taken for a misspelt one.
/// @throws ConfigError "FILE:LINE: key.path: is no longer a key: NOW"
inline void refuse_removed(const ConfigNode& block, std::initializer_list<RemovedKey> keys) {
  for (const RemovedKey& key : keys) {
    if (const auto node = block.find(key.name)) {
      node->fail(std::string("is no longer a key: ") + key.now);
    }
  }
}

}  // namespace cas::base
