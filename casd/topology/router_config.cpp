// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/router_config.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>

#include "base/byte_order_mark.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"
#include "base/text.hpp"
#include "casd/topology/endpoint_notation.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {

using base::lower;
using base::trimmed;

std::vector<RouterFile> read_router_files(const std::filesystem::path& main,
                                          const std::filesystem::path& folder) {
  constexpr std::size_t kMostFiles = 128;  // as mavlink-router
  constexpr std::size_t kMostBytes = std::size_t{1} << 20U;
  constexpr const char* kKind = "mavlink-router's configuration";
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  const std::filesystem::path listed = folder.empty() ? main.parent_path() / "config.d" : folder;
  std::filesystem::directory_iterator entry(listed, error);
  if (error && !folder.empty()) throw base::ConfigError("cannot read " + folder.string());
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    std::error_code none;
    if (std::filesystem::is_regular_file(entry->path(), none)) paths.push_back(entry->path());
    if (paths.size() > kMostFiles) {
      throw base::ConfigError(fmt::format("{}: has more than {} files",
                                          entry->path().parent_path().string(), kMostFiles));
    }
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    throw base::ConfigError("cannot read " + listed.string() + ": " + error.message());
  }
  std::sort(paths.begin(), paths.end());
  paths.insert(paths.begin(), main);
  std::vector<RouterFile> files;
  for (const std::filesystem::path& path : paths) {
    files.push_back({path.string(), base::read_foreign_file(path, kKind, kMostBytes)});
  }
  return files;
}

RouterConfig::RouterConfig(const std::vector<RouterFile>& files) : files_(files) {
  for (place_.file = 0; place_.file < files_.size(); ++place_.file) read(files_[place_.file].text);
}

std::string RouterConfig::prefix(RouterPlace place) const {
  return fmt::format("{}:{}: ", files_[place.file].name, place.line);
}

void RouterConfig::fail(RouterPlace place, const std::string& sentence) const {
  throw base::ConfigError(prefix(place) + sentence);
}

void RouterConfig::read(std::string_view text) {
  section_ = nullptr;
  text = base::without_byte_order_mark(text);
  for (place_.line = 1; !text.empty(); ++place_.line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    read_line(trimmed(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

void RouterConfig::read_line(std::string_view text) {
  if (text.empty() || text.front() == '#' || text.front() == ';') return;
  if (text.front() == '[') {
    if (text.back() != ']') fail(place_, "a section ends with ]");
    const std::string_view head = trimmed(text.substr(1, text.size() - 2));
    const std::size_t blank = std::min(head.find_first_of(" \t"), head.size());
    open_section(lower(head.substr(0, blank)), std::string(trimmed(head.substr(blank))));
    return;
  }
  const std::size_t equals = text.find('=');
  if (equals == text.npos) fail(place_, "is neither [section] nor key = value");
  if (section_ == nullptr) fail(place_, "a key stands before the first section");
  const std::string key(trimmed(text.substr(0, equals)));
  section_->values[lower(key)] = {key, std::string(trimmed(text.substr(equals + 1))), place_,
                                  false};
}

/// A section that comes again goes on, in another file too; names have any case.
void RouterConfig::open_section(const std::string& kind, const std::string& name) {
  const auto same = [&](const RouterSection& each) {
    return each.kind == kind && lower(each.name) == lower(name);
  };
  auto found = std::find_if(sections_.begin(), sections_.end(), same);
  if (found == sections_.end()) {
    found = sections_.insert(sections_.end(), {kind, name, place_, {}});
  }
  section_ = &*found;
}

RouterValue* RouterConfig::find(RouterSection& section, std::string_view key) {
  const auto found = section.values.find(lower(key));
  if (found == section.values.end()) return nullptr;
  found->second.used = true;
  return &found->second;
}

std::string RouterConfig::required(RouterSection& section, std::string_view key) const {
  const RouterValue* value = find(section, key);
  if (value == nullptr || value->text.empty()) {
    fail(section.place, "endpoint '" + section.name + "' has no " + std::string(key));
  }
  return value->text;
}

std::uint64_t RouterConfig::number(std::string_view digits, const RouterValue& value,
                                   std::uint64_t most) const {
  std::uint64_t result = 0;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, result);
  if (error != std::errc{} || stop != end) {
    fail(value.place, fmt::format("{}: '{}' is not a number", value.key, digits));
  }
  if (result > most) fail(value.place, fmt::format("{}: is more than {}", value.key, most));
  return result;
}

std::vector<std::uint32_t> RouterConfig::numbers(const RouterValue& value,
                                                 std::uint32_t most) const {
  std::vector<std::uint32_t> list;
  std::string_view rest = value.text;
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    list.push_back(static_cast<std::uint32_t>(number(trimmed(rest.substr(0, comma)), value, most)));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return list;
}

RouterConfig::Ids RouterConfig::ids(RouterSection& section, std::string_view key,
                                    std::uint32_t most) const {
  const RouterValue* value = find(section, key);
  if (value == nullptr) return {};
  const auto list = numbers(*value, most);
  return {list.begin(), list.end()};
}

std::optional<unsigned> RouterConfig::port(RouterSection& section, std::string_view key) const {
  const RouterValue* value = find(section, key);
  if (value == nullptr) return std::nullopt;
  return static_cast<unsigned>(number(value->text, *value, 65535));
}

bool RouterConfig::flag(RouterSection& section, std::string_view key) const {
  const RouterValue* value = find(section, key);
  if (value == nullptr) return false;
  const std::string word = lower(value->text);
  if (word == "true" || word == "yes" || word == "1" || word == "on") return true;
  if (word == "false" || word == "no" || word == "0" || word == "off") return false;
  fail(value->place, value->key + ": is true or false");
}

namespace {

std::string word(std::uint32_t id, bool messages) {
  const mav::MessageInfo* known = messages ? mav::public_table().find(id) : nullptr;
  return known == nullptr ? std::to_string(id) : std::string(known->name);
}

RouterConfig::Ids simulator_messages() {
  RouterConfig::Ids ids;
  for (const std::string_view name : kSimulatorMessages)
    ids.insert(mav::public_table().find(name)->id);
  return ids;
}

}  // namespace

std::string id_list(const char* key, const RouterConfig::Ids& list, bool messages) {
  const auto word_of = [messages](std::uint32_t id) { return word(id, messages); };
  return std::string(key) + ": [" + base::joined(list, ", ", word_of) + "]";
}

std::string rule_between(const RouterFilters& from, const RouterFilters& to) {
  std::string text;
  const auto add = [&](const char* key, const RouterConfig::Ids& list, bool messages) {
    if (!list.empty()) text += ", " + id_list(key, list, messages);
  };
  const auto both = [](RouterConfig::Ids one, RouterConfig::Ids other) {
    one.merge(other);
    return one;
  };
  add("allow", to.allow_messages_out, true);
  RouterConfig::Ids block = both(from.block_messages_in, to.block_messages_out);
  if (to.allow_messages_out.empty()) block.merge(simulator_messages());
  add("block", block, true);
  add("allow_systems", to.allow_systems_out, false);
  add("block_systems", to.block_systems_out, false);
  RouterConfig::Ids components = both(from.allow_components_in, to.allow_components_out);
  if (!from.allow_components_in.empty() && !to.allow_components_out.empty()) {
    std::erase_if(components, [&](std::uint32_t id) {
      return !from.allow_components_in.contains(id) || !to.allow_components_out.contains(id);
    });
    if (components.empty()) return ", allow: []";  // an empty list of components is all
  }
  add("allow_components", components, false);
  add("block_components", both(from.block_components_in, to.block_components_out), false);
  return text;
}

}  // namespace cas::casd
