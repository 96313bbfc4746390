// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/writers.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "mavlink_gen/generator/units.hpp"

namespace cas::mav::gen {
namespace {

std::string_view field_type_enumerator(xml::BaseType type) {
  constexpr std::array<std::string_view, 11> kNames{"kChar",  "kUint8",  "kInt8",  "kUint16",
                                                    "kInt16", "kUint32", "kInt32", "kUint64",
                                                    "kInt64", "kFloat",  "kDouble"};
  return kNames[static_cast<std::size_t>(type)];
}

class MessageWriter final {
 public:
  MessageWriter(const xml::Message& message, const xml::Dialect& dialect, const Names& names)
      : message_(message), dialect_(dialect), names_(names), type_(names.type(message)) {
    const auto members = names.members(message);
    taken_.insert(members.begin(), members.end());
    for (std::size_t i = 0; i < members.size(); ++i) members_[&message.fields[i]] = members[i];
  }

  std::string write() {
    append_comment(out_, "", message_.text);
    append_comment(out_, "", lifecycle_sentence(message_.lifecycle));
    out_ += cat({"struct ", type_, " {\n"});
    append_constants();
    append_members();
    append_helpers();
    append_codec();
    append_view();
    append_reflection();
    out_ +=
        cat({"  friend bool operator==(const ", type_, "&, const ", type_, "&) = default;\n};\n"});
    return std::move(out_);
  }

 private:
  const std::string& member(const xml::Field& field) const { return members_.at(&field); }

  std::string element_type(const xml::Field& field) const {
    if (!field.is_enum()) return cpp_type(field.type);
    return names_.type(*dialect_.find_enum(field.enum_name));
  }

  std::string member_type(const xml::Field& field) const {
    const auto element = element_type(field);
    if (field.array_length == 0) return element;
    return cat({"std::array<", element, ", ", std::to_string(field.array_length), ">"});
  }

  void append_constants() {
    out_ += cat(
        {"  static constexpr std::uint32_t kId = ", std::to_string(message_.id), ";\n",
         "  static constexpr cas::mav::TextView kName = \"", message_.name, "\";\n",
         "  static constexpr std::uint8_t kCrcExtra = ", std::to_string(message_.crc_extra), ";\n",
         "  static constexpr std::size_t kMinLength = ", std::to_string(message_.min_length),
         ", kMaxLength = ", std::to_string(message_.max_length), ";\n\n"});
  }

  void append_members() {
    bool extension = false;
    for (const auto& field : message_.fields) {
      if (field.extension && !extension) out_ += "  // Extensions: absent in MAVLink 1.\n";
      extension = field.extension;
      auto text = field.text;
      if (!field.units.empty()) text += cat({" [", field.units, "]"});
      if (field.enum_unfit) text += cat({" A number: not every ", field.enum_name, " fits."});
      if (!field.invalid.empty()) text += cat({" Unknown: ", field.invalid});
      if (text.starts_with(' ')) text.erase(0, 1);
      append_comment(out_, "  ", text);
      const auto initial = field.is_version ? std::to_string(field.version) : std::string();
      out_ += cat({"  ", member_type(field), " ", member(field), "{", initial, "};\n"});
    }
    out_ += '\n';
  }

  /// A name for a helper that no member has.
  std::string helper(const std::string& wanted) {
    auto name = wanted;
    while (!taken_.insert(name).second) name += '_';
    return name;
  }

  void append_helpers() {
    for (const auto& field : message_.fields) {
      const auto sentinel = sentinel_of(field, dialect_);
      if (sentinel) append_known(field, *sentinel);
      if (const auto scale = scale_of(field)) append_scale(field, *scale, sentinel);
    }
  }

  void append_known(const xml::Field& field, const Sentinel& sentinel) {
    const auto& raw = member(field);
    const auto name = helper(raw + "_known");
    out_ += cat({"  bool ", name, "() const { return "});
    const auto first = sentinel.extent == Sentinel::Extent::kFirstElement;
    const auto value = cat({raw, first ? "[0]" : ""});
    if (sentinel.is_nan) {
      out_ += sentinel.extent == Sentinel::Extent::kAllElements
                  ? cat({"!cas::mav::all_nan(", raw, ")"})
                  : cat({"!cas::mav::is_nan(", value, ")"});
    } else {
      const auto wanted = cat({"static_cast<", element_type(field), ">(", sentinel.literal, ")"});
      out_ += sentinel.extent == Sentinel::Extent::kAllElements
                  ? cat({"!cas::mav::all_equal(", raw, ", ", wanted, ")"})
                  : cat({value, " != ", wanted});
    }
    out_ += "; }\n";
  }

  void append_scale(const xml::Field& field, const Scale& scale,
                    const std::optional<Sentinel>& sentinel) {
    const auto& raw = member(field);
    const auto name = helper(cat({raw, "_", scale.unit}));
    const auto setter = helper(cat({"set_", name}));
    const auto arguments = cat({scale.factor, ", ", scale.divisor});
    const bool marked = sentinel && !sentinel->is_nan;
    const auto mark = marked ? cat({", ", sentinel->literal}) : std::string();
    out_ += cat({"  double ", name, "() const { return cas::mav::to_quantity(", raw, ", ",
                 arguments, mark, "); }\n  void ", setter, "(double cas_quantity) { ", raw,
                 " = cas::mav::from_quantity<", cpp_type(field.type), ">(cas_quantity, ", arguments,
                 mark, "); }\n"});
  }

  // The codec and the view are templates so that the compiler leaves them alone until they are
  // used.

  void append_codec() {
    out_ +=
        "\n  /// Writes kMaxLength bytes in wire order.\n"
        "  template <class CasByte>\n"
        "  void pack(CasByte* cas_out) const {\n";
    for (const auto index : message_.wire_order) {
      const auto& field = message_.fields[index];
      const auto value = field.is_version ? std::to_string(field.version) : member(field);
      out_ += cat({"    cas::mav::put<", cpp_type(field.type), ">(cas_out + ",
                   std::to_string(field.offset), ", ", value, ");\n"});
    }
    out_ += "  }\n  /// Reads kMaxLength bytes in wire order.\n";
    out_ += cat({"  template <class CasByte>\n  static ", type_,
                 " unpack(const CasByte* cas_in) {\n    ", type_, " cas_message;\n"});
    for (const auto index : message_.wire_order) {
      const auto& field = message_.fields[index];
      out_ += cat({"    cas::mav::get<", cpp_type(field.type), ">(cas_in + ",
                   std::to_string(field.offset), ", cas_message.", member(field), ");\n"});
    }
    out_ += "    return cas_message;\n  }\n";
  }

  void append_view() {
    out_ +=
        "\n  /// Reads single fields straight from a received payload.\n"
        "  template <class CasPayload>\n"
        "  class CasView : public CasPayload {\n   public:\n"
        "    using CasPayload::CasPayload;\n";
    for (const auto& field : message_.fields) {
      const auto offset = std::to_string(field.offset);
      if (field.type == xml::BaseType::kChar && field.array_length > 0) {
        out_ += cat({"    cas::mav::TextView ", member(field), "() const { return this->text_at_(",
                     offset, ", ", std::to_string(field.array_length), "); }\n"});
      } else {
        const auto type = member_type(field);
        out_ += cat({"    ", type, " ", member(field), "() const { return this->template at_<",
                     cpp_type(field.type), ", ", type, ", ", std::to_string(field.bytes()), ">(",
                     offset, "); }\n"});
      }
    }
    out_ += "  };\n  using View = CasView<cas::mav::PayloadView>;\n";
  }

  void append_reflection() {
    out_ +=
        "\n  /// Facts of each field, in the order of the members: kFields<>.\n"
        "  template <class CasInfo = cas::mav::FieldInfo>\n"
        "  static constexpr CasInfo kFields[" +
        std::to_string(message_.fields.size()) + "] = {\n";
    for (const auto& field : message_.fields) {
      out_ += cat({"      {", string_literal(field.name), ", ", string_literal(field.units), ", ",
                   string_literal(field.enum_name), ", ", string_literal(field.invalid),
                   ", cas::mav::FieldType::", field_type_enumerator(field.type), ", ",
                   std::to_string(field.array_length), ", ", std::to_string(field.offset), ", ",
                   field.extension ? "true" : "false", ", ", field.instance ? "true" : "false",
                   "},\n"});
    }
    out_ +=
        "  };\n"
        "  /// Calls visitor(const FieldInfo&, member...) for each field, with that member of "
        "each\n"
        "  /// message given.\n"
        "  template <class CasInfo = cas::mav::FieldInfo, class Visitor, class... Messages>\n"
        "  static constexpr void for_each_field(Visitor&& cas_visitor, Messages&... cas_message) "
        "{\n";
    for (std::size_t i = 0; i < message_.fields.size(); ++i) {
      out_ += cat({"    cas_visitor(kFields<CasInfo>[", std::to_string(i), "], cas_message.",
                   member(message_.fields[i]), "...);\n"});
    }
    out_ += "  }\n";
  }

  const xml::Message& message_;
  const xml::Dialect& dialect_;
  const Names& names_;
  std::string type_;
  std::map<const xml::Field*, std::string> members_;
  std::set<std::string> taken_;
  std::string out_;
};

}  // namespace

bool uses_enums(const xml::Message& message) {
  return std::any_of(message.fields.begin(), message.fields.end(),
                     [](const xml::Field& field) { return field.is_enum(); });
}

std::string message_struct(const xml::Message& message, const xml::Dialect& dialect,
                           const Names& names) {
  return MessageWriter(message, dialect, names).write();
}

}  // namespace cas::mav::gen
