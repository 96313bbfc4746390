// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/subset.hpp"

#include <algorithm>
#include <set>
#include <string_view>

#include "mavlink_gen/parser/diagnostics.hpp"

namespace cas::mav::gen {
namespace {

/// Adds an enum and the enums that the parameters of its entries refer to.
void use_enum(const xml::Dialect& dialect, std::string_view name, std::set<std::string>& used) {
  const auto* item = dialect.find_enum(name);
  if (item == nullptr || !used.insert(item->name).second) return;
  for (const auto& entry : item->entries) {
    for (const auto& param : entry.params) use_enum(dialect, param.enum_name, used);
  }
}

}  // namespace

std::optional<std::string> keep_only(xml::Dialect& dialect,
                                     const std::vector<std::string>& messages) {
  const std::set<std::string> wanted(messages.begin(), messages.end());
  for (const auto& name : wanted) {
    if (dialect.find_message(name) != nullptr) continue;
    std::vector<std::string_view> names;
    for (const auto& message : dialect.messages) names.emplace_back(message.name);
    return "there is no message " + name + " in " + dialect.name + xml::suggestion(name, names);
  }
  std::erase_if(dialect.messages,
                [&](const xml::Message& message) { return !wanted.contains(message.name); });
  std::set<std::string> used;
  for (const auto& message : dialect.messages) {
    for (const auto& field : message.fields) use_enum(dialect, field.enum_name, used);
  }
  std::erase_if(dialect.enums, [&](const xml::Enum& item) { return !used.contains(item.name); });
  return std::nullopt;
}

}  // namespace cas::mav::gen
