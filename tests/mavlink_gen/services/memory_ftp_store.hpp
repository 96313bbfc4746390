// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "mavlink_gen/services/ftp_server.hpp"

namespace cas::mav::services {

/// Files of one test, by path; a file "full" takes no bytes.
class MemoryFtpStore final : public FtpStore {
 public:
  using Err = mavlink::common::MavFtpErr;
  using Bytes = std::vector<std::uint8_t>;
  std::map<std::string, Bytes> files;
  int listings = 0;  ///< calls of list()

  FtpFailure list(const std::string& folder, std::vector<FtpEntry>& entries) override {
    ++listings;
    const std::string head = folder.empty() ? "" : folder + '/';
    std::set<std::string> folders;
    for (const auto& [path, bytes] : files) {
      if (!path.starts_with(head)) continue;
      const std::string rest = path.substr(head.size());
      const std::size_t slash = rest.find('/');
      if (slash == std::string::npos) {
        entries.push_back({false, rest, static_cast<std::uint32_t>(bytes.size())});
      } else if (folders.insert(rest.substr(0, slash)).second) {
        entries.push_back({true, rest.substr(0, slash), 0});
      }
    }
    return entries.empty() && !folder.empty() ? FtpFailure{Err::kFilenotfound} : FtpFailure{};
  }
  FtpFailure length(const std::string& path, std::uint32_t& bytes) override {
    if (!files.contains(path)) return {Err::kFilenotfound};
    bytes = static_cast<std::uint32_t>(files[path].size());
    return {};
  }
  FtpFailure read(const std::string& path, std::uint32_t offset,
                  std::span<std::uint8_t>& out) override {
    const Bytes& bytes = files[path];
    const std::size_t at = std::min<std::size_t>(offset, bytes.size());
    out = out.first(std::min(out.size(), bytes.size() - at));
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), out.size(), out.begin());
    return {};
  }
  FtpFailure create(const std::string& path) override {
    if (path == "protected") return {Err::kFileprotected};
    files[path].clear();
    return {};
  }
  FtpFailure write(const std::string& path, std::uint32_t offset,
                   std::span<const std::uint8_t> bytes) override {
    if (path == "full") return {Err::kFailerrno, 28};
    Bytes& file = files[path];
    file.resize(std::max<std::size_t>(file.size(), offset + bytes.size()));
    std::copy(bytes.begin(), bytes.end(), file.begin() + offset);
    return {};
  }
  FtpFailure remove(const std::string& path) override {
    return files.erase(path) > 0 ? FtpFailure{} : FtpFailure{Err::kFilenotfound};
  }
};

}  // namespace cas::mav::services
