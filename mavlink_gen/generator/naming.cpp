// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/naming.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <vector>

namespace cas::mav::gen {
namespace {

// clang-format off
constexpr std::array kReserved = std::to_array<std::string_view>({
    // C++20 keywords and alternative tokens, and possible future ones
    "alignas", "alignof", "and", "and_eq", "asm", "atomic_cancel", "atomic_commit", "atomic_noexcept",
    "auto", "bitand", "bitor", "bool", "break", "case", "catch", "char", "char16_t", "char32_t",
    "char8_t", "class", "co_await", "co_return", "co_yield", "compl", "concept", "const",
    "const_cast", "consteval", "constexpr", "constinit", "continue", "decltype", "default", "delete",
    "do", "double", "dynamic_cast", "else", "enum", "explicit", "export", "extern", "false", "final",
    "float", "for", "friend", "goto", "if", "import", "inline", "int", "long", "module", "mutable",
    "namespace", "new", "noexcept", "not", "not_eq", "nullptr", "operator", "or", "or_eq", "override",
    "private", "protected", "public", "reflexpr", "register", "reinterpret_cast", "requires",
    "return", "short", "signed", "sizeof", "static", "static_assert", "static_cast", "struct",
    "switch", "synchronized", "template", "this", "thread_local", "throw", "true", "try", "typedef",
    "typeid", "typename", "typeof", "union", "unsigned", "using", "virtual", "void", "volatile",
    "wchar_t", "while", "xor", "xor_eq",
    // macros of C libraries, compilers, Windows, X11 and Qt
    "ABSOLUTE", "BUFSIZ", "CALLBACK", "CONST", "DELETE", "DIFFERENCE", "DOMAIN", "EDOM", "EOF",
    "ERANGE", "ERROR", "FAR", "FALSE", "HUGE", "IN", "INFINITE", "INFINITY", "INTERFACE", "NAN",
    "NEAR", "NO_ERROR", "NULL", "OPAQUE", "OPTIONAL", "OUT", "OVERFLOW", "PASCAL", "PI", "PLOSS",
    "RELATIVE", "SING", "SOCKET_ERROR", "STRICT", "TLOSS", "TRANSPARENT", "TRUE", "UNDERFLOW", "VOID",
    "M_PI", "Always", "Bool", "ControlMask", "CursorShape", "Expose", "False", "FocusIn", "FocusOut",
    "KeyPress", "KeyRelease", "None", "Status", "Success", "True", "Unsorted",
    "assert", "emit", "errno", "far", "foreach", "forever", "huge", "i386", "interface", "linux",
    "major", "makedev", "max", "min", "minor", "near", "offsetof", "pascal", "setjmp", "signals",
    "slots", "small", "stderr", "stdin", "stdout", "unix", "va_arg", "va_copy", "va_end", "va_start",
    "va_list", "st_atime", "st_mtime", "st_ctime", "sa_handler", "sa_sigaction", "s_addr", "h_addr",
    "si_addr", "si_band", "si_code", "si_errno", "si_int", "si_pid", "si_ptr", "si_signo", "si_status",
    "si_uid", "si_value", "cdecl", "environ", "I", "complex", "imaginary", "isinf", "isnan",
    "signbit",
    // names that generated code uses
    "std", "cas", "mavlink", "pack", "unpack", "for_each_field", "at_", "text_at_", "PayloadView",
    "View", "cas_in", "cas_out", "cas_message", "cas_visitor", "cas_quantity", "CasInfo", "kId", "kName",
    "kCrcExtra", "kMinLength", "kMaxLength", "kFields", "data_", "size_"});
// clang-format on

bool is_digit(char c) { return c >= '0' && c <= '9'; }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; }

std::vector<std::string_view> words(std::string_view name) {
  std::vector<std::string_view> out;
  while (!name.empty()) {
    const auto end = std::min(name.find('_'), name.size());
    if (end > 0) out.push_back(name.substr(0, end));
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return out;
}

std::string join_pascal(const std::vector<std::string_view>& parts, std::size_t first) {
  std::string out;
  for (auto i = first; i < parts.size(); ++i) {
    if (!out.empty() && is_digit(out.back()) && is_digit(parts[i].front())) out += '_';
    out += upper(parts[i].front());
    for (const char c : parts[i].substr(1)) out += lower(c);
  }
  return out;
}

}  // namespace

std::string pascal_case(std::string_view name) {
  const auto out = join_pascal(words(name), 0);
  const bool needs_letter = out.empty() || is_digit(out.front());  // e.g. of a name like _1
  return needs_letter ? std::string("M").append(out) : out;
}

std::string lower_case(std::string_view name) {
  std::string out(name);
  std::transform(out.begin(), out.end(), out.begin(), lower);
  return out;
}

std::string safe_identifier(std::string_view name) {
  static const std::set<std::string_view> kReservedSet(kReserved.begin(), kReserved.end());
  std::string out;
  for (const char c : name) {  // names with __, or _ in front, belong to the compiler
    if (c != '_' || out.empty() || out.back() != '_') out += c;
  }
  if (out.front() == '_') out = std::string("m").append(out);
  if (kReservedSet.contains(out)) out += out.back() == '_' ? "m" : "_";
  return out;
}

std::string namespace_of(std::string_view dialect) {
  auto out = lower_case(dialect);
  for (auto& c : out) {
    if (!is_digit(c) && (c < 'a' || c > 'z')) c = '_';
  }
  if (out.empty() || is_digit(out.front())) out = std::string("m").append(out);
  return safe_identifier(out);
}

Names::Names(const xml::Dialect& dialect) {
  const auto unique = [this](std::string wanted) {
    while (!types_.try_emplace(wanted, 1).second) wanted += '_';
    return wanted;
  };
  for (const auto* word : {"table", "dispatch", "fields_of", "any", "has", "detail", "enum_info",
                           "enums", "find_enum"})
    types_.try_emplace(word, 1);
  std::map<std::string, int, std::less<>> files;
  for (const auto* word : {"all", "enums", "table", "enum_text"}) files.try_emplace(word, 1);
  for (const auto& message : dialect.messages) {
    messages_[message.name] = unique(safe_identifier(pascal_case(message.name)));
    auto file = lower_case(message.name);
    if (!files.try_emplace(file, 1).second) {
      file += "_message";
      if (!files.try_emplace(file, 1).second) file.append("_").append(std::to_string(message.id));
    }
    headers_[message.name] = file + ".hpp";
  }
  for (const auto& item : dialect.enums) {
    enums_[item.name] = unique(safe_identifier(pascal_case(item.name)));
  }
}

std::vector<std::string> Names::members(const xml::Message& message) const {
  std::vector<std::string> out;
  std::set<std::string> taken;
  for (const auto& field : message.fields) {
    auto name = safe_identifier(field.name);
    // The member must not hide a type in its own struct.
    while (types_.contains(name) || !taken.insert(name).second) name += '_';
    out.push_back(std::move(name));
  }
  return out;
}

std::string Names::header(const xml::Message& message) const { return headers_.at(message.name); }

std::vector<std::string> Names::enumerators(const xml::Enum& item) {
  const auto enum_words = words(item.name);
  std::vector<std::string> out;
  std::map<std::string, int> uses;
  for (const auto& entry : item.entries) {
    const auto entry_words = words(entry.name);
    std::size_t shared = 0;
    while (shared + 1 < entry_words.size() && shared < enum_words.size() &&
           entry_words[shared] == enum_words[shared]) {
      ++shared;
    }
    out.push_back(std::string("k").append(join_pascal(entry_words, shared)));
    ++uses[out.back()];
  }
  // Entries that would share an enumerator keep their whole names.
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (uses[out[i]] > 1) {
      out[i] = std::string("k").append(join_pascal(words(item.entries[i].name), 0));
    }
  }
  std::set<std::string> taken;
  for (auto& name : out) {
    while (!taken.insert(name).second) name += '_';
  }
  return out;
}

}  // namespace cas::mav::gen
