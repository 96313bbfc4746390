// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/tlog_link.hpp"

#include <utility>

namespace cas::casd {
namespace {

// Time for the other links to open, so that they do not miss the beginning.
constexpr auto kLeadIn = std::chrono::milliseconds(200);

class DiscardPort final : public PacketPort {
 public:
  void deliver(std::span<const PacketRef>, base::RunTime) override {}
};

}  // namespace

TlogLink::TlogLink(LinkContext context)
    : core_(std::move(context)), port_(std::make_shared<DiscardPort>()), parser_(make_parser()) {}

void TlogLink::watch(PollSet& set, base::RunTime) {
  if (ended_) return;
  if (!next_) return set.wake_by(core_.backoff().next());
  set.wake_by(due_);
  set.wake_by(core_.next_second());
}

void TlogLink::serve(const PollSet&, base::RunTime now) {
  if (ended_) return;
  if (!next_) {
    if (core_.backoff().due(now)) open(now);
    return;
  }
  play(now);
  if (core_.second_due(now)) core_.on_second(now);
}

void TlogLink::open(base::RunTime now) {
  const LinkConfig& config = core_.config();
  if (!reader_.open(config.file)) return core_.went_down("cannot read the log", now);
  next_ = reader_.next();
  if (!next_) return core_.went_down("holds no packet", now);
  first_us_ = next_->unix_us;
  started_ = due_ = now + kLeadIn;
  core_.went_up(config.file.string());
}

void TlogLink::play(base::RunTime now) {
  // After a stall no more than this a turn: other links of the loop wait no longer.
  constexpr int kMostAtOnce = 64;
  for (int i = 0; i < kMostAtOnce && next_ && due_ <= now; ++i) {
    core_.ingress().take_datagram(parser_, next_->packet, now);
    advance();
  }
  core_.ingress().deliver(now);
  if (!next_) end(now);
}

void TlogLink::advance() {
  next_ = reader_.next();
  if (!next_) return;
  // A clock that was set back while recording stops nothing: overdue packets are played at once.
  const auto recorded_us = static_cast<double>(next_->unix_us) - static_cast<double>(first_us_);
  due_ = started_ + base::from_seconds(recorded_us / 1e6 / core_.config().speed);
}

void TlogLink::end(base::RunTime now) {
  if (core_.config().repeat) return open(now);
  ended_ = true;
  core_.went_down("played to its end", now);
}

}  // namespace cas::casd
