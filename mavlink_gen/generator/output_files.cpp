// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/output_files.hpp"

#include <fstream>
#include <set>
#include <system_error>

namespace cas::mav::gen {
namespace {

namespace fs = std::filesystem;

bool holds(const fs::path& path, const std::string& text) {
  std::error_code error;
  if (fs::file_size(path, error) != text.size() || error) return false;
  std::ifstream stream(path, std::ios::binary);
  std::string present(text.size(), '\0');
  stream.read(present.data(), static_cast<std::streamsize>(present.size()));
  return stream.good() && present == text;
}

bool write_aside(const fs::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  return stream.good();
}

}  // namespace

std::optional<std::string> write_files(const std::filesystem::path& folder, const Files& files) {
  std::error_code error;
  std::set<fs::path> made;
  for (const auto& [name, text] : files) {
    const auto path = folder / name;
    if (made.insert(path.parent_path()).second) {
      fs::create_directories(path.parent_path(), error);
      if (error) return "cannot create " + path.parent_path().string() + ": " + error.message();
    }
    if (holds(path, text)) continue;
    auto aside = path;
    aside += ".new";
    if (!write_aside(aside, text)) {
      fs::remove(aside, error);
      return "cannot write " + aside.string();
    }
    fs::rename(aside, path, error);
    if (error) return "cannot replace " + path.string() + ": " + error.message();
  }
  return std::nullopt;
}

}  // namespace cas::mav::gen
