// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/companion_link.hpp"

#include <chrono>

#include "base/error.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {
namespace {

constexpr base::Duration kTickPeriod = std::chrono::milliseconds(20);

}  // namespace

CompanionLink::CompanionLink() : socket_("cannot open a UDP port for setpoints and missions") {}

void CompanionLink::connect(std::uint16_t casd_port, mav::Source vehicle) {
  if (!socket_.connect(casd_port)) {
    throw base::ConfigError("cannot reach casd's port for setpoints and missions");
  }
  {
    base::MutexLock lock(mutex_);
    station_.emplace(vehicle,
                     [this](std::span<const std::uint8_t> packet) { socket_.send(packet); });
  }
  thread_.emplace(socket_.fd(), kTickPeriod, [this] { look(); });
}

void CompanionLink::look() {
  base::MutexLock lock(mutex_);
  while (true) {
    const std::span<const std::uint8_t> bytes = socket_.read();
    if (bytes.empty()) break;
    station_->on_bytes(bytes, base::steady_now());
  }
  station_->tick(base::steady_now());
}

}  // namespace cas::hils
