// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/tlog_link.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

namespace cas::casd {
namespace {

// Time for the other links to open, so that they do not miss the beginning.
constexpr auto kLeadIn = std::chrono::milliseconds(200);
// How often the thread that reads is asked while it has nothing.
constexpr auto kAskAgain = std::chrono::milliseconds(5);
constexpr double kLongestWait_s = 366.0 * 86400;  // at the lowest speed

class DiscardPort final : public PacketPort {
 public:
  void deliver(std::span<const PacketRef>, base::RunTime) override {}
};

}  // namespace

TlogLink::TlogLink(LinkContext context)
    : core_(std::move(context)), port_(std::make_shared<DiscardPort>()), parser_(make_parser()) {}

void TlogLink::watch(PollSet& set, base::RunTime now) {
  if (ended_) return;
  if (!log_) return set.wake_by(core_.backoff().next());
  set.wake_by(next_ ? due_ : now + kAskAgain);
  if (begun_) set.wake_by(core_.next_second());
}

void TlogLink::serve(const PollSet&, base::RunTime now) {
  if (ended_) return;
  if (!log_) {
    if (core_.backoff().due(now)) open(now);
    return;
  }
  if (!begun_) return begin(now);
  play(now);
  if (core_.second_due(now)) core_.on_second(now);
}

void TlogLink::open(base::RunTime now) {
  begun_ = false;
  try {
    log_ = std::make_unique<TlogReadAhead>(core_.config().file);
  } catch (const std::system_error&) {
    log_.reset();
    core_.went_down("no thread to read the log", now);
  }
}

void TlogLink::begin(base::RunTime now) {
  next_ = log_->next();
  if (next_) {
    begun_ = true;
    clock_ = {};
    clock_.at(next_->unix_us, next_->packet);
    started_ = due_ = now + kLeadIn;
    core_.went_up(core_.config().file.string());
  } else if (log_->ended()) {
    ended_ = !log_->unreadable();
    log_.reset();
    core_.went_down(ended_ ? "holds no packet" : "cannot read the log", now);
  }
}

void TlogLink::play(base::RunTime now) {
  // After a stall no more than this a turn: other links of the loop wait no longer.
  constexpr int kMostAtOnce = 64;
  if (!next_) advance();
  for (int i = 0; i < kMostAtOnce && next_ && due_ <= now; ++i) {
    core_.ingress().take_datagram(parser_, next_->packet, now);
    advance();
  }
  core_.ingress().deliver(now);
  if (!next_ && log_->ended()) end(now);
}

void TlogLink::advance() {
  next_ = log_->next();
  if (!next_) return;
  const auto recorded_us = static_cast<double>(clock_.at(next_->unix_us, next_->packet));
  const double wait_s = recorded_us / 1e6 / core_.config().speed;
  due_ = started_ + base::from_seconds(std::min(wait_s, kLongestWait_s));
}

/// "; its recorder's clock was set 1 time(s); 25 bytes are no record", or nothing.
std::string TlogLink::damage_text() const {
  std::string text;
  if (clock_.steps() > 0) {
    text += fmt::format("; its recorder's clock was set {} time(s)", clock_.steps());
  }
  if (log_->skipped_bytes() > 0) {
    text += fmt::format("; {} bytes are no record", log_->skipped_bytes());
  }
  return text;
}

void TlogLink::end(base::RunTime now) {
  if (core_.config().repeat) return open(now);
  ended_ = true;
  const std::string damage = damage_text();
  log_.reset();
  core_.went_down("played to its end" + damage, now);
}

}  // namespace cas::casd
