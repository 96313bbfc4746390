// SPDX-License-Identifier: BSD-3-Clause
#include "base/config.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <type_traits>

#include "base/config_document.hpp"

namespace cas::base {

struct ConfigNode::Impl {
  std::shared_ptr<const ConfigDocument> document;  // keeps `tree` alive
  const ConfigTree* tree = nullptr;
  std::string path;
  std::shared_ptr<const Impl> defaults = nullptr;  // map behind this one, see merged_over()

  ConfigNode child(const ConfigTree& below, std::string child_path) const {
    return ConfigNode(std::make_shared<const Impl>(Impl{document, &below, std::move(child_path), {}}));
  }
  ConfigNode entry(std::string_view key, const ConfigTree& below) const {
    return child(below, path.empty() ? std::string(key) : path + "." + std::string(key));
  }
  ConfigNode item(std::size_t index) const {
    return child(*tree->items[index], path + "[" + std::to_string(index) + "]");
  }

  /// Notes that somebody knows `key`, whether the file has it or not.
  void want(std::string_view key) const {
    auto& wanted = tree->wanted;
    if (std::find(wanted.begin(), wanted.end(), key) == wanted.end()) wanted.emplace_back(key);
  }
};

namespace {

std::string in_quotes(std::string_view word) { return std::string("'").append(word).append("'"); }

/// Parses the whole of `text`; a leading '+' is allowed.
template <class T>
bool parse_whole(std::string_view text, T& value) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end;
}

/// A plain (unquoted) scalar's text, or a failure that says what was expected.
const std::string& plain_scalar(const ConfigNode& node, const ConfigTree& tree,
                                const char* expected) {
  if (tree.kind == ConfigTree::Kind::kNull)
    node.fail(std::string("has no value; expected ") + expected);
  if (tree.kind != ConfigTree::Kind::kScalar) node.fail(std::string("expected ") + expected);
  if (tree.quoted) node.fail(std::string("is a text in quotes; expected ") + expected);
  return tree.scalar;
}

template <class T>
T to_integer(const ConfigNode& node, const ConfigTree& tree) {
  const char* const expected =
      std::is_unsigned_v<T> ? "a whole number, not negative" : "a whole number";
  const std::string& text = plain_scalar(node, tree, expected);
  T value{};
  if (!parse_whole(text, value)) {
    node.fail(in_quotes(text) + " is not " + expected + " in range");
  }
  return value;
}

double to_double(const ConfigNode& node, const ConfigTree& tree) {
  const std::string& text = plain_scalar(node, tree, "a number");
  double value = 0;
  if (!parse_whole(text, value)) node.fail(in_quotes(text) + " is not a number, or out of range");
  if (!std::isfinite(value)) node.fail(in_quotes(text) + " is not a finite number");
  return value;
}

bool to_bool(const ConfigNode& node, const ConfigTree& tree) {
  const std::string& text = plain_scalar(node, tree, "true or false");
  if (text == "true") return true;
  if (text != "false") node.fail(in_quotes(text) + " is neither true nor false");
  return false;
}

std::string to_text(const ConfigNode& node, const ConfigTree& tree) {
  if (tree.kind == ConfigTree::Kind::kNull) node.fail("has no value; expected a text");
  if (tree.kind != ConfigTree::Kind::kScalar) node.fail("expected a text");
  return tree.scalar;
}

template <class T>
std::vector<T> to_vector(const ConfigNode& node) {
  std::vector<T> values;
  for (const ConfigNode& item : node.items()) values.push_back(item.as<T>());
  return values;
}

template <int N>
Eigen::Matrix<double, N, 1> to_eigen(const ConfigNode& node) {
  if (!node.is_list()) node.fail("expected a list of " + std::to_string(N) + " numbers");
  const std::vector<double> values = to_vector<double>(node);
  if (values.size() != N) {
    node.fail("has " + std::to_string(values.size()) + " numbers; expected " + std::to_string(N));
  }
  return Eigen::Map<const Eigen::Matrix<double, N, 1>>(values.data());
}

std::string shortest(double value) {
  char text[32];
  const auto result = std::to_chars(std::begin(text), std::end(text), value);
  return std::string(text, result.ptr);
}

void check_range(const ConfigNode& node, double value, double low, double high) {
  if (value >= low && value <= high) return;
  node.fail(shortest(value) + " must lie in [" + shortest(low) + ", " + shortest(high) + "]");
}

}  // namespace

ConfigNode ConfigNode::load(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    throw ConfigError(file.string() + ": is a folder, not a file");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ConfigError(file.string() + ": cannot be read");
  std::ostringstream text;
  text << stream.rdbuf();
  return parse(text.str(), file.string());
}

ConfigNode ConfigNode::parse(std::string_view text, const std::string& name) {
  const auto document = parse_config(text, name);
  return ConfigNode(std::make_shared<const Impl>(Impl{document, &document->root, "", {}}));
}

ConfigNode ConfigNode::empty(const std::string& name) {
  const auto document = std::make_shared<ConfigDocument>();
  document->file = name;
  document->root.kind = ConfigTree::Kind::kMap;
  return ConfigNode(std::make_shared<const Impl>(Impl{document, &document->root, "", {}}));
}

bool ConfigNode::is_map() const { return impl_->tree->kind == ConfigTree::Kind::kMap; }
bool ConfigNode::is_list() const { return impl_->tree->kind == ConfigTree::Kind::kList; }
bool ConfigNode::is_scalar() const { return impl_->tree->kind == ConfigTree::Kind::kScalar; }
bool ConfigNode::is_null() const { return impl_->tree->kind == ConfigTree::Kind::kNull; }

ConfigNode ConfigNode::at(std::string_view key) const {
  if (const std::optional<ConfigNode> child = find(key)) return *child;
  std::vector<std::string> unknown;  // a key that nobody asked for may be this one, mistyped
  for (const auto& [name, child] : impl_->tree->entries) {
    if (!child->used) unknown.push_back(name);
  }
  const std::string near = nearest_word(key, unknown);
  std::string sentence = "key " + in_quotes(key) + " is missing";
  if (!near.empty()) {
    sentence += "; did you mean it by " + in_quotes(near) + " on line " +
                std::to_string(impl_->tree->find(near)->line) + "?";
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
  if (behind) behind->mark_used();
  child->used = true;
  return impl_->entry(key, *child);
}

double ConfigNode::require_in(std::string_view key, double low, double high) const {
  const ConfigNode child = at(key);
  const double value = child.as<double>();
  check_range(child, value, low, high);
  return value;
}

double ConfigNode::get_in(std::string_view key, double fallback, double low, double high) const {
  return has(key) ? require_in(key, low, high) : fallback;
}

template <class T>
T ConfigNode::as() const {
  const ConfigTree& tree = *impl_->tree;
  if constexpr (std::is_same_v<T, bool>) {
    return to_bool(*this, tree);
  } else if constexpr (std::is_integral_v<T>) {
    return to_integer<T>(*this, tree);
  } else if constexpr (std::is_same_v<T, double>) {
    return to_double(*this, tree);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return to_text(*this, tree);
  } else if constexpr (std::is_same_v<T, std::vector<double>> ||
                       std::is_same_v<T, std::vector<std::string>>) {
    return to_vector<typename T::value_type>(*this);
  } else {
    return to_eigen<T::RowsAtCompileTime>(*this);
  }
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
  for (const auto& [key, child] : impl_->tree->entries) {
    child->used = true;
    nodes.emplace_back(key, impl_->entry(key, *child));
  }
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
}

void ConfigNode::fail(std::string_view sentence) const {
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

template bool ConfigNode::as<bool>() const;
template int ConfigNode::as<int>() const;
template unsigned ConfigNode::as<unsigned>() const;
template std::int64_t ConfigNode::as<std::int64_t>() const;
template std::uint64_t ConfigNode::as<std::uint64_t>() const;
template double ConfigNode::as<double>() const;
template std::string ConfigNode::as<std::string>() const;
template std::vector<double> ConfigNode::as<std::vector<double>>() const;
template std::vector<std::string> ConfigNode::as<std::vector<std::string>>() const;
template Eigen::Vector3d ConfigNode::as<Eigen::Vector3d>() const;
template Eigen::Vector4d ConfigNode::as<Eigen::Vector4d>() const;

}  // namespace cas::base
