// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/page_files.hpp"

#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/read_file.hpp"

namespace cas::web {
namespace {

namespace fs = std::filesystem;

constexpr std::pair<const char*, const char*> kTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".json", "application/json"},
    {".wasm", "application/wasm"},
    {".webmanifest", "application/json"},
    {".txt", "text/plain; charset=utf-8"},
};

/// Where the page's bundler puts files that have a hash in their names.
constexpr std::string_view kHashed = "/assets/";

constexpr const char* kNoPage =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>CAS</title>"
    "<p>casweb runs, but the page is not built: see docs/use/web.md.</p></html>\n";

const char* type_of(const fs::path& file) {
  for (const auto& [ending, type] : kTypes) {
    if (file.extension() == ending) return type;
  }
  return PageFile{}.type;
}

std::string content(const fs::path& file) {
  const auto text = base::read_file(file);
  if (!text) throw base::ConfigError(file.string() + ": cannot be read");
  return *text;
}

}  // namespace

PageFiles::PageFiles(const std::optional<fs::path>& folder) {
  if (!folder) {
    files_["/"] = {.body = kNoPage, .type = kTypes[0].second};
    return;
  }
  if (!fs::is_regular_file(*folder / "index.html")) {
    throw base::ConfigError(folder->string() + ": has no index.html");
  }
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(*folder, error)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".gz") continue;
    read(entry.path(), "/" + entry.path().lexically_relative(*folder).generic_string());
  }
  if (error) throw base::ConfigError(folder->string() + ": " + error.message());
  files_["/"] = files_["/index.html"];
}

void PageFiles::read(const fs::path& file, const std::string& name) {
  PageFile& entry = files_[name];
  entry.body = content(file);
  entry.type = type_of(file);
  entry.immutable = name.starts_with(kHashed);
  if (const fs::path compressed = file.string() + ".gz"; fs::is_regular_file(compressed)) {
    entry.gzip = content(compressed);
  }
}

const PageFile* PageFiles::find(std::string_view target) const {
  const auto found = files_.find(target.substr(0, target.find('?')));
  return found == files_.end() ? nullptr : &found->second;
}

}  // namespace cas::web
