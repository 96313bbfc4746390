// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/dialect_loader.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "mavlink_gen/parser/file_parser.hpp"
#include "mavlink_gen/parser/xml_document.hpp"

namespace cas::mav::xml {
namespace {

namespace fs = std::filesystem;

constexpr int kDefaultVersion = 3;
constexpr std::size_t kMaxIncludeDepth = 64;
constexpr std::size_t kMaxFiles = 256;
constexpr std::size_t kMaxMessages = 10'000;  // all public dialects together have under 600

std::string shown(const fs::path& path) { return path.lexically_normal().generic_string(); }

/// The text of a regular file, or why there is none.
std::optional<std::string> read_file(const fs::path& path, std::string& why) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (error || !fs::exists(status)) {
    why = "there is no such file";
    return std::nullopt;
  }
  if (!fs::is_regular_file(status)) {
    why = "it is no regular file";
    return std::nullopt;
  }
  const auto size = fs::file_size(path, error);
  if (error || size > kMaxFileBytes) {
    why = error ? error.message() : "it is larger than 64 MiB";
    return std::nullopt;
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || !stream.is_open()) {
    why = "it cannot be read";
    return std::nullopt;
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

class Loader final {
 public:
  explicit Loader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  std::optional<Dialect> load(const fs::path& path) {
    dialect_.name = path.stem().string();
    const auto root = diagnostics_.add_file({shown(path), false, {}});
    load_file(path, root);
    return finish();
  }

  std::optional<Dialect> parse(std::string_view text, std::string_view name) {
    dialect_.name = name;
    in_memory_ = true;
    load_text(text, std::string(name), diagnostics_.add_file({std::string(name), false, {}}));
    return finish();
  }

 private:
  struct OpenFile {
    fs::path canonical;
    std::string name;
  };

  std::optional<Dialect> finish() {
    for (auto& item : enums_) dialect_.enums.push_back(std::move(item.second));
    finish_enums();
    finish_messages();
    if (diagnostics_.error_count() > 0) return std::nullopt;
    return std::move(dialect_);
  }

  /// Depth first: the includes of a file are merged before the file itself.
  void load_file(const fs::path& path, std::uint32_t file) {
    std::string why;
    const auto text = read_file(path, why);
    if (!text) {
      const auto& source = diagnostics_.files()[file];
      const auto position = source.included ? source.included_at : Position{file, 1, 1};
      return diagnostics_.error(position, "cannot read " + source.path + ": " + why);
    }
    load_text(*text, path, file);
  }

  void load_text(std::string_view text, const fs::path& path, std::uint32_t file) {
    const auto tree = parse_xml(text, file, diagnostics_);
    if (!tree) return;
    auto parsed = parse_file(*tree, diagnostics_);

    open_.push_back({canonical(path), path.filename().string()});
    seen_.insert(open_.back().canonical);
    std::optional<int> included_version;
    for (const auto& include : parsed.includes) {
      if (const auto version = follow(path, include)) included_version = version;
    }
    const auto version = parsed.version ? parsed.version : included_version;
    versions_[open_.back().canonical] = version;
    open_.pop_back();

    dialect_.files.push_back(shown(path));
    if (open_.empty()) {
      dialect_.version = version.value_or(0);
      dialect_.number = parsed.dialect.value_or(0);
    }
    merge(std::move(parsed), version);
  }

  static fs::path canonical(const fs::path& path) {
    std::error_code error;
    auto result = fs::weakly_canonical(path, error);
    return error ? path.lexically_normal() : result;
  }

  /// @return the version of the included file
  std::optional<int> follow(const fs::path& from, const Include& include) {
    if (in_memory_) {
      diagnostics_.error(include.position, "a dialect in memory cannot include a file");
      return std::nullopt;
    }
    const auto path = from.parent_path() / include.path;
    const auto target = canonical(path);
    const auto open = std::find_if(open_.begin(), open_.end(),
                                   [&](const OpenFile& file) { return file.canonical == target; });
    if (open != open_.end()) {
      std::string chain;
      for (auto it = open; it != open_.end(); ++it) chain += it->name + " -> ";
      diagnostics_.error(include.position, "files include each other in a circle: " + chain +
                                               path.filename().string());
      return std::nullopt;
    }
    if (open_.size() >= kMaxIncludeDepth) {
      diagnostics_.error(include.position, "files are included too deeply");
      return std::nullopt;
    }
    if (seen_.size() >= kMaxFiles) {
      diagnostics_.error(include.position, "the dialect has more than 256 files");
      return std::nullopt;
    }
    if (!seen_.contains(target)) {
      load_file(path, diagnostics_.add_file({shown(path), true, include.position}));
    }
    return versions_[target];
  }

  void merge(ParsedFile file, std::optional<int> version) {
    for (auto& item : file.enums) merge_enum(std::move(item));
    for (auto& message : file.messages) {
      for (auto& field : message.fields) {
        if (!field.is_version) continue;
        if (!version) {
          diagnostics_.warning(field.position, "the file has no <version>, " + field.name +
                                                   " becomes " + std::to_string(kDefaultVersion));
        }
        field.version = static_cast<std::uint8_t>(version.value_or(kDefaultVersion));
      }
      merge_message(std::move(message));
    }
  }

  void merge_enum(Enum item) {
    auto& into = enums_[item.name];
    if (into.name.empty()) {
      into.name = item.name;
      into.position = item.position;
    }
    into.bitmask = into.bitmask || item.bitmask;
    if (into.text.empty()) into.text = std::move(item.text);
    if (into.lifecycle.status < item.lifecycle.status) into.lifecycle = std::move(item.lifecycle);
    auto& by_value = entry_values_[item.name];
    for (auto& entry : item.entries) {
      const auto [named, fresh_name] = entry_names_.try_emplace(entry.name, entry.position);
      if (!fresh_name) {
        diagnostics_.error(entry.position, "the entry " + entry.name + " is already at " +
                                               diagnostics_.describe(named->second));
        continue;
      }
      const auto key = std::pair(entry.value.negative, entry.value.bits);
      const auto [valued, fresh_value] = by_value.try_emplace(key, entry.name);
      if (!fresh_value) {
        diagnostics_.error(entry.position, "the value " + entry.value.decimal() + " of " +
                                               item.name + " is already that of " + valued->second);
        continue;
      }
      into.entries.push_back(std::move(entry));
    }
  }

  void merge_message(Message message) {
    if (message_ids_.size() >= kMaxMessages) {
      return diagnostics_.error(message.position, "the dialect has more than 10000 messages");
    }
    const auto [id, fresh_id] = message_ids_.try_emplace(message.id, message.position);
    if (!fresh_id) {
      return diagnostics_.error(message.position, "the message id " + std::to_string(message.id) +
                                                      " is already that of the message at " +
                                                      diagnostics_.describe(id->second));
    }
    const auto [name, fresh_name] = message_names_.try_emplace(message.name, message.position);
    if (!fresh_name) {
      return diagnostics_.error(
          message.position,
          "the message " + message.name + " is already at " + diagnostics_.describe(name->second));
    }
    dialect_.messages.push_back(std::move(message));
  }

  void finish_enums() {
    for (auto& item : dialect_.enums) {
      std::stable_sort(item.entries.begin(), item.entries.end(),
                       [](const Entry& a, const Entry& b) { return a.value.less(b.value); });
      if (item.entries.empty()) continue;
      const auto& low = item.entries.front().value;
      const auto& high = item.entries.back().value;
      if (low.negative && !high.negative && high.bits > static_cast<std::uint64_t>(INT64_MAX)) {
        diagnostics_.error(
            item.position,
            "no 64-bit type holds both the lowest and the highest value of " + item.name);
      }
    }
  }

  void finish_messages() {
    std::sort(dialect_.messages.begin(), dialect_.messages.end(),
              [](const Message& a, const Message& b) { return a.id < b.id; });
    for (const auto& item : dialect_.enums) enum_names_.push_back(item.name);
    fields_of_.resize(dialect_.enums.size());
    for (auto& message : dialect_.messages) {
      for (auto& field : message.fields) {
        if (!field.enum_name.empty()) connect_enum(field);
      }
    }
    for (std::size_t i = 0; i < dialect_.enums.size(); ++i) {
      find_type(dialect_.enums[i], fields_of_[i]);
    }
  }

  void connect_enum(Field& field) {
    const auto it = std::lower_bound(enum_names_.begin(), enum_names_.end(), field.enum_name);
    if (it == enum_names_.end() || *it != field.enum_name) {
      diagnostics_.warning(
          field.position,
          "there is no enum " + field.enum_name + ", " + field.name + " stays a number" +
              diagnostics_.suggest(Severity::kWarning, field.enum_name, enum_names_));
      field.enum_name.clear();
      return;
    }
    const auto index = it - enum_names_.begin();
    auto& item = dialect_.enums[static_cast<std::size_t>(index)];
    if (field.display_bitmask) item.bitmask = true;
    if (!is_integer(field.type)) return;
    if (item.entries.empty() || (holds(field.type, item.entries.front().value) &&
                                 holds(field.type, item.entries.back().value))) {
      fields_of_[static_cast<std::size_t>(index)].push_back(&field);
      return;
    }
    const auto& low = item.entries.front().value;
    const bool too_low = low.negative && !holds(field.type, low);
    leave_a_number(field, std::string("the ") + (too_low ? "lowest" : "highest") + " value of " +
                              item.name + " is " +
                              (too_low ? low : item.entries.back().value).decimal());
  }

  void leave_a_number(Field& field, const std::string& why) {
    field.enum_unfit = true;
    diagnostics_.warning(field.position, field.name + " is " + std::string(wire_name(field.type)) +
                                             ", but " + why + ": it stays a number");
  }

  /// Finds the narrowest type for all values and for the types of all fields. No type covers both
  /// signed and unsigned 64 bits.
  void find_type(Enum& item, const std::vector<Field*>& fields) {
    int with_sign = 0;
    int without_sign = 0;
    for (const auto* field : fields) {
      auto& widest = is_signed(field->type) ? with_sign : without_sign;
      widest = std::max(widest, static_cast<int>(size_of(field->type)));
    }
    const bool negative = !item.entries.empty() && item.entries.front().value.negative;
    if (with_sign > 0 && without_sign == 8) {
      for (auto* field : fields) {
        if (is_signed(field->type)) {
          leave_a_number(*field, item.name + " is in fields of uint64_t as well");
        }
      }
      with_sign = 0;
    }
    item.is_signed = negative || with_sign > 0;
    if (item.is_signed) without_sign *= 2;
    item.bytes = std::max({1, with_sign, without_sign});
    while (item.bytes < 8 && !fits(item)) item.bytes *= 2;
  }

  static bool fits(const Enum& item) {
    if (item.entries.empty()) return true;
    const auto bits = static_cast<unsigned>(item.bytes) * 8U;
    const auto& low = item.entries.front().value;
    const auto& high = item.entries.back().value;
    const auto limit = std::uint64_t{1} << (item.is_signed ? bits - 1 : bits);
    const auto high_fits = high.negative || high.bits < limit;
    const auto low_fits = !low.negative || ~low.bits < limit;
    return high_fits && low_fits;
  }

  Diagnostics& diagnostics_;
  Dialect dialect_;
  std::map<std::string, Enum> enums_;
  std::map<std::string, std::map<std::pair<bool, std::uint64_t>, std::string>> entry_values_;
  std::unordered_map<std::string, Position> entry_names_;
  std::unordered_map<std::uint32_t, Position> message_ids_;
  std::unordered_map<std::string, Position> message_names_;
  std::map<fs::path, std::optional<int>> versions_;
  std::set<fs::path> seen_;
  std::vector<std::string_view> enum_names_;
  std::vector<std::vector<Field*>> fields_of_;  ///< of each enum: those that become its type
  std::vector<OpenFile> open_;
  bool in_memory_{};
};

}  // namespace

std::optional<Dialect> load_dialect(const std::filesystem::path& file, Diagnostics& diagnostics) {
  return Loader(diagnostics).load(file);
}

std::optional<Dialect> parse_dialect(std::string_view text, std::string_view name,
                                     Diagnostics& diagnostics) {
  return Loader(diagnostics).parse(text, name);
}

}  // namespace cas::mav::xml
