// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/config.hpp"

#include <algorithm>

#include "base/config/config_document.hpp"
#include "base/config/config_impl.hpp"
#include "base/number_text.hpp"
#include "base/read_file.hpp"
#include "base/suggestion.hpp"

namespace cas::base {
namespace {

/// The line of a key that is there, in the user's own file where this one was generated.
int line_of_key(const ConfigDocument& document, const ConfigTree& tree, const std::string& path,
                const std::string& key) {
  const ConfigOrigin origin = document.origins.of(path.empty() ? key : path + "." + key);
  return origin.file.empty() ? tree.find(key)->line : origin.line;
}

}  // namespace

ConfigNode ConfigNode::load(const std::filesystem::path& file) {
  return parse(read_foreign_file(file, "YAML file", kMaxConfigBytes), file.string());
}

ConfigNode ConfigNode::parse(std::string_view text, const std::string& name) {
  const auto document = parse_config(text, name);
  return ConfigNode(std::make_shared<const Impl>(Impl{document, &document->root, ""}));
}

ConfigNode ConfigNode::empty(const std::string& name) {
  const auto document = std::make_shared<ConfigDocument>();
  document->file = name;
  document->root.kind = ConfigTree::Kind::kMap;
  return ConfigNode(std::make_shared<const Impl>(Impl{document, &document->root, ""}));
}

bool ConfigNode::is_map() const { return impl_->tree->kind == ConfigTree::Kind::kMap; }
bool ConfigNode::is_list() const { return impl_->tree->kind == ConfigTree::Kind::kList; }
bool ConfigNode::is_scalar() const { return impl_->tree->kind == ConfigTree::Kind::kScalar; }
bool ConfigNode::is_null() const { return impl_->tree->kind == ConfigTree::Kind::kNull; }

ConfigNode ConfigNode::at(std::string_view key) const {
  if (const std::optional<ConfigNode> child = find(key)) return *child;
  std::vector<std::string> unknown;  // an unread key may be this one, mistyped
  for (const auto& [name, child] : impl_->tree->entries) {
    if (!child->used) unknown.push_back(name);
  }
  const auto without_unit = std::ranges::find_if(
      unknown, [key](const std::string& name) { return key.starts_with(name + '_'); });
  const std::string near =
      without_unit != unknown.end() ? *without_unit : nearest_word(key, unknown);
  std::string sentence = "key " + in_quotes(key) + " is missing";
  if (!near.empty()) {
    sentence += "; did you mean it by " + in_quotes(near) + " on line " +
                std::to_string(line_of_key(*impl_->document, *impl_->tree, impl_->path, near)) +
                "?";
  }
  fail(sentence);
}

std::optional<ConfigNode> ConfigNode::find(std::string_view key) const {
  if (!is_map() && !is_null()) fail("expected a map with the key " + in_quotes(key));
  impl_->want(key);
  const ConfigTree* const child = impl_->tree->find(key);
  std::optional<ConfigNode> behind;
  if (impl_->defaults) behind = ConfigNode(impl_->defaults).find(key);
  if (child == nullptr) return behind;
  child->used = true;
  return impl_->over(key, *child, behind);
}

std::vector<ConfigNode> ConfigNode::items() const {
  if (!is_list()) fail("expected a list");
  std::vector<ConfigNode> nodes;
  for (std::size_t i = 0; i < impl_->tree->items.size(); ++i) nodes.push_back(impl_->item(i));
  return nodes;
}

std::vector<std::pair<std::string, ConfigNode>> ConfigNode::entries() const {
  if (!is_map() && !is_null()) fail("expected a map");
  std::vector<std::pair<std::string, ConfigNode>> nodes;
  for (const auto& [key, child] : impl_->tree->entries) nodes.emplace_back(key, *find(key));
  if (!impl_->defaults) return nodes;
  for (auto& [key, node] : ConfigNode(impl_->defaults).entries()) {
    if (impl_->tree->find(key) == nullptr) nodes.emplace_back(key, std::move(node));
  }
  return nodes;
}

void ConfigNode::reject_unused() const {
  const ConfigTree& tree = *impl_->tree;
  for (const auto& [key, child] : tree.entries) {
    const ConfigNode node = impl_->entry(key, *child);
    if (child->opaque) continue;
    if (!child->used) {
      // The rest of `{altitude_m: 6,07}`.
      if (child->kind == ConfigTree::Kind::kNull && number_of<double>(key)) {
        node.fail("unknown key" + number_hint(","));
      }
      const std::string near = nearest_word(key, tree.wanted);
      node.fail("unknown key" + (near.empty() ? "" : "; did you mean " + in_quotes(near) + "?"));
    }
    node.reject_unused();
  }
  for (std::size_t i = 0; i < tree.items.size(); ++i) {
    if (!tree.items[i]->opaque) impl_->item(i).reject_unused();
  }
  if (impl_->defaults) ConfigNode(impl_->defaults).reject_unused();
}

ConfigNode ConfigNode::merged_over(const ConfigNode& defaults) const {
  if (!is_map() && !is_null()) fail("expected a map");
  if (!defaults.is_map() && !defaults.is_null()) defaults.fail("expected a map");
  Impl merged = *impl_;
  merged.defaults = defaults.impl_;
  return ConfigNode(std::make_shared<const Impl>(std::move(merged)));
}

void ConfigNode::mark_used() const {
  impl_->tree->used = true;
  impl_->tree->opaque = true;
  if (impl_->defaults) ConfigNode(impl_->defaults).mark_used();
}

void ConfigNode::fail(std::string_view sentence) const {
  const ConfigOrigin origin = impl_->document->origins.of(impl_->path);
  if (!origin.file.empty()) throw ConfigError(origin.text() + ": " + std::string(sentence));
  std::string where = file().string();
  if (line() > 0) where += ":" + std::to_string(line());
  if (!impl_->path.empty()) where += ": " + impl_->path;
  throw ConfigError(where + ": " + std::string(sentence));
}

std::string ConfigNode::path() const { return impl_->path; }
int ConfigNode::line() const { return impl_->tree->line; }
std::filesystem::path ConfigNode::file() const { return impl_->document->file; }

std::filesystem::path ConfigNode::resolve(std::string_view relative) const {
  return (file().parent_path() / std::filesystem::path(relative)).lexically_normal();
}

std::string ConfigNode::dump() const { return dump_config(*impl_->tree); }

}  // namespace cas::base
