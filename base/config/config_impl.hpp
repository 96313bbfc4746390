// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/config/config.hpp"
#include "base/config/config_document.hpp"

namespace cas::base {

/// A place in a document's tree. For the sources of ConfigNode only.
struct ConfigNode::Impl {
  std::shared_ptr<const ConfigDocument> document;  // keeps `tree` alive
  const ConfigTree* tree = nullptr;
  std::string path;
  std::shared_ptr<const Impl> defaults = nullptr;  // map behind this one, see merged_over()

  ConfigNode child(const ConfigTree& below, std::string child_path) const {
    return ConfigNode(std::make_shared<const Impl>(Impl{document, &below, std::move(child_path)}));
  }
  ConfigNode entry(std::string_view key, const ConfigTree& below) const {
    return child(below, path.empty() ? std::string(key) : path + "." + std::string(key));
  }
  /// The value of `key`: `below` alone, or merged over `behind`.
  ConfigNode over(std::string_view key, const ConfigTree& below,
                  const std::optional<ConfigNode>& behind) const {
    const ConfigNode node = entry(key, below);
    if (!behind) return node;
    if (node.is_map() && behind->is_map()) return node.merged_over(*behind);
    behind->mark_used();
    return node;
  }
  ConfigNode item(std::size_t index) const {
    return child(*tree->items[index], path + "[" + std::to_string(index) + "]");
  }

  /// Notes that a reader knows `key`, whether the file has it or not: for suggestions, so that
  /// a map of very many keys need not have all of them here.
  void want(std::string_view key) const {
    constexpr std::size_t kMostWanted = 500;
    auto& wanted = tree->wanted;
    if (wanted.size() == kMostWanted) return;
    if (std::find(wanted.begin(), wanted.end(), key) == wanted.end()) wanted.emplace_back(key);
  }
};

/// A word as errors quote it.
inline std::string in_quotes(std::string_view word) {
  return std::string("'").append(word).append("'");
}

}  // namespace cas::base
