// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/local_port.hpp"

#include <arpa/inet.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "base/error.hpp"
#include "base/os/runtime_folder.hpp"
#include "base/rpc/client_places.hpp"

namespace cas::base::rpc {

namespace fs = std::filesystem;

namespace {

/// A folder, no symlink, that belongs to this user or to root and that others may not write into.
bool is_trusted(const struct stat& status) {
  return S_ISDIR(status.st_mode) && (status.st_uid == ::geteuid() || status.st_uid == 0) &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Where casd of this machine may have its sockets and tokens. A folder that another user could
/// have made is left out.
std::vector<fs::path> runtime_folders() {
  std::vector<fs::path> folders;
  try {
    const fs::path own = runtime_folder(kServiceFolder);
    struct stat status {};
    const bool there = ::lstat(own.c_str(), &status) == 0;
    if (own != kServiceFolder && there && is_trusted(status)) folders.push_back(own);
  } catch (const ConfigError&) {
    // Another user's folder is at this user's path.
  }
  folders.emplace_back(kServiceFolder);  // only root can have made it
  return folders;
}

/// The sockets of casd in one folder, by name; those of strangers are left out.
std::vector<fs::path> sockets_in(const fs::path& folder) {
  std::vector<fs::path> sockets;
  struct stat owner {};
  if (::lstat(folder.c_str(), &owner) != 0 || !S_ISDIR(owner.st_mode)) return sockets;
  const auto is_trusted_user = [&owner](uid_t user) {
    return user == ::geteuid() || user == 0 || user == owner.st_uid;
  };
  std::error_code end;  // a folder that is gone, or that this user may not list
  for (fs::directory_iterator entry(folder, end), none; !end && entry != none;
       entry.increment(end)) {
    struct stat status {};
    if (!is_command_socket_name(entry->path().filename().native()) ||
        ::lstat(entry->path().c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) {
      continue;
    }
    if (is_trusted_user(status.st_uid)) sockets.push_back(entry->path());
  }
  std::sort(sockets.begin(), sockets.end());
  return sockets;
}

}  // namespace

fs::path make_runtime_folder() {
  const fs::path folder = runtime_folder(kServiceFolder);
  if (::mkdir(folder.c_str(), S_IRWXU) != 0 && errno != EEXIST) {
    throw ConfigError(folder.string() + ": cannot be made: " + error_text(errno));
  }
  struct stat status {};
  const bool there = ::lstat(folder.c_str(), &status) == 0;
  const bool own = there && S_ISDIR(status.st_mode) && status.st_uid == ::geteuid();
  if (own && folder == kServiceFolder) return folder;  // the unit sets its permissions
  if (!there || !is_trusted(status)) {
    throw ConfigError(
        folder.string() +
        ": is no folder of yours that you alone may write into (chmod go-w, if it is); set "
        "CAS_RUNTIME_DIR");
  }
  return folder;
}

std::string command_socket_name(std::uint16_t port) {
  return port == kCommandPort ? "casd.sock" : "casd-" + std::to_string(port) + ".sock";
}

bool is_command_socket_name(std::string_view name) {
  return name == "casd.sock" || (name.starts_with("casd-") && name.ends_with(".sock"));
}

bool is_loopback_address(const std::string& address) {
  if (address == "localhost") return true;
  sockaddr_in v4{};
  v4.sin_family = AF_INET;
  if (::inet_pton(AF_INET, address.c_str(), &v4.sin_addr) == 1) {
    return tcp_origin(reinterpret_cast<const sockaddr&>(v4)).loopback;
  }
  sockaddr_in6 v6{};
  v6.sin6_family = AF_INET6;
  if (::inet_pton(AF_INET6, address.c_str(), &v6.sin6_addr) != 1) return false;
  return tcp_origin(reinterpret_cast<const sockaddr&>(v6)).loopback;
}

std::vector<fs::path> local_command_sockets() {
  std::vector<fs::path> sockets;
  for (const fs::path& folder : runtime_folders()) {
    const std::vector<fs::path> found = sockets_in(folder);
    sockets.insert(sockets.end(), found.begin(), found.end());
  }
  return sockets;
}

std::vector<fs::path> local_command_tokens() {
  std::vector<fs::path> tokens;
  std::vector<fs::path> folders = runtime_folders();
  folders.emplace_back(kServiceState);
  for (const fs::path& folder : folders) {
    const fs::path path = folder / kCommandToken;
    if (::access(path.c_str(), R_OK) == 0) tokens.push_back(path);
  }
  return tokens;
}

}  // namespace cas::base::rpc
