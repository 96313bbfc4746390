// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual_controller.hpp"

#include <algorithm>
#include <chrono>

#include "base/random.hpp"

namespace cas::hils {

namespace {

constexpr base::Duration kTickPeriod = std::chrono::milliseconds(20);
constexpr std::size_t kBufferBytes = 4096;
constexpr std::size_t kLedgerEntries = 1 << 17;  ///< about two minutes of flight

}  // namespace

VirtualController::VirtualController(const fcu::FcuConfig& config, OnBytes on_bytes)
    : up_(config.line, base::derive_seed(config.seed, "line_up")),
      down_(config.line, base::derive_seed(config.seed, "line_down")),
      controller_(config, [this](std::span<const std::uint8_t> packet) { send(packet); }),
      ledger_(kLedgerEntries),
      on_bytes_(std::move(on_bytes)),
      buffer_(kBufferBytes) {
  controller_.set_hil_observer([this](std::uint32_t id, std::uint64_t time_usec, bool sent) {
    sent ? ledger_.sent(id, time_usec, now_) : ledger_.received(id, time_usec, now_);
  });
}

std::size_t VirtualController::write(std::span<const std::uint8_t> bytes, base::RunTime now) {
  return up_.write(bytes, now);
}

void VirtualController::run(base::RunTime now) {
  now_ = now;
  while (const std::size_t size = up_.read(buffer_, now)) {
    controller_.on_bytes(std::span(buffer_).first(size), now);
  }
  if (now >= next_tick_) {
    controller_.tick(now);
    next_tick_ = now + kTickPeriod;
  }
  push_down(now);
  while (const std::size_t size = down_.read(buffer_, now)) {
    on_bytes_(std::span(buffer_).first(size), now);
  }
}

base::RunTime VirtualController::next_event() const {
  base::RunTime next = next_tick_;
  for (const fcu::LineModel* line : {&up_, &down_}) {
    if (const auto arrival = line->next_arrival()) next = std::min(next, *arrival);
  }
  if (!outgoing_.empty()) {
    if (const auto room = down_.room_at(now_)) next = std::min(next, *room);
  }
  return next;
}

void VirtualController::send(std::span<const std::uint8_t> packet) {
  outgoing_.insert(outgoing_.end(), packet.begin(), packet.end());
  push_down(now_);
}

void VirtualController::push_down(base::RunTime now) {
  if (outgoing_.empty()) return;
  const std::size_t taken = down_.write(outgoing_, now);
  outgoing_.erase(outgoing_.begin(), outgoing_.begin() + static_cast<std::ptrdiff_t>(taken));
}

}  // namespace cas::hils
