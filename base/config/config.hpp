// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/export.hpp"

// Eigen's vectors by name alone: most readers of a configuration use none, and its headers cost
// three seconds a file.
namespace Eigen {
template <typename Scalar, int Rows, int Cols, int Options, int MaxRows, int MaxCols>
class Matrix;
}

namespace cas::base {

/// One node of a YAML file, with its file, line and key path. Every error is a ConfigError that
/// reads "FILE:LINE: key.path: sentence". Duplicate keys are refused when the file is read; keys
/// that were never read are refused by `reject_unused()`, with the nearest known key as a
/// suggestion.
///
/// Copies are cheap and share the document. Not for use from several threads at once.
class CAS_BASE_EXPORT ConfigNode {
 public:
  /// Reads a file. @throws ConfigError when it cannot be read, parsed, or repeats a key
  static ConfigNode load(const std::filesystem::path& file);
  /// Parses a text; `name` replaces the file's name in errors. @throws ConfigError as load()
  static ConfigNode parse(std::string_view text, const std::string& name = "<text>");
  /// An empty map, so that optional blocks read like present ones.
  static ConfigNode empty(const std::string& name = "<none>");

  bool is_map() const;
  bool is_list() const;
  /// A single value: text, number or bool.
  bool is_scalar() const;
  /// A key without a value, or `null`.
  bool is_null() const;

  /// The child under `key`. @throws ConfigError when it is missing
  ConfigNode at(std::string_view key) const;
  /// The child under `key`, or nothing. Counts as a use of the key.
  std::optional<ConfigNode> find(std::string_view key) const;
  /// Whether the key is there. Counts as a use of it.
  bool has(std::string_view key) const { return find(key).has_value(); }

  /// The value of a mandatory key. T: bool, int, unsigned, std::int64_t, std::uint64_t, double,
  /// std::string, std::vector<double>, std::vector<std::string>, and where <Eigen/Core> is included
  /// Eigen::Vector3d, Eigen::Vector4d.
  /// @throws ConfigError when it is missing or of another kind
  template <class T>
  T require(std::string_view key) const {
    return at(key).as<T>();
  }
  /// The value of an optional key. @throws ConfigError when it is of another kind
  template <class T>
  T get(std::string_view key, T fallback) const {
    const std::optional<ConfigNode> child = find(key);
    return child ? child->as<T>() : fallback;
  }
  /// A number that must lie in [low, high]. @throws ConfigError when it does not, or is missing
  double require_in(std::string_view key, double low, double high) const;
  /// The same for an optional key.
  double get_in(std::string_view key, double fallback, double low, double high) const;

  /// This node's own value. @throws ConfigError when it is of another kind
  template <class T>
  T as() const;

  /// The elements of a list. @throws ConfigError when it is none
  std::vector<ConfigNode> items() const;
  /// The entries of a map in file order. Counts as a use of each key.
  /// @throws ConfigError when it is none
  std::vector<std::pair<std::string, ConfigNode>> entries() const;

  /// This map with the keys of `defaults` that it lacks; for a key in both, this map's value
  /// counts. Errors name the file of the value.
  ConfigNode merged_over(const ConfigNode& defaults) const;

  /// @throws ConfigError for the first key below this node that was never read
  void reject_unused() const;
  /// For a block that another program or plugin reads: reject_unused() of the nodes above passes
  /// it by; its own reader's reject_unused() still checks it.
  void mark_used() const;

  /// @throws ConfigError "FILE:LINE: key.path: sentence"
  [[noreturn]] void fail(std::string_view sentence) const;

  std::string path() const;            ///< key path, "links[1].device"
  int line() const;                    ///< from 1; 0 where unknown
  std::filesystem::path file() const;  ///< as given to load()
  std::filesystem::path resolve(
      std::string_view relative) const;  ///< relative to the file's folder
  std::string dump() const;              ///< this subtree as YAML text, without defaults behind it

 private:
  struct Impl;
  explicit ConfigNode(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// Defined for the types named at require().
extern template CAS_BASE_EXPORT bool ConfigNode::as<bool>() const;
extern template CAS_BASE_EXPORT int ConfigNode::as<int>() const;
extern template CAS_BASE_EXPORT unsigned ConfigNode::as<unsigned>() const;
extern template CAS_BASE_EXPORT std::int64_t ConfigNode::as<std::int64_t>() const;
extern template CAS_BASE_EXPORT std::uint64_t ConfigNode::as<std::uint64_t>() const;
extern template CAS_BASE_EXPORT double ConfigNode::as<double>() const;
extern template CAS_BASE_EXPORT std::string ConfigNode::as<std::string>() const;
extern template CAS_BASE_EXPORT std::vector<double> ConfigNode::as<std::vector<double>>() const;
extern template CAS_BASE_EXPORT std::vector<std::string> ConfigNode::as<std::vector<std::string>>()
    const;
extern template CAS_BASE_EXPORT Eigen::Matrix<double, 3, 1, 0, 3, 1>
ConfigNode::as<Eigen::Matrix<double, 3, 1, 0, 3, 1>>() const;
extern template CAS_BASE_EXPORT Eigen::Matrix<double, 4, 1, 0, 4, 1>
ConfigNode::as<Eigen::Matrix<double, 4, 1, 0, 4, 1>>() const;

}  // namespace cas::base
