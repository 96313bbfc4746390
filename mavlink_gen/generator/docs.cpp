// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/writers.hpp"

#include <string_view>

#include "mavlink_gen/generator/naming.hpp"

namespace cas::mav::gen {
namespace {

/// Text that Markdown and a table's cell leave as it is.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
      continue;
    }
    if (c == '|' || c == '*' || c == '_' || c == '`' || c == '[' || c == ']' || c == '\\') {
      out += '\\';
    }
    out += c;
  }
  return out;
}

std::string link_to(const std::string& name) {
  return cat({"[", escaped(name), "](#", lower_case(name), ")"});
}

void append_heading(std::string& out, std::string_view level, const std::string& name,
                    const std::string& after) {
  out += cat({"\n", level, " <a id=\"", lower_case(name), "\"></a>", escaped(name), after, "\n\n"});
}

void append_paragraph(std::string& out, const std::string& text) {
  if (!text.empty()) out += cat({escaped(text), "\n\n"});
}

std::string type_cell(const xml::Field& field) {
  std::string out(xml::wire_name(field.type));
  if (field.array_length > 0) out += cat({"[", std::to_string(field.array_length), "]"});
  return cat({"`", out, "`"});
}

std::string meaning_cell(const xml::Field& field, const xml::Dialect& dialect) {
  auto out = escaped(field.text);
  const auto add = [&](const std::string& text) {
    if (!out.empty()) out += ' ';
    out += text;
  };
  if (!field.enum_name.empty()) {
    const bool known = dialect.find_enum(field.enum_name) != nullptr;
    add(known ? link_to(field.enum_name) : escaped(field.enum_name));
  }
  if (!field.multiplier.empty()) add(cat({"Times ", escaped(field.multiplier), "."}));
  if (!field.invalid.empty()) add(cat({"Unknown: `", field.invalid, "`."}));
  if (field.is_version) add(cat({"Always ", std::to_string(field.version), "."}));
  if (field.instance) add("Tells apart several senders.");
  return out;
}

void append_message(std::string& out, const xml::Message& message, const xml::Dialect& dialect) {
  append_heading(out, "###", message.name, cat({" (", std::to_string(message.id), ")"}));
  append_paragraph(out, lifecycle_sentence(message.lifecycle));
  append_paragraph(out, message.text);
  out += cat({"CRC\\_EXTRA ", std::to_string(message.crc_extra), ", ",
              std::to_string(message.min_length), " bytes"});
  if (message.max_length != message.min_length) {
    out += cat({", ", std::to_string(message.max_length), " with extensions"});
  }
  out += ".\n\n| field | type | offset | unit | meaning |\n| --- | --- | --- | --- | --- |\n";
  for (const auto& field : message.fields) {
    out += cat({"| ", escaped(field.name), field.extension ? " (extension)" : "", " | ",
                type_cell(field), " | ", std::to_string(field.offset), " | ", escaped(field.units),
                " | ", meaning_cell(field, dialect), " |\n"});
  }
}

std::string param_line(const xml::Param& param) {
  auto out = cat({"<br>", std::to_string(param.index), ": ", escaped(param.label)});
  if (!param.units.empty()) out += cat({" (", escaped(param.units), ")"});
  if (!param.enum_name.empty()) out += cat({" ", escaped(param.enum_name)});
  if (!param.text.empty()) out += cat({" ", escaped(param.text)});
  return out;
}

void append_enum(std::string& out, const xml::Enum& item) {
  append_heading(out, "###", item.name, item.bitmask ? " (bitmask)" : "");
  append_paragraph(out, lifecycle_sentence(item.lifecycle));
  append_paragraph(out, item.text);
  out += "| value | name | meaning |\n| --- | --- | --- |\n";
  for (const auto& entry : item.entries) {
    auto meaning = escaped(entry.text);
    const auto life = lifecycle_sentence(entry.lifecycle);
    if (!life.empty()) meaning += cat({meaning.empty() ? "" : " ", escaped(life)});
    for (const auto& param : entry.params) {
      if (!param.label.empty() || !param.text.empty()) meaning += param_line(param);
    }
    out += cat({"| ", entry.value.decimal(), " | ", escaped(entry.name), " | ", meaning, " |\n"});
  }
}

}  // namespace

std::string write_docs(const xml::Dialect& dialect) {
  auto out = cat({"# MAVLink dialect ", escaped(dialect.name), "\n\n",
                  std::to_string(dialect.messages.size()), " messages, ",
                  std::to_string(dialect.enums.size()), " enums.\n\n## Messages\n"});
  for (const auto& message : dialect.messages) append_message(out, message, dialect);
  out += "\n## Enums\n";
  for (const auto& item : dialect.enums) append_enum(out, item);
  return out;
}

}  // namespace cas::mav::gen
