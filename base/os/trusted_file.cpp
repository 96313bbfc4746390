// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/trusted_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "base/error.hpp"

namespace cas::base {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw ConfigError(file.string() + ": " + why + "; it is not used");
}

bool is_own(uid_t user) { return user == 0 || user == ::geteuid(); }

}  // namespace

std::string why_untrusted(const struct stat& status) {
  if (!is_own(status.st_uid)) return "belongs to another user";
  if ((status.st_mode & S_IWOTH) != 0) return "everybody may write to it (chmod o-w)";
  const bool own_group = status.st_gid == 0 || status.st_gid == ::getegid();
  if ((status.st_mode & S_IWGRP) != 0 && !own_group) return "its group may write to it (chmod g-w)";
  return "";
}

void require_trusted(const std::filesystem::path& file) {
  struct stat link {};
  struct stat target {};
  struct stat folder {};
  const std::filesystem::path parent = file.has_parent_path() ? file.parent_path() : ".";
  if (::lstat(file.c_str(), &link) != 0 || ::stat(file.c_str(), &target) != 0 ||
      ::stat(parent.c_str(), &folder) != 0) {
    refuse(file, error_text(errno));
  }
  if (!is_own(link.st_uid)) refuse(file, "belongs to another user");
  if (const std::string why = why_untrusted(target); !why.empty()) refuse(file, why);
  if (!is_own(folder.st_uid)) refuse(file, "its folder belongs to another user");
  if ((folder.st_mode & S_ISVTX) == 0 && !why_untrusted(folder).empty()) {
    refuse(file, "others may write into its folder (chmod go-w, or +t)");
  }
  require_kept_folders(file);
}

void require_kept_folders(const std::filesystem::path& file) {
  std::error_code unresolved;
  for (const auto& path :
       {std::filesystem::absolute(file), std::filesystem::weakly_canonical(file, unresolved)}) {
    std::filesystem::path folder = path;
    while (folder.has_relative_path()) {
      folder = folder.parent_path();
      struct stat status {};
      if (::stat(folder.c_str(), &status) != 0) continue;  // then the file is not there either
      if ((status.st_mode & S_IWOTH) != 0 && (status.st_mode & S_ISVTX) == 0) {
        refuse(file, "everybody may write into " + folder.string() + " (chmod o-w, or +t)");
      }
    }
  }
}

}  // namespace cas::base
