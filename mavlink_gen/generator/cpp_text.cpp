// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/writers.hpp"

#include <algorithm>

namespace cas::mav::gen {

std::string cat(std::initializer_list<std::string_view> pieces) {
  std::string out;
  for (const auto piece : pieces) out += piece;
  return out;
}

std::string cpp_type(xml::BaseType type) {
  using xml::BaseType;
  const bool fundamental =
      type == BaseType::kChar || type == BaseType::kFloat || type == BaseType::kDouble;
  return cat({fundamental ? "" : "std::", xml::wire_name(type)});
}

std::string underlying_type(const xml::Enum& item) {
  return cat({item.is_signed ? "std::int" : "std::uint", std::to_string(item.bytes * 8), "_t"});
}

std::string string_literal(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20U) continue;
    if (c == '"' || c == '\\' || c == '?') out += '\\';  // '?': no trigraphs
    out += c;
  }
  out += '"';
  return out;
}

void append_comment(std::string& out, std::string_view indent, std::string_view text) {
  constexpr std::size_t kColumns = 100;
  constexpr std::string_view kLead = "/// ";
  const auto room = kColumns - indent.size() - kLead.size();
  while (!text.empty()) {
    auto end = text.size();
    if (end > room) {
      end = text.rfind(' ', room);
      if (end == std::string_view::npos || end == 0) {
        end = std::min(text.find(' ', room), text.size());
      }
    }
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    out += indent;
    out += kLead;
    out += line;
    // A backslash at the end, spelt either way, would draw the next line into the comment.
    if (line.ends_with('\\') || line.ends_with("?\?/")) out += '.';
    out += '\n';
  }
}

std::string lifecycle_sentence(const xml::Lifecycle& lifecycle) {
  if (lifecycle.status == xml::Status::kStable) return {};
  std::string out = lifecycle.status == xml::Status::kWip          ? "Work in progress"
                    : lifecycle.status == xml::Status::kSuperseded ? "Superseded"
                                                                   : "Deprecated";
  if (!lifecycle.since.empty()) out.append(" since ").append(lifecycle.since);
  if (!lifecycle.replaced_by.empty()) out.append(", use ").append(lifecycle.replaced_by);
  out += '.';
  if (!lifecycle.text.empty()) out.append(" ").append(lifecycle.text);
  return out;
}

}  // namespace cas::mav::gen
