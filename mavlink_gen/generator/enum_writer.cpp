// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/writers.hpp"

#include <vector>

namespace cas::mav::gen {
namespace {

constexpr std::uint64_t kLowestMagnitude = std::uint64_t{1} << 63U;
constexpr std::uint64_t kMaxInt = 0x7FFFFFFF;

constexpr std::string_view kBitmaskOperators = R"(
/// An enum whose values are sets of flags.
template <class E>
concept Bitmask = kIsBitmask<E>;

template <Bitmask E>
constexpr E operator|(E a, E b) {
  using T = std::underlying_type_t<E>;
  return static_cast<E>(static_cast<T>(static_cast<T>(a) | static_cast<T>(b)));
}
template <Bitmask E>
constexpr E operator&(E a, E b) {
  using T = std::underlying_type_t<E>;
  return static_cast<E>(static_cast<T>(static_cast<T>(a) & static_cast<T>(b)));
}
template <Bitmask E>
constexpr E operator^(E a, E b) {
  using T = std::underlying_type_t<E>;
  return static_cast<E>(static_cast<T>(static_cast<T>(a) ^ static_cast<T>(b)));
}
template <Bitmask E>
constexpr E operator~(E a) {
  using T = std::underlying_type_t<E>;
  return static_cast<E>(static_cast<T>(~static_cast<T>(a)));
}
template <Bitmask E>
constexpr E& operator|=(E& a, E b) {
  return a = a | b;
}
template <Bitmask E>
constexpr E& operator&=(E& a, E b) {
  return a = a & b;
}
template <Bitmask E>
constexpr E& operator^=(E& a, E b) {
  return a = a ^ b;
}
/// Whether some flag is set.
template <Bitmask E>
constexpr bool any(E a) {
  return a != E{};
}
/// Whether every flag of `flag` is set in `a`.
template <Bitmask E>
constexpr bool has(E a, E flag) {
  return (a & flag) == flag;
}
)";

std::string value_literal(const xml::Enum& item, const xml::EnumValue& value) {
  if (value.negative && value.bits == kLowestMagnitude) return "INT64_MIN";
  auto text = value.decimal();
  if (!item.is_signed && value.bits > kMaxInt) text += 'U';
  if (!value.negative && value.bits > kMaxInt && item.bytes == 8) text += "LL";
  if (value.negative && ~value.bits >= kMaxInt) text += "LL";
  return text;
}

void append_params(std::string& out, const xml::Entry& entry) {
  for (const auto& param : entry.params) {
    if (param.label.empty() && param.text.empty()) continue;
    auto line = cat({"Parameter ", std::to_string(param.index), ": ", param.label});
    if (!param.units.empty()) line += cat({" [", param.units, "]"});
    if (!param.enum_name.empty()) line += cat({" (", param.enum_name, ")"});
    if (!param.text.empty()) line += cat({param.label.empty() ? "" : ". ", param.text});
    append_comment(out, "  ", line);
  }
}

void append_enum(std::string& out, const xml::Enum& item, const std::string& type) {
  const auto enumerators = Names::enumerators(item);
  out += '\n';
  append_comment(out, "", item.text);
  append_comment(out, "", lifecycle_sentence(item.lifecycle));
  out += cat({"enum class ", type, " : ", underlying_type(item), " {  // ", item.name, "\n"});
  for (std::size_t i = 0; i < item.entries.size(); ++i) {
    const auto& entry = item.entries[i];
    append_comment(out, "  ", entry.text);
    append_comment(out, "  ", lifecycle_sentence(entry.lifecycle));
    append_params(out, entry);
    out += cat({"  ", enumerators[i], " = ", value_literal(item, entry.value), ",  // ", entry.name,
                "\n"});
  }
  out += "};\n";
  if (item.bitmask) {
    out += cat({"template <>\ninline constexpr bool kIsBitmask<", type, "> = true;\n"});
  }
}

/// One table of parameters for each entry that has some.
void append_param_tables(std::string& out, const xml::Enum& item, const std::string& type,
                         const std::vector<std::string>& enumerators) {
  for (std::size_t i = 0; i < item.entries.size(); ++i) {
    const auto& params = item.entries[i].params;
    if (params.empty()) continue;
    out += cat({"inline constexpr cas::mav::ParamInfo k", type, enumerators[i], "Params[] = {\n"});
    for (const auto& param : params) {
      out += cat({"    {", std::to_string(param.index), ", ", string_literal(param.label), ", ",
                  string_literal(param.units), ", ", string_literal(param.enum_name), "},\n"});
    }
    out += "};\n";
  }
}

void append_text(std::string& out, const xml::Enum& item, const std::string& type) {
  const auto enumerators = Names::enumerators(item);
  out += "\nnamespace detail {\n";
  append_param_tables(out, item, type, enumerators);
  if (!item.entries.empty()) {
    out += cat({"inline constexpr cas::mav::EnumEntry k", type, "Entries[] = {\n"});
    for (std::size_t i = 0; i < item.entries.size(); ++i) {
      const auto& entry = item.entries[i];
      out += cat({"    {", std::to_string(entry.value.bits), "U, ", string_literal(entry.name)});
      out += entry.params.empty() ? ", {}},\n" : cat({", k", type, enumerators[i], "Params},\n"});
    }
    out += "};\n";
  }
  out += cat({"}  // namespace detail\n/// Name and entries of ", type,
              ".\nconstexpr cas::mav::EnumInfo enum_info(", type, ") {\n  return {",
              string_literal(item.name), ", ", item.bitmask ? "true" : "false", ", "});
  out += item.entries.empty() ? "{}};\n}\n" : cat({"detail::k", type, "Entries};\n}\n"});
}

/// Every enum by its name, also those that no field has.
std::string enum_table(const xml::Dialect& dialect, const Names& names) {
  std::string out = "\n/// Every enum of the dialect, by name.\n";
  if (dialect.enums.empty()) {
    out += "constexpr std::span<const cas::mav::EnumInfo> enums() { return {}; }\n";
  } else {
    out += "inline constexpr cas::mav::EnumInfo kEnums[] = {\n";
    for (const auto& item : dialect.enums) {
      out += cat({"    enum_info(", names.type(item), "{}),\n"});
    }
    out += "};\nconstexpr std::span<const cas::mav::EnumInfo> enums() { return kEnums; }\n";
  }
  return out +=
         "\n/// An enum by its name as in the XML; nullptr when the dialect has none of that "
         "name.\n"
         "constexpr const cas::mav::EnumInfo* find_enum(std::string_view name) {\n"
         "  for (const auto& item : enums()) {\n"
         "    if (item.name == name) return &item;\n"
         "  }\n"
         "  return nullptr;\n"
         "}\n";
}

}  // namespace

std::string enum_declarations(const xml::Dialect& dialect, const Names& names) {
  std::string out =
      "\n/// Whether the values of E are sets of flags.\n"
      "template <class E>\ninline constexpr bool kIsBitmask = false;\n";
  for (const auto& item : dialect.enums) append_enum(out, item, names.type(item));
  return out.append(kBitmaskOperators);
}

std::string enum_texts(const xml::Dialect& dialect, const Names& names) {
  std::string out;
  for (const auto& item : dialect.enums) append_text(out, item, names.type(item));
  return out += enum_table(dialect, names);
}

}  // namespace cas::mav::gen
