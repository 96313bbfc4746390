// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/emulator/emulator_line.hpp"

#include <algorithm>

#include "base/random.hpp"

namespace cas::fcu {

EmulatorLine::EmulatorLine(const LineConfig& config, std::uint64_t seed)
    : up_(config, base::derive_seed(seed, "line_up")),
      down_(config, base::derive_seed(seed, "line_down")) {}

std::size_t EmulatorLine::up_room(base::RunTime now) const { return up_.room(now); }

void EmulatorLine::send(std::span<const std::uint8_t> packet, base::RunTime now) {
  if (held_ || down_.room(now) < packet.size()) {
    ++dropped_packets_;
    return;
  }
  down_.write(packet, now);
}

std::optional<base::RunTime> EmulatorLine::next_event(base::RunTime now) const {
  std::optional<base::RunTime> next;
  const auto earlier = [&next](std::optional<base::RunTime> t) {
    if (t && (!next || *t < *next)) next = t;
  };
  earlier(up_.next_arrival());
  earlier(down_.next_arrival());
  earlier(up_.room_at(now));
  return next;
}

void EmulatorLine::configure(const LineConfig& config) {
  up_.configure(config);
  down_.configure(config);
}

void EmulatorLine::hang_up() {
  up_.hang_up();
  down_.hang_up();
  held_ = false;
}

void EmulatorLine::restore() {
  up_.restore();
  down_.restore();
}

}  // namespace cas::fcu
