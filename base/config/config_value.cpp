// SPDX-License-Identifier: BSD-3-Clause
// Values of ConfigNode: from a scalar's text to numbers, words and vectors.
#include <fmt/format.h>
#include <Eigen/Core>
#include <iterator>
#include <type_traits>

#include "base/config/config.hpp"
#include "base/config/config_document.hpp"
#include "base/config/config_impl.hpp"
#include "base/config/config_whole.hpp"
#include "base/number_text.hpp"

namespace cas::base {
namespace {

/// A plain (unquoted) scalar's text, or a failure that names the expected kind.
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
  if (const auto value = number_of<T>(text)) return *value;
  const bool is_fraction = number_of<double>(text) && text.find_first_of(".eE") != text.npos;
  if (is_fraction) node.fail(in_quotes(text) + " must be a whole number");
  node.fail(in_quotes(text) + " is not " + expected + " in range");
}

double to_double(const ConfigNode& node, const ConfigTree& tree) {
  const std::string& text = plain_scalar(node, tree, "a number");
  if (const auto value = number_of<double>(text)) return *value;
  node.fail(in_quotes(text) + " is not a number, or out of range" + number_hint(text));
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
  if (!node.is_list()) node.fail(fmt::format("expected a list of {} numbers", N));
  const std::vector<double> values = to_vector<double>(node);
  if (values.size() != N) {
    node.fail(fmt::format("has {} numbers; expected {}", values.size(), N));
  }
  return Eigen::Map<const Eigen::Matrix<double, N, 1>>(values.data());
}

}  // namespace

std::string number_text(double value) {
  char text[32];
  const auto result = std::to_chars(std::begin(text), std::end(text), value);
  return std::string(text, result.ptr);
}

double number_in(const ConfigNode& node, double low, double high) {
  const std::string range = "[" + number_text(low) + ", " + number_text(high) + "]";
  if (!node.is_null() && !node.is_map() && !node.is_list()) {
    const auto text = node.as<std::string>();
    if (!number_of<double>(text)) {
      node.fail(in_quotes(text) + " is not a number in " + range + number_hint(text));
    }
  }
  const double value = node.as<double>();
  if (value >= low && value <= high) return value;
  node.fail(number_text(value) + " must lie in " + range);
}

std::int64_t whole_in(const ConfigNode& node, std::int64_t low, std::int64_t high) {
  const auto value = node.as<std::int64_t>();
  if (value >= low && value <= high) return value;
  node.fail(fmt::format("{} must lie in [{}, {}]", value, low, high));
}

double ConfigNode::require_in(std::string_view key, double low, double high) const {
  return number_in(at(key), low, high);
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
