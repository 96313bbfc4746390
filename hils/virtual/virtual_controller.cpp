// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_controller.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

#include "hils/virtual/flight_ledger.hpp"

namespace cas::hils {

namespace {

/// As fcu_emulator has it.
constexpr base::Duration kTickPeriod = std::chrono::milliseconds(5);
constexpr std::size_t kBufferBytes = 4096;

}  // namespace

VirtualController::VirtualController(const fcu::FcuConfig& config, OnBytes on_bytes)
    : line_(config.line, config.seed),
      controller_(config,
                  [this](std::span<const std::uint8_t> packet) { line_.send(packet, now_); }),
      ledger_(kLedgerEntries),
      on_bytes_(std::move(on_bytes)),
      buffer_(kBufferBytes) {
  controller_.set_hil_observer([this](std::uint32_t id, std::uint64_t time_usec, bool sent) {
    sent ? ledger_.sent(id, time_usec, now_) : ledger_.received(id, time_usec, now_);
  });
}

std::size_t VirtualController::write(std::span<const std::uint8_t> bytes, base::RunTime now) {
  const std::size_t taken = std::min(bytes.size(), line_.up_room(now));
  line_.receive(bytes.first(taken), now);
  return taken;
}

void VirtualController::run(base::RunTime now) {
  now_ = now;
  while (const std::size_t size = line_.up(buffer_, now)) {
    controller_.on_bytes(std::span(buffer_).first(size), now);
  }
  if (now >= next_tick_) {
    controller_.tick(now);
    next_tick_ = now + kTickPeriod;
  }
  while (const std::size_t size = line_.down(buffer_, now)) {
    on_bytes_(std::span(buffer_).first(size), now);
  }
}

base::RunTime VirtualController::next_event(base::RunTime now) const {
  const std::optional<base::RunTime> event = line_.next_event(now);
  return event ? std::min(*event, next_tick_) : next_tick_;
}

}  // namespace cas::hils
