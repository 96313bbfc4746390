// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/vehicle_files.hpp"

#include <algorithm>

namespace cas::fcu {

using mav::services::FtpEntry;
using mavlink::common::MavFtpErr;

namespace {

constexpr const char* kParams = "params.txt";
constexpr const char* kFolder = "files";
constexpr VehicleFiles::Failure kNotFound{.code = MavFtpErr::kFilenotfound};

}  // namespace

/// A path below the added folder.
std::optional<std::string> VehicleFiles::in_folder(const std::string& path) const {
  const std::string head = kFolder;
  if (folder_ == nullptr) return std::nullopt;
  if (path == head) return "";
  if (!path.starts_with(head + '/')) return std::nullopt;
  return path.substr(head.size() + 1);
}

const std::string& VehicleFiles::params_text() {
  if (revision_ != params_.revision()) text_ = params_.all_text();
  revision_ = params_.revision();
  return text_;
}

VehicleFiles::Failure VehicleFiles::list(const std::string& folder,
                                         std::vector<FtpEntry>& entries) {
  if (const auto below = in_folder(folder)) return folder_->list(*below, entries);
  if (!folder.empty()) return kNotFound;
  entries.push_back({.name = kParams, .size = static_cast<std::uint32_t>(params_text().size())});
  if (folder_ != nullptr) entries.push_back({.folder = true, .name = kFolder});
  return {};
}

VehicleFiles::Failure VehicleFiles::length(const std::string& path, std::uint32_t& bytes) {
  if (const auto below = in_folder(path)) return folder_->length(*below, bytes);
  if (path != kParams) return kNotFound;
  bytes = static_cast<std::uint32_t>(params_text().size());
  return {};
}

VehicleFiles::Failure VehicleFiles::read(const std::string& path, std::uint32_t offset,
                                         std::span<std::uint8_t>& out) {
  if (const auto below = in_folder(path)) return folder_->read(*below, offset, out);
  const std::string& text = params_text();
  const std::size_t at = std::min<std::size_t>(offset, text.size());
  out = out.first(std::min(out.size(), text.size() - at));
  std::copy_n(text.begin() + static_cast<std::ptrdiff_t>(at), out.size(), out.begin());
  return {};
}

}  // namespace cas::fcu
