// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

/// As udev writes a value into a link's name.
std::string as_in_link(std::string_view text) {
  std::string name(text);
  std::ranges::replace_if(
      name,
      [](unsigned char c) {
        return std::isalnum(c) == 0 &&
               std::string_view("#+-.:=@_").find(static_cast<char>(c)) == std::string_view::npos;
      },
      '_');
  return name;
}

std::string first_line(const fs::path& file) {
  std::string line;
  std::ifstream in(file);
  std::getline(in, line);
  return line;
}

/// Entries of a folder in the order of their names; none where it cannot be read.
std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (fs::directory_iterator at(folder, error); !error && at != fs::directory_iterator();
       at.increment(error)) {
    all.push_back(at->path());
  }
  std::ranges::sort(all);
  return all;
}

/// Whether `port`, a folder of /sys/class/tty, belongs to that interface of that USB device: both
/// are folders above its device.
bool is_port_of(const fs::path& port, std::string_view serial, unsigned interface) {
  std::error_code error;
  fs::path at = fs::canonical(port / "device", error);
  std::string number;
  while (!error && at.has_relative_path()) {
    if (number.empty()) number = first_line(at / "bInterfaceNumber");
    if (fs::exists(at / "serial", error)) {
      return first_line(at / "serial") == serial && number == fmt::format("{:02x}", interface);
    }
    at = at.parent_path();
  }
  return false;
}

}  // namespace

bool is_link_of(std::string_view link, std::string_view serial, unsigned interface) {
  if (serial.empty() || !link.starts_with("usb-")) return false;
  const std::string end = fmt::format("_{}-if{:02x}", as_in_link(serial), interface);
  const std::size_t at = link.rfind(end);
  if (at == std::string_view::npos) return false;
  const std::string_view behind = link.substr(at + end.size());
  return behind.empty() || behind.starts_with("-port");
}

std::optional<fs::path> find_device(const Board& board, const fs::path& by_id,
                                    const fs::path& sys_class_tty) {
  std::error_code error;
  if (board.serial.empty()) {
    return fs::exists(board.device, error) ? std::optional(board.device) : std::nullopt;
  }
  for (const fs::path& link : entries(by_id)) {
    if (is_link_of(link.filename().string(), board.serial, board.interface) &&
        fs::exists(link, error)) {
      return link;
    }
  }
  for (const fs::path& port : entries(sys_class_tty)) {
    if (is_port_of(port, board.serial, board.interface)) return "/dev" / port.filename();
  }
  return std::nullopt;
}

}  // namespace cas::hils
