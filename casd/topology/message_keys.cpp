// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/message_keys.hpp"

#include <string_view>

#include "base/text.hpp"
#include "mavlink_gen/parser/diagnostics.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

bool is_number(const std::string& text) { return text.size() <= 8 && base::is_number(text); }

[[noreturn]] void refuse_message(const base::ConfigNode& node, const std::string& text) {
  std::vector<std::string_view> names;
  for (const mav::MessageInfo& message : mav::public_table().all()) names.push_back(message.name);
  const std::string near = mav::xml::suggestion(text, names);
  node.fail("no public message has the name '" + text + "'" +
            (near.empty() ? "; give its number if it is private" : near));
}

}  // namespace

std::vector<base::ConfigNode> one_or_many(const base::ConfigNode& node) {
  return node.is_list() ? node.items() : std::vector{node};
}

// Numbers may be of dialects that we do not know.
std::uint32_t parse_message(const base::ConfigNode& node, const std::string& text) {
  if (is_number(text)) {
    const unsigned long id = std::stoul(text);
    if (id > 0xFFFFFF) node.fail(text + " is beyond the message ids (24 bits)");
    return static_cast<std::uint32_t>(id);
  }
  const mav::MessageInfo* known = mav::public_table().find(text);
  if (known == nullptr) refuse_message(node, text);
  return known->id;
}

std::string message_word(std::uint32_t id) {
  const mav::MessageInfo* known = mav::public_table().find(id);
  return known == nullptr ? std::to_string(id) : std::string(known->name);
}

std::vector<std::uint32_t> hil_messages() {
  std::vector<std::uint32_t> ids;
  for (const mav::MessageInfo& message : mav::public_table().all()) {
    if (message.name.starts_with("HIL_")) ids.push_back(message.id);
  }
  return ids;
}

void Messages::read(const base::ConfigNode& node, std::vector<std::uint32_t>& ids) {
  for (const base::ConfigNode& entry : one_or_many(node)) {
    ids.push_back(parse_message(entry, entry.as<std::string>()));
  }
}

std::string Messages::text(const std::vector<std::uint32_t>& ids) {
  return joined(ids, message_word);
}

void Ids::read(const base::ConfigNode& node, std::vector<std::uint8_t>& ids) {
  for (const base::ConfigNode& entry : one_or_many(node)) {
    const int id = entry.as<int>();
    if (id < 0 || id > 255) entry.fail(std::to_string(id) + " is not an id (0..255)");
    ids.push_back(static_cast<std::uint8_t>(id));
  }
}

std::string Ids::text(const std::vector<std::uint8_t>& ids) {
  return joined(ids, [](std::uint8_t id) { return std::to_string(id); });
}

}  // namespace cas::casd
