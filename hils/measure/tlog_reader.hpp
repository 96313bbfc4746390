// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

/// Calls `on_packet` for each intact packet of a telemetry log: records of eight bytes (big-endian
/// microseconds since 1970) and one packet. Bytes that are neither are skipped.
/// @throws base::ConfigError when the file cannot be read
void read_tlog(const std::filesystem::path& file,
               const std::function<void(std::int64_t stamp_us, const mav::PacketView&)>& on_packet);

}  // namespace cas::hils
