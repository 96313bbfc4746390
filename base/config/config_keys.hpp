// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/config_whole.hpp"
#include "base/time/clock.hpp"

/// Each key of a configuration struct stated once, in a tuple of Key: its name, the member that it
/// sets, its allowed values and its meaning. From that one list a file is read (read_keys), values
/// are compared key by key (for_each_key), and the reference is written (add_rows).
namespace cas::base {

/// A key as a reference shows it.
struct KeyRow {
  std::string key;                     ///< path from the struct: "queue.hil_max_age_ms"
  std::string standard;                ///< its default; empty for a key that must be given
  std::string values;                  ///< "0.1 to 60000"; empty: any text
  std::string help;                    ///< its meaning
  std::array<std::string, 2> samples;  ///< two values, as YAML; empty for a whole block
  bool required = false;
};

/// One key. `Steps` are the pointers to members that lead from the struct to the value.
template <class KeyKind, auto... Steps>
struct Key {
  using Kind = KeyKind;
  std::string_view name;
  KeyKind kind;
  std::string_view help;
  std::string_view standard{};  ///< default in words, where the struct's value does not show it
  bool required = false;

  template <class Struct>
  static constexpr auto& of(Struct& whole) {
    return (whole.*....*Steps);
  }
};

template <auto... Steps, class Kind>
constexpr Key<Kind, Steps...> key(std::string_view name, Kind kind, std::string_view help,
                                  std::string_view standard = {}) {
  return {name, kind, help, standard};
}

/// The same key where it must be given.
template <class Kind, auto... Steps>
constexpr Key<Kind, Steps...> required(Key<Kind, Steps...> key) {
  key.required = true;
  return key;
}

/// Calls visit(key) for each key of a list.
template <class Keys, class Visit>
constexpr void for_each_key(const Keys& keys, Visit&& visit) {
  std::apply([&](const auto&... each) { (visit(each), ...); }, keys);
}

// Kinds. Each reads a value from its node and shows one.

/// A key that its owner reads: the others of the struct have to be known for it.
struct ReadApart {
  std::string_view possible;
  std::array<std::string_view, 2> examples{};

  template <class T>
  static std::string text(const T& /*value*/) {
    return {};
  }
  std::string values() const { return std::string(possible); }
  std::array<std::string, 2> samples() const {
    return {std::string(examples[0]), std::string(examples[1])};
  }
};

/// A key with the value true or false.
struct Flag {
  static void read(const ConfigNode& node, bool& value) { value = node.as<bool>(); }
  static std::string text(bool value) { return value ? "true" : "false"; }
  static std::string values() { return "true, false"; }
  static std::array<std::string, 2> samples() { return {"true", "false"}; }
};

/// A key whose value is any text.
struct Text {
  static void read(const ConfigNode& node, std::string& value) { value = node.as<std::string>(); }
  static std::string text(const std::string& value) { return value.empty() ? "none" : value; }
  static std::string values() { return {}; }
  static std::array<std::string, 2> samples() { return {"a", "b"}; }
};

/// A path; a relative one counts from the folder of the file that names it.
struct PathBeside {
  static void read(const ConfigNode& node, std::filesystem::path& value) {
    value = node.resolve(node.as<std::string>());
  }
  static std::string text(const std::filesystem::path& value) { return Text::text(value.string()); }
  static std::string values() { return {}; }
  static std::array<std::string, 2> samples() { return Text::samples(); }
};

/// A value read by its own function: T parse(const ConfigNode&).
template <auto Parse>
struct Parsed {
  using Value = decltype(Parse(std::declval<const ConfigNode&>()));

  static void read(const ConfigNode& node, Value& value) { value = Parse(node); }
};

/// A block that another program or plugin reads, and checks.
struct HandedOn {
  template <class T>
  requires std::is_assignable_v<T&, const ConfigNode&>
  static void read(const ConfigNode& node, T& value) {
    node.mark_used();
    value = node;
  }
};

/// Any number.
struct Number {
  static void read(const ConfigNode& node, double& value) { value = node.as<double>(); }
  static std::string text(double value) { return number_text(value); }
  static std::string values() { return "number"; }
  static std::array<std::string, 2> samples() { return {"0", "1"}; }
};

/// Any whole number that is not negative.
struct Count {
  static void read(const ConfigNode& node, std::uint64_t& value) {
    value = node.as<std::uint64_t>();
  }
  static std::string text(std::uint64_t value) { return std::to_string(value); }
  static std::string values() { return "whole number"; }
  static std::array<std::string, 2> samples() { return {"1", "2"}; }
};

/// Value types that a Range accepts.
template <class T>
concept RangeValue = std::is_arithmetic_v<T> || std::is_same_v<T, Duration>;

/// A number in [low, high]. Its value is a double, or the number times `unit`: a Duration (unit in
/// seconds) or bytes.
struct Range {
  double low;
  double high;
  double unit = 1;

  template <RangeValue T>
  void read(const ConfigNode& node, T& value) const {
    const double number = number_in(node, low, high) * unit;
    if constexpr (std::is_same_v<T, Duration>) {
      value = from_seconds(number);
    } else {
      value = static_cast<T>(number);
    }
  }
  /// The number that a file has for it.
  template <RangeValue T>
  double number(const T& value) const {
    if constexpr (std::is_same_v<T, Duration>) {
      return to_seconds(value) / unit;
    } else {
      return static_cast<double>(value) / unit;
    }
  }
  template <RangeValue T>
  std::string text(const T& value) const {
    return number_text(std::round(number(value) * 1e6) / 1e6);
  }
  std::string values() const { return plain(low) + " to " + plain(high); }
  std::array<std::string, 2> samples() const {
    return {number_text(low), number_text(low + std::min(1.0, (high - low) / 2))};
  }

 private:
  /// Without an exponent: 100000000.
  static std::string plain(double value) {
    const auto whole = static_cast<std::int64_t>(value);
    return static_cast<double>(whole) == value ? std::to_string(whole) : number_text(value);
  }
};

/// A whole number in [low, high].
struct Whole {
  std::int64_t low;
  std::int64_t high;

  template <std::integral T>
  void read(const ConfigNode& node, T& value) const {
    value = static_cast<T>(whole_in(node, low, high));
  }
  template <std::integral T>
  static std::string text(T value) {
    return std::to_string(value);
  }
  std::string values() const { return std::to_string(low) + " to " + std::to_string(high); }
  std::array<std::string, 2> samples() const {
    return {std::to_string(low), std::to_string(low + 1)};
  }
};

/// One of a few words.
template <class T, std::size_t N>
struct Words {
  std::array<std::pair<std::string_view, T>, N> words;
  std::string_view refusal{};  ///< of another word, the {} in it; empty: it is none of them

  template <class V>
  requires std::is_assignable_v<V&, const T&>
  void read(const ConfigNode& node, V& value) const {
    const auto given = node.as<std::string>();
    for (const auto& [word, meant] : words) {
      if (given != word) continue;
      value = meant;
      return;
    }
    node.fail(refused(given));
  }
  std::string refused(const std::string& given) const {
    if (refusal.empty()) return "'" + given + "' is none of " + values();
    std::string sentence(refusal);
    const std::size_t place = sentence.find("{}");
    return place == sentence.npos ? sentence : sentence.replace(place, 2, given);
  }
  /// The word for a value; "none" where there is none.
  template <class V>
  constexpr std::string_view word(const V& value) const {
    for (const auto& [word, meant] : words) {
      if (meant == value) return word;
    }
    return "none";
  }
  std::string text(const T& value) const { return std::string(word(value)); }
  std::string values() const {
    std::string list;
    for (const auto& [word, meant] : words) list.append(list.empty() ? "" : ", ").append(word);
    return list;
  }
  std::array<std::string, 2> samples() const {
    // A lone word is changed by leaving it out.
    return {std::string(words[0].first), N > 1 ? std::string(words[N > 1 ? 1 : 0].first) : ""};
  }
};

/// A block with keys of its own.
template <class S, class K>
struct Block {
  using Struct = S;
  K keys;
  void (*check)(const ConfigNode& node, const S& block) = nullptr;  ///< of several keys together

  void read(const ConfigNode& node, S& block) const {
    read_keys(node, keys, block);
    if (check != nullptr) check(node, block);
  }
};
template <class S, class K>
constexpr Block<S, K> block(K keys, void (*check)(const ConfigNode&, const S&) = nullptr) {
  return {keys, check};
}

/// Reads the keys of a list. One that is left out leaves its value as it is.
/// @throws ConfigError "FILE:LINE: key.path: sentence"
template <class Keys, class Struct>
void read_keys(const ConfigNode& node, const Keys& keys, Struct& into) {
  for_each_key(keys, [&](const auto& key) {
    if constexpr (!std::is_same_v<typename std::decay_t<decltype(key)>::Kind, ReadApart>) {
      const auto child = key.required ? std::optional(node.at(key.name)) : node.find(key.name);
      if (!child) return;
      auto& value = key.of(into);
      if constexpr (requires { key.kind.read(*child, value); }) {
        key.kind.read(*child, value);
      } else {  // std::optional
        key.kind.read(*child, value.emplace());
      }
    }
  });
}

/// Adds the keys of a list to a reference, those of blocks below their block's.
/// @param defaults  a struct as it is before it is read
template <class Keys, class Struct>
void add_rows(const Keys& keys, const Struct& defaults, std::vector<KeyRow>& rows,
              const std::string& prefix = "") {
  for_each_key(keys, [&](const auto& key) {
    const auto& value = key.of(defaults);
    const std::string path = prefix + std::string(key.name);
    const auto add = [&](std::string standard, std::string values,
                         std::array<std::string, 2> samples) {
      if (!key.standard.empty()) standard = key.standard;
      rows.push_back({path, key.required ? "" : std::move(standard), std::move(values),
                      std::string(key.help), std::move(samples), key.required});
    };
    if constexpr (requires { key.kind.samples(); }) {
      if constexpr (requires { key.kind.text(value); }) {
        add(key.kind.text(value), key.kind.values(), key.kind.samples());
      } else {  // std::optional
        add(value ? key.kind.text(*value) : "none", key.kind.values(), key.kind.samples());
      }
    } else if (!key.help.empty()) {
      add("none", "", {});
    }
    if constexpr (requires { key.kind.keys; }) {
      using Inner = typename std::decay_t<decltype(key)>::Kind::Struct;
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Inner>) {
        add_rows(key.kind.keys, value, rows, path + ".");
      } else {
        add_rows(key.kind.keys, Inner{}, rows, path + ".");
      }
    }
  });
}

}  // namespace cas::base
