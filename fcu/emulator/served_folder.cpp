// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/emulator/served_folder.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <system_error>

#include "base/error.hpp"

namespace cas::fcu {

namespace fs = std::filesystem;
using mav::services::FtpEntry;
using mavlink::common::MavFtpErr;

namespace {

constexpr ServedFolder::Failure kNotFound{.code = MavFtpErr::kFilenotfound};

/// As the protocol can tell it.
std::uint32_t size_of(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) return 0;
  constexpr std::uintmax_t kMost = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::uint32_t>(std::min(size, kMost));
}

}  // namespace

ServedFolder::ServedFolder(const fs::path& folder) {
  std::error_code error;
  folder_ = fs::canonical(folder, error);
  if (error || !fs::is_directory(folder_, error)) {
    throw base::ConfigError("--files: there is no folder " + folder.string());
  }
}

/// Where a path leads. @return nothing when that is not inside the folder, or not there
std::optional<fs::path> ServedFolder::inside(const fs::path& path) const {
  std::error_code error;
  fs::path real = fs::canonical(folder_ / path, error);
  if (error) return std::nullopt;
  const auto [end, rest] = std::mismatch(folder_.begin(), folder_.end(), real.begin(), real.end());
  return end == folder_.end() ? std::optional(std::move(real)) : std::nullopt;
}

ServedFolder::Failure ServedFolder::list(const std::string& folder,
                                         std::vector<FtpEntry>& entries) {
  const auto real = inside(folder);
  std::error_code error;
  if (!real || !fs::is_directory(*real, error)) return kNotFound;
  for (fs::directory_iterator each(*real, error), end; !error && each != end;
       each.increment(error)) {
    const std::string name = each->path().filename().string();
    const auto target = inside(fs::path(folder) / name);
    std::error_code gone;
    if (!target) continue;
    if (fs::is_directory(*target, gone)) {
      entries.push_back({.folder = true, .name = name});
    } else if (fs::is_regular_file(*target, gone)) {
      entries.push_back({.name = name, .size = size_of(*target)});
    }
  }
  if (error) {
    return {.code = MavFtpErr::kFailerrno,
            .error_number = static_cast<std::uint8_t>(error.value())};
  }
  std::ranges::sort(entries, {}, &FtpEntry::name);
  return {};
}

ServedFolder::Failure ServedFolder::length(const std::string& path, std::uint32_t& bytes) {
  const auto real = inside(path);
  std::error_code error;
  if (!real || !fs::is_regular_file(*real, error)) return kNotFound;
  bytes = size_of(*real);
  return {};
}

ServedFolder::Failure ServedFolder::read(const std::string& path, std::uint32_t offset,
                                         std::span<std::uint8_t>& out) {
  const auto real = inside(path);
  if (!real) return kNotFound;
  std::ifstream file(*real, std::ios::binary);
  file.seekg(offset);
  file.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
  if (file.bad()) return {.code = MavFtpErr::kFail};
  out = out.first(static_cast<std::size_t>(file.gcount()));
  return {};
}

}  // namespace cas::fcu
