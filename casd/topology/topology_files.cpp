// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology_files.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <string>
#include <system_error>

#include "base/error.hpp"

namespace cas::casd {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 100;

/// Whoever can write an overlay, or put one into the folder, configures casd: nobody may who cannot
/// write FILE itself. @param over  the folder, or a file in it
void refuse_foreign(const fs::path& over, const fs::path& file) {
  struct stat of_over {};
  struct stat of_file {};
  if (::stat(over.c_str(), &of_over) != 0 || ::stat(file.c_str(), &of_file) != 0) return;
  const auto refuse = [&over](const std::string& why) {
    throw base::ConfigError(over.string() + ": " + why + "; it is not read");
  };
  const uid_t owner = of_over.st_uid;
  if (owner != 0 && owner != ::geteuid() && owner != of_file.st_uid) {
    refuse("belongs to another user than " + file.string());
  }
  if ((of_over.st_mode & S_IWOTH) != 0) refuse("everybody may write to it (chmod o-w)");
  const bool of_group = (of_over.st_mode & S_IWGRP) != 0 && of_over.st_gid != 0;
  const bool also_file = (of_file.st_mode & S_IWGRP) != 0 && of_file.st_gid == of_over.st_gid;
  if (of_group && !also_file) {
    refuse("its group may write to it, but not to " + file.string() + " (chmod g-w)");
  }
}

std::vector<fs::path> yaml_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const fs::path& path = entry->path();
    std::error_code none;
    const bool hidden = path.filename().string().starts_with('.');
    if (hidden || !fs::is_regular_file(path, none)) continue;
    if (path.extension() == ".yml") {
      throw base::ConfigError(path.string() + ": the name of a topology's file ends in .yaml");
    }
    if (path.extension() != ".yaml") continue;
    files.push_back(path);
    if (files.size() > kMostFiles) {
      throw base::ConfigError(
          fmt::format("{}: has more than {} *.yaml files", folder.string(), kMostFiles));
    }
  }
  if (error) throw base::ConfigError(folder.string() + ": " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> files_of(const fs::path& place) {
  std::error_code none;
  if (fs::is_directory(place, none)) {
    std::vector<fs::path> files = yaml_files(place);
    if (files.empty()) throw base::ConfigError(place.string() + ": the folder has no *.yaml file");
    return files;
  }
  std::vector<fs::path> files{place};
  const fs::path folder = fs::path(place).replace_extension(".d");
  if (!fs::is_directory(folder, none)) return files;
  refuse_foreign(folder, place);
  const std::vector<fs::path> over = yaml_files(folder);
  for (const fs::path& each : over) refuse_foreign(each, place);
  files.insert(files.end(), over.begin(), over.end());
  return files;
}

std::string text_of(const base::ConfigNode& value) {
  if (value.is_scalar()) return value.as<std::string>();
  if (!value.is_list()) return "";
  std::string text = "[";
  for (const base::ConfigNode& item : value.items()) text += text_of(item) + ", ";
  return text + "]";
}

/// Empty: it has none, because a key is missing.
std::string identity_of(const base::ConfigNode& entry,
                        const std::vector<std::string_view>& identity) {
  if (!entry.is_map()) return "";
  std::string text;
  for (const std::string_view key : identity) {
    const auto value = entry.find(key);
    if (!value) return "";
    text += text_of(*value) + '\n';
  }
  return text;
}

}  // namespace

std::vector<base::ConfigNode> load_topology_files(const fs::path& place) {
  std::vector<base::ConfigNode> nodes;
  for (const fs::path& file : files_of(place)) nodes.push_back(base::ConfigNode::load(file));
  return nodes;
}

base::ConfigNode overlaid(const std::vector<base::ConfigNode>& files) {
  base::ConfigNode all = files.front();
  for (std::size_t i = 1; i < files.size(); ++i) all = files[i].merged_over(all);
  return all;
}

std::vector<base::ConfigNode> overlaid_list(const std::vector<base::ConfigNode>& files,
                                            std::string_view list,
                                            const std::vector<std::string_view>& identity) {
  std::vector<base::ConfigNode> entries;
  std::vector<std::string> identities;
  for (const base::ConfigNode& file : files) {
    const auto own = file.find(list);
    if (!own) continue;
    const std::size_t earlier = entries.size();
    std::vector<bool> overlaid_here(earlier, false);
    for (const base::ConfigNode& entry : own->items()) {
      const std::string same = identity_of(entry, identity);
      std::size_t at = 0;
      while (at < earlier && (same.empty() || identities[at] != same)) ++at;
      if (at < earlier) {
        if (overlaid_here[at]) entry.fail("is in this file already");
        entries[at] = entry.merged_over(entries[at]);
        overlaid_here[at] = true;
      } else {
        entries.push_back(entry);
        identities.push_back(same);
      }
    }
  }
  return entries;
}

}  // namespace cas::casd
