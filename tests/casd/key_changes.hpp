// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "base/config/config_keys.hpp"
#include "casd/topology/topology.hpp"

namespace cas::test {

/// Another value of one key of a topology. Made from the keys that casd reads, so that a new key
/// has its case. "$DIR" is a folder with the files `a.key` and `b.key`.
struct KeyChange {
  std::string key;
  std::string before;
  std::array<std::string, 2> after;  ///< one of them at least differs from `before`

  friend std::ostream& operator<<(std::ostream& out, const KeyChange& change) {
    return out << change.key;
  }
};

/// "queue.hil_max_age_ms" -> "9".
using Keys = std::map<std::string, std::string>;

/// The keys as one entry of a list, "{name: a, queue: {hil_max_age_ms: 9}}", or as lines.
inline std::string yaml_of(const Keys& keys, bool lines = false) {
  std::map<std::string, std::string> values;
  std::map<std::string, Keys> blocks;
  for (const auto& [path, value] : keys) {
    const std::size_t dot = path.find('.');
    if (dot == path.npos) {
      values[path] = value;
    } else {
      blocks[path.substr(0, dot)][path.substr(dot + 1)] = value;
    }
  }
  for (const auto& [name, block] : blocks) values[name] = yaml_of(block);
  std::string text;
  for (const auto& [key, value] : values) {
    if (!text.empty()) text += lines ? "\n" : ", ";
    text += key + ": " + value;
  }
  return lines ? text + "\n" : "{" + text + "}";
}

/// A change for each key that has examples.
/// @param base  keys that are always there
/// @param beside  keys that a block needs beside the changed one
inline std::vector<KeyChange> changes_of(const std::vector<base::KeyRow>& rows, const Keys& base,
                                         const Keys& beside, bool lines = false) {
  static const std::map<std::string, std::array<std::string, 2>> kFiles{
      {"signing.key_file", {"$DIR/a.key", "$DIR/b.key"}},
      {"dialect", {"$DIR/a.key", "$DIR/b.key"}},
      {"gains", {"$DIR/a.key", "$DIR/b.key"}}};
  std::vector<KeyChange> changes;
  for (const base::KeyRow& row : rows) {
    const auto files = kFiles.find(row.key);
    const auto& samples = files == kFiles.end() ? row.samples : files->second;
    if (samples[0].empty()) continue;  // a block: its keys have rows of their own
    Keys before = base;
    const std::string block = row.key.substr(0, row.key.find('.') + 1);
    for (const auto& [key, value] : beside) {
      if (!block.empty() && key.starts_with(block)) before.emplace(key, value);
    }
    if (row.required) before[row.key] = samples[0];
    KeyChange change{row.key, yaml_of(before, lines), {}};
    for (std::size_t i = 0; i < 2; ++i) {
      if (samples[i].empty()) continue;
      Keys after = before;
      after[row.key] = samples[i];
      change.after[i] = yaml_of(after, lines);
    }
    changes.push_back(std::move(change));
  }
  return changes;
}

/// Of the keys of links: those of each type, with those that all have. `before` and `after` are one
/// entry of `links`.
inline std::vector<KeyChange> link_changes(casd::LinkType type) {
  using casd::LinkType;
  Keys base{{"name", "x"}, {"type", std::string(to_string(type))}};
  if (type == LinkType::kUdp) base["local"] = "'127.0.0.1:0'";
  if (type == LinkType::kSerial) base["baud"] = "921600";
  const std::vector<base::KeyRow> own = casd::link_rows(type);
  for (const base::KeyRow& row : own) {
    if (row.required) base[row.key] = row.samples[0];
  }
  std::vector<base::KeyRow> rows = casd::link_rows({});
  if (type != LinkType::kUdp) {  // the keys of another type than udp and udp_server are others
    std::erase_if(rows, [](const base::KeyRow& row) { return row.key == "type"; });
  }
  rows.insert(rows.end(), own.begin(), own.end());
  return changes_of(rows, base,
                    {{"accept.messages", "[HEARTBEAT]"}, {"signing.key_file", "$DIR/a.key"}});
}

/// Of casd's own keys, as lines of a topology.
inline std::vector<KeyChange> topology_changes(const std::vector<base::KeyRow>& rows) {
  return changes_of(rows,
                    {{"command_port.port", "0"}, {"command_port.loopback_without_token", "true"}},
                    {{"log.folder", "$DIR/logs"}, {"metrics.port", "0"}}, true);
}

}  // namespace cas::test
