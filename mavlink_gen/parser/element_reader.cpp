// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/element_reader.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace cas::mav::xml {
namespace {

bool is_identifier(std::string_view name) {
  const auto is_letter = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
  };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !name.empty() && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return is_letter(c) || is_digit(c); });
}

}  // namespace

std::string trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const auto begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kSpace) - begin + 1));
}

/// Runs of white space become one blank.
std::string prose(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const bool space = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!space) out += c;
    if (space && !out.empty() && out.back() != ' ') out += ' ';
  }
  if (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

std::string in_quotes(std::string_view text) { return '\'' + std::string(text) + '\''; }

bool ElementReader::expect_child(const Element& parent, const Element& child, Names allowed) {
  if (std::find(allowed.begin(), allowed.end(), child.name) != allowed.end()) return true;
  diagnostics_.error(
      child.position,
      "<" + child.name + "> is not allowed in <" + parent.name + ">" +
          diagnostics_.suggest(Severity::kError, child.name, {allowed.begin(), allowed.end()}));
  return false;
}

void ElementReader::expect_attributes(const Element& element, Names allowed) {
  for (const auto& attribute : element.attributes) {
    if (std::find(allowed.begin(), allowed.end(), attribute.name) != allowed.end()) continue;
    if (attribute.name.find(':') != std::string::npos) continue;  // another XML vocabulary
    diagnostics_.warning(attribute.position,
                         "<" + element.name + "> has no attribute " + in_quotes(attribute.name) +
                             ", it is ignored" +
                             diagnostics_.suggest(Severity::kWarning, attribute.name,
                                                  {allowed.begin(), allowed.end()}));
  }
}

const Attribute* ElementReader::require(const Element& element, std::string_view name) {
  const auto* attribute = element.find(name);
  if (attribute == nullptr) {
    diagnostics_.error(element.position,
                       "<" + element.name + "> lacks the attribute " + in_quotes(name));
  }
  return attribute;
}

std::string ElementReader::require_name(const Element& element) {
  const auto* attribute = require(element, "name");
  if (attribute == nullptr) return {};
  auto name = trimmed(attribute->value);
  if (is_identifier(name)) return name;
  diagnostics_.error(
      attribute->position,
      in_quotes(attribute->value) + " is no name: letters, digits and underscores, no digit first");
  return {};
}

std::string ElementReader::value_of(const Element& element, std::string_view name) {
  const auto* attribute = element.find(name);
  return attribute == nullptr ? std::string() : trimmed(attribute->value);
}

bool ElementReader::parse_flag(const Element& element, std::string_view name) {
  const auto* attribute = element.find(name);
  if (attribute == nullptr) return false;
  const auto value = trimmed(attribute->value);
  if (value == "true" || value == "1") return true;
  if (value != "false" && value != "0") {
    diagnostics_.warning(attribute->position, in_quotes(attribute->value) + " for " +
                                                  in_quotes(name) +
                                                  " is neither true nor false, false is taken");
  }
  return false;
}

Lifecycle ElementReader::parse_lifecycle(const Element& element) {
  constexpr std::array<std::string_view, 2> kAttributes{"since", "replaced_by"};
  expect_attributes(element, kAttributes);
  Lifecycle lifecycle;
  lifecycle.status = element.name == "wip"          ? Status::kWip
                     : element.name == "superseded" ? Status::kSuperseded
                                                    : Status::kDeprecated;
  lifecycle.since = value_of(element, "since");
  lifecycle.replaced_by = value_of(element, "replaced_by");
  lifecycle.text = prose(element.text);
  return lifecycle;
}

bool ElementReader::parse_common_child(const Element& child, std::string& text,
                                       Lifecycle& lifecycle) {
  if (child.name == "description") {
    text = prose(child.text);
    return true;
  }
  if (child.name == "wip" || child.name == "superseded" || child.name == "deprecated") {
    auto parsed = parse_lifecycle(child);
    // The gravest of several counts, whatever their order.
    if (parsed.status > lifecycle.status) lifecycle = std::move(parsed);
    return true;
  }
  return false;
}

void ElementReader::error(const Position& position, const std::string& sentence) {
  diagnostics_.error(position, sentence);
}

void ElementReader::warning(const Position& position, const std::string& sentence) {
  diagnostics_.warning(position, sentence);
}

}  // namespace cas::mav::xml
