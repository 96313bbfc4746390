// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "hils/boards/board_list.hpp"

namespace cas::hils {

/// Whether a link of udev's by-id folder is a serial port of this USB device:
/// "usb-VENDOR_MODEL_SERIAL-ifNN", with "-portN" behind it for adapters. Pure.
///
/// @param serial  the serial number as the device says it; udev writes '_' for any character but
///                letters, digits and #+-.:=@_
bool is_link_of(std::string_view link, std::string_view serial, unsigned interface);

/// Where the board's serial port is now: its `device`, or the port of the USB device with its
/// serial number, by udev's links (`by_id`), else by /sys (without udev, in a container).
/// @return nullopt when the board is not there
std::optional<std::filesystem::path> find_device(
    const Board& board, const std::filesystem::path& by_id,
    const std::filesystem::path& sys_class_tty = "/sys/class/tty");

}  // namespace cas::hils
