// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace cas::casd {

/// One file of mavlink-router's configuration.
struct RouterFile {
  std::string name;  ///< for errors
  std::string text;
};

/// main.conf and the files of a folder, in the order of their names as mavlink-router reads them.
/// @param folder  empty: config.d beside main.conf, which may be missing
/// @throws base::ConfigError when one cannot be read
std::vector<RouterFile> read_router_files(const std::filesystem::path& main,
                                          const std::filesystem::path& folder = {});

/// A line of a RouterConfig.
struct RouterPlace {
  std::size_t file = 0;
  int line = 0;

  friend auto operator<=>(const RouterPlace&, const RouterPlace&) = default;
};

/// A line `key = text`.
struct RouterValue {
  std::string key;  ///< as the file spells it
  std::string text;
  RouterPlace place;
  bool used = false;  ///< read by somebody
};

/// The lines below `[kind name]`.
struct RouterSection {
  std::string kind;  ///< lower case: "general", "uartendpoint", ...
  std::string name;
  RouterPlace place;
  std::map<std::string, RouterValue> values;  ///< by the key in lower case
};

/// Sections and values of mavlink-router's files. Names of sections and keys may have any case; of
/// a key that comes again the last value counts. Looking for a value marks it as used. Everything
/// but find() throws base::ConfigError "FILE:LINE: sentence" for what cannot be read.
class RouterConfig {
 public:
  using Ids = std::set<std::uint32_t>;

  /// @param files  outlive it
  explicit RouterConfig(const std::vector<RouterFile>& files);
  RouterConfig(const RouterConfig&) = delete;
  RouterConfig& operator=(const RouterConfig&) = delete;

  std::list<RouterSection>& sections() { return sections_; }
  const std::vector<RouterFile>& files() const { return files_; }
  /// "FILE:LINE: ".
  std::string prefix(RouterPlace place) const;
  /// Throws base::ConfigError with that place.
  [[noreturn]] void fail(RouterPlace place, const std::string& sentence) const;

  /// @return nullptr when the section has no such key
  static RouterValue* find(RouterSection& section, std::string_view key);
  /// The text of a key that must be there.
  std::string required(RouterSection& section, std::string_view key) const;
  /// @param digits  of the value: all of it, or a part
  std::uint64_t number(std::string_view digits, const RouterValue& value, std::uint64_t most) const;
  /// A list with commas.
  std::vector<std::uint32_t> numbers(const RouterValue& value, std::uint32_t most) const;
  /// Ids of messages; none when the key is missing.
  Ids messages(RouterSection& section, std::string_view key) const {
    return ids(section, key, 0xFFFFFF);
  }
  /// Ids of systems or components; none when the key is missing.
  Ids sources(RouterSection& section, std::string_view key) const { return ids(section, key, 255); }
  /// nullopt when the key is missing.
  std::optional<unsigned> port(RouterSection& section, std::string_view key) const;
  /// False when the key is missing.
  bool flag(RouterSection& section, std::string_view key) const;

 private:
  void read(std::string_view text);
  void read_line(std::string_view text);
  void open_section(const std::string& kind, const std::string& name);
  Ids ids(RouterSection& section, std::string_view key, std::uint32_t most) const;

  const std::vector<RouterFile>& files_;
  std::list<RouterSection> sections_;
  RouterPlace place_;                 ///< of the line being read
  RouterSection* section_ = nullptr;  ///< the one being read
};

/// What one endpoint lets in and out, as far as a route says it.
struct RouterFilters {
  using Ids = RouterConfig::Ids;

  Ids allow_messages_out, block_messages_out, block_messages_in;
  Ids allow_systems_out, block_systems_out;
  Ids allow_components_out, block_components_out, allow_components_in, block_components_in;
};

/// The keys of casd's route between two endpoints, ", block: [...]": what both allow, and nothing
/// that one of them blocks. Without an allow list sensor data of a simulator is blocked, too: it
/// would fly a vehicle in HIL.
std::string rule_between(const RouterFilters& from, const RouterFilters& to);

/// "allow: [HEARTBEAT, ATTITUDE]". @param messages  names for ids that have one
std::string id_list(const char* key, const RouterConfig::Ids& list, bool messages);

}  // namespace cas::casd
