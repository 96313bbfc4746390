// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/link_core.hpp"

#include <poll.h>
#include <time.h>

#include <cerrno>
#include <chrono>
#include <utility>

#include "base/os/log.hpp"
#include "casd/link/blocking_tx_port.hpp"
#include "casd/link/direct_tx_port.hpp"
#include "casd/link/turn_meter.hpp"

namespace cas::casd {
namespace {

class SteadyWait final : public LineWait {
 public:
  base::RunTime now() const override { return base::steady_now(); }
  void until(base::RunTime when) override {
    const std::int64_t total = when.time_since_epoch().count();
    const timespec end{static_cast<time_t>(total / 1'000'000'000), total % 1'000'000'000};
    count_wanted_wait();
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &end, nullptr) == EINTR) {
    }
  }
  void for_room(int descriptor, base::Duration at_most) override {
    pollfd room{descriptor, POLLOUT, 0};
    count_wanted_wait();
    ::poll(&room, 1, static_cast<int>(at_most / std::chrono::milliseconds(1)));
  }
};

}  // namespace

LinkCore::LinkCore(LinkContext context)
    : context_(std::move(context)),
      ingress_(context_.id, context_.switchboard, context_.counters, context_.config.accept,
               context_.signing),
      backoff_(context_.retry) {}

void LinkCore::went_up(const std::string& endpoint) {
  if (was_up_) context_.counters->reconnects.add();
  was_up_ = true;
  last_reason_.clear();
  backoff_.reset();
  context_.counters->state.store(LinkState::kUp, std::memory_order_relaxed);
  context_.counters->set_endpoint(endpoint);
  base::log::info("link " + context_.config.name + ": up, " + endpoint);
}

void LinkCore::went_down(const std::string& reason, base::RunTime now) {
  backoff_.failed(now);
  context_.counters->state.store(LinkState::kDown, std::memory_order_relaxed);
  if (reason == last_reason_) return;
  last_reason_ = reason;
  context_.counters->set_endpoint(reason);
  base::log::warn("link " + context_.config.name + ": down, " + reason);
}

void LinkCore::on_second(base::RunTime now) {
  next_second_ = now + std::chrono::seconds(1);
  ingress_.tick(now);
}

double paced_bytes_s(const LinkConfig& config, unsigned baud) {
  const bool paced = config.type == LinkType::kSerial && config.pace;
  return paced ? LinePacer::rate_of(baud) : 0;
}

TxPortOptions tx_port_options(const LinkConfig& config, std::shared_ptr<LinkSigning> signing) {
  return {.queue = config.queue,
          .line_bytes_s = paced_bytes_s(config, lowest_baud(config)),
          .cap_bytes_s = config.max_bytes_s,
          .sensor_gap = config.sensor_gap,
          .flow_control = config.flow_control,
          .signing = std::move(signing),
          // Copies over redundant paths must be the same packet.
          .own_numbers = config.group.empty()};
}

std::shared_ptr<TxPort> LinkCore::make_port() const {
  static SteadyWait wait;
  const TxPortOptions options = tx_port_options(context_.config, context_.signing);
  if (context_.blocking) {
    return std::make_shared<BlockingTxPort>(options, context_.drain, wait, context_.counters,
                                            context_.wake);
  }
  return std::make_shared<DirectTxPort>(options, context_.counters, context_.wake);
}

}  // namespace cas::casd
