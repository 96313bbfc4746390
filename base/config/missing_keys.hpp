// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"

namespace cas::base {

/// Collects the keys that are not there, so that one sentence names them all.
class MissingKeys {
 public:
  void need(const ConfigNode& node, std::string_view key) {
    if (!node.find(key)) add(node, key);
  }
  void add(const ConfigNode& node, std::string_view key) {
    missing_.push_back({node, std::string(key)});
  }
  /// @param note  that ends the sentence
  /// @throws ConfigError when there are any
  void check(const ConfigNode& root, const std::string& note) const {
    if (missing_.empty()) return;
    if (missing_.size() == 1) check_one(note);
    std::string names;
    for (const Missing& each : missing_) {
      const std::string path = each.node.path();
      names += (names.empty() ? "'" : ", '") + path + (path.empty() ? "" : ".") + each.key + "'";
    }
    root.fail("keys are missing: " + names + note);
  }

 private:
  /// The node's own sentence, which may suggest a misspelt key.
  void check_one(const std::string& note) const try {
    static_cast<void>(missing_[0].node.at(missing_[0].key));
  } catch (const ConfigError& error) {
    throw ConfigError(error.what() + note);
  }

  struct Missing {
    ConfigNode node;
    std::string key;
  };
  std::vector<Missing> missing_;
};

}  // namespace cas::base
