// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace cas::web {

/// A file of the page, as it is sent.
struct PageFile {
  std::string body{};
  std::string gzip{};  ///< the same compressed, from FILE.gz; empty: there is none
  const char* type = "application/octet-stream";
  bool immutable = false;  ///< its name has a hash of its content
};

/// The built page, read once: requests find a file by its name in memory, never by a path.
class PageFiles {
 public:
  /// @param folder  nullopt: a page that says that none was built
  /// @throws base::ConfigError when the folder has no index.html, or a file cannot be read
  explicit PageFiles(const std::optional<std::filesystem::path>& folder);

  /// The file of a request's target, "/" or "/assets/page-4f1c.js?x"; nullptr: there is none.
  const PageFile* find(std::string_view target) const;

 private:
  void read(const std::filesystem::path& file, const std::string& name);

  std::map<std::string, PageFile, std::less<>> files_;  // by target
};

}  // namespace cas::web
