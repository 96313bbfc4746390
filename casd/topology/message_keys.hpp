// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/text.hpp"

namespace cas::casd {

/// The entries of a list; anything else counts as its only entry.
std::vector<base::ConfigNode> one_or_many(const base::ConfigNode& node);

/// One message by its name or its number; `node` is named in the error. @throws base::ConfigError
std::uint32_t parse_message(const base::ConfigNode& node, const std::string& text);

/// Name of a message; its number, if no public dialect has it.
std::string message_word(std::uint32_t id);

/// HIL_SENSOR and all others of the HIL loop.
std::vector<std::uint32_t> hil_messages();

/// The words of a list, "none" for an empty one.
template <class List, class Word>
std::string joined(const List& list, Word word) {
  return list.empty() ? "none" : base::joined(list, " ", word);
}

/// Kind of a key: one message or a list of them, by name or by number.
struct Messages {
  static void read(const base::ConfigNode& node, std::vector<std::uint32_t>& ids);
  static std::string text(const std::vector<std::uint32_t>& ids);
  static std::string values() { return "names or numbers"; }
  static std::array<std::string, 2> samples() { return {"[HEARTBEAT]", "[ATTITUDE]"}; }
};

/// Kind of a key: one system or component id, or a list of them.
struct Ids {
  static void read(const base::ConfigNode& node, std::vector<std::uint8_t>& ids);
  static std::string text(const std::vector<std::uint8_t>& ids);
  static std::string values() { return "0 to 255, one or a list"; }
  static std::array<std::string, 2> samples() { return {"[1]", "[2]"}; }
};

}  // namespace cas::casd
