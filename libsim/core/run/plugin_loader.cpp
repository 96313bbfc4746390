// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/plugin_loader.hpp"

#include <dlfcn.h>

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <exception>
#include <string_view>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/suggestion.hpp"

namespace cas::sim {

namespace {

constexpr const char* kEntryPoint = "cas_plugin_v1";
constexpr const char* kSendsEntryPoint = "cas_plugin_sends_v1";
constexpr std::size_t kMostMessages = 32;  ///< that one plugin may declare
constexpr std::size_t kMostNameBytes = 64;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& sentence) {
  throw base::ConfigError("plugin " + file.string() + ": " + sentence);
}

/// A name is a name, not a way out of the plugin folders.
bool is_bare_name(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

std::string text_or_none(const char* text) { return text == nullptr ? "(none)" : text; }

void check(const PluginDescriptor& descriptor, const std::filesystem::path& file,
           const std::string& name) {
  if (descriptor.struct_size != sizeof(PluginDescriptor)) {
    refuse(file, fmt::format("its descriptor has {} bytes, this program's {}: built against "
                             "another version of CAS",
                             descriptor.struct_size, sizeof(PluginDescriptor)));
  }
  const std::string tag = text_or_none(descriptor.abi_tag);
  if (tag != CAS_ABI_TAG) {
    refuse(file, "was built for '" + tag + "', this program for '" CAS_ABI_TAG "': rebuild it");
  }
  if (text_or_none(descriptor.name) != name) {
    refuse(file, "calls itself '" + text_or_none(descriptor.name) + "'");
  }
  if (descriptor.create == nullptr || descriptor.destroy == nullptr) {
    refuse(file, "its descriptor lacks create or destroy");
  }
}

void* open_library(const std::filesystem::path& file) {
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) refuse(file, std::string("cannot be opened: ") + dlerror());
  return library;
}

/// Names of the plugins in these folders: "motor" for libmotor.so.
std::vector<std::string> names_in(const std::vector<std::filesystem::path>& folders) {
  constexpr std::string_view kPrefix = "lib";
  std::vector<std::string> names;
  for (const std::filesystem::path& folder : folders) {
    std::error_code error;
    std::filesystem::directory_iterator entry(folder, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
      const std::filesystem::path& file = entry->path();
      const std::string stem = file.stem().string();
      const bool is_plugin = file.extension() == ".so" && stem.starts_with(kPrefix);
      if (is_plugin) names.push_back(stem.substr(kPrefix.size()));
    }
  }
  return names;
}

/// A name of MAVLink, or an id.
bool is_message_word(std::string_view word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace

PluginLoader::PluginLoader(std::vector<std::filesystem::path> first_dirs)
    : dirs_(std::move(first_dirs)) {
  for (auto& dir : base::plugin_dirs()) dirs_.push_back(std::move(dir));
}

std::filesystem::path PluginLoader::find(const std::string& name) const {
  if (!is_bare_name(name)) {
    throw base::ConfigError("plugin '" + name + "': a plugin is named by letters, digits, _ and -");
  }
  std::string searched;
  for (const auto& dir : dirs_) {
    const std::filesystem::path file = dir / ("lib" + name + ".so");
    std::error_code error;
    if (std::filesystem::exists(file, error)) return std::filesystem::absolute(file);
    searched += (searched.empty() ? "" : ", ") + dir.string();
  }
  throw base::ConfigError("plugin '" + name + "': no lib" + name + ".so in " +
                          (searched.empty() ? "any folder (none to search)" : searched) +
                          base::did_you_mean(name, names_in(dirs_)));
}

const PluginDescriptor& PluginLoader::open(const std::string& name) {
  if (const auto known = open_.find(name); known != open_.end()) return *known->second;
  const std::filesystem::path file = find(name);
  void* const library = open_library(file);
  void* const symbol = dlsym(library, kEntryPoint);
  if (symbol == nullptr) refuse(file, std::string("has no symbol ") + kEntryPoint);
  const auto entry = reinterpret_cast<const PluginDescriptor* (*)()>(symbol);
  const PluginDescriptor* const descriptor = entry();
  if (descriptor == nullptr) refuse(file, "returns no descriptor");
  check(*descriptor, file, name);
  open_.emplace(name, descriptor);
  return *descriptor;
}

std::vector<std::string> PluginLoader::sends(const std::string& name) {
  open(name);
  const std::filesystem::path file = find(name);
  void* const symbol = dlsym(open_library(file), kSendsEntryPoint);
  std::vector<std::string> messages;
  if (symbol == nullptr) return messages;
  const auto entry = reinterpret_cast<const char* const* (*)()>(symbol);
  for (const char* const* word = entry(); word != nullptr && *word != nullptr; ++word) {
    if (messages.size() == kMostMessages) {
      refuse(file, fmt::format("declares more than {} MAVLink messages", kMostMessages));
    }
    const std::string_view text(*word, strnlen(*word, kMostNameBytes + 1));
    if (text.size() > kMostNameBytes || !is_message_word(text)) {
      refuse(file, "declares '" + std::string(text) + "', which is no name or id of MAVLink");
    }
    messages.emplace_back(text);
  }
  return messages;
}

PluginPtr PluginLoader::create(const std::string& name) {
  const PluginDescriptor& descriptor = open(name);
  Plugin* plugin = nullptr;
  try {
    plugin = descriptor.create();
  } catch (const std::exception& error) {
    throw base::ConfigError("plugin '" + name + "': create failed: " + error.what());
  } catch (...) {
    throw base::ConfigError("plugin '" + name + "': create failed with an unknown exception");
  }
  if (plugin == nullptr) throw base::ConfigError("plugin '" + name + "': create made nothing");
  return PluginPtr(plugin, PluginDeleter{&descriptor});
}

}  // namespace cas::sim
