// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/runtime_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <optional>

#include "base/error.hpp"

namespace cas::base {
namespace {

constexpr const char* kRuntimeVariable = "CAS_RUNTIME_DIR";

/// An empty variable counts as none.
std::optional<std::string> variable(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr || *value == '\0') return std::nullopt;
  return value;
}

bool is_writable_folder(const std::filesystem::path& folder) {
  std::error_code ignored;
  return std::filesystem::is_directory(folder, ignored) && ::access(folder.c_str(), W_OK) == 0;
}

/// Any user may make a folder in /tmp: one that is not ours alone is refused.
std::filesystem::path private_folder() {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("cas-" + std::to_string(::getuid()));
  ::mkdir(folder.c_str(), 0700);
  struct stat status {};
  const bool there = ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
  if (!there || status.st_uid != ::getuid() || (status.st_mode & 077) != 0) {
    throw ConfigError(folder.string() +
                      " is no private folder of yours (mode 0700); set CAS_RUNTIME_DIR to one");
  }
  return folder;
}

std::string value_of(const std::string& name) {
  if (const auto value = variable(name.c_str())) return *value;
  if (name == kRuntimeVariable) return runtime_folder().string();
  throw ConfigError("environment variable " + name + " is not set");
}

}  // namespace

std::filesystem::path runtime_folder(const std::filesystem::path& service_folder) {
  if (const auto named = variable(kRuntimeVariable)) return *named;
  if (const auto user = variable("XDG_RUNTIME_DIR"); user && is_writable_folder(*user)) {
    return std::filesystem::path(*user) / "cas";
  }
  if (is_writable_folder(service_folder)) return service_folder;
  return private_folder();
}

std::string expand_variables(std::string_view text) {
  std::string expanded;
  while (true) {
    const std::size_t begin = text.find("${");
    expanded += text.substr(0, begin);
    if (begin == std::string_view::npos) return expanded;
    const std::size_t end = text.find('}', begin);
    if (end == std::string_view::npos) {
      throw ConfigError("'" + std::string(text.substr(begin)) + "' has no closing brace");
    }
    expanded += value_of(std::string(text.substr(begin + 2, end - begin - 2)));
    text.remove_prefix(end + 1);
  }
}

}  // namespace cas::base
