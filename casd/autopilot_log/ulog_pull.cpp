// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/ulog_pull.hpp"

#include <algorithm>

#include "mavlink/common/logging_data.hpp"
#include "mavlink/common/logging_data_acked.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;

template <class Message>
UlogStream::Piece piece_of(const Message& message) {
  const std::size_t size = std::min<std::size_t>(message.length, message.data.size());
  return {message.sequence, message.first_message_offset, std::span(message.data).first(size)};
}

void ignore(const Outcome& /*outcome*/) {}

}  // namespace

void UlogPull::on_packet(const mav::PacketView& packet, base::RunTime now) {
  now_ = now;
  if (!wanted_) return;
  if (const auto data = mav::decode<LoggingData>(packet)) {
    take(piece_of(*data), now);
  } else if (const auto acked = mav::decode<LoggingDataAcked>(packet)) {
    LoggingAck ack;
    ack.sequence = acked->sequence;
    hooks_.send(ack);
    take(piece_of(*acked), now);
  }
}

void UlogPull::take(const UlogStream::Piece& piece, base::RunTime now) {
  if (stream_.begins(piece)) {
    if (now < next_file_) return end_file();  // after a silence it is asked again
    next_file_ = now + kFilePeriod;
    last_refusal_.clear();
    hooks_.end();
    hooks_.begin("ulg");
  }
  LogPart part{.bytes = stream_.take(piece, now)};
  if (!stream_.began()) return;
  heard_at_ = now;
  retry_ = kFirstRetry;
  if (part.bytes.empty() || hooks_.write(std::move(part))) return;
  stop(now);  // readers do not see a gap without a mark: the log goes on in another file
  next_ask_ = now + kSilence;
}

void UlogPull::tick(base::RunTime now) {
  now_ = now;
  wanted_ = true;
  if (state_ == State::kRunning && now - heard_at_ > kSilence) {
    if (stream_.began()) hooks_.warn("has stopped sending its log; it is asked again");
    end_file();
    state_ = State::kIdle;
    next_ask_ = now;
  }
  if (state_ != State::kIdle || now < next_ask_) return;
  state_ = State::kAsking;
  request_ = std::make_shared<int>();
  hooks_.command({.id = MavCmd::kLoggingStart},
                 [this, request = std::weak_ptr<int>(request_)](const Outcome& outcome) {
                   if (!request.expired()) on_answer(outcome);
                 });
}

void UlogPull::on_answer(const Outcome& outcome) {
  request_.reset();
  if (outcome.ok()) {
    state_ = State::kRunning;
    heard_at_ = now_;
    return;
  }
  state_ = State::kIdle;
  if (outcome.result == MavResult::kTemporarilyRejected) {
    // A log runs that an earlier casd began: its beginning is lost.
    hooks_.command({.id = MavCmd::kLoggingStop}, ignore);
    return retry(kFirstRetry);
  }
  if (outcome.message != last_refusal_) hooks_.warn("does not send its log: " + outcome.message);
  last_refusal_ = outcome.message;
  retry(outcome.result ? kLongestRetry : kSilence);
}

/// Doubles the wait each time, until data comes.
void UlogPull::retry(base::Duration at_least) {
  next_ask_ = now_ + std::max(at_least, retry_);
  retry_ = std::min(2 * retry_, base::Duration(kLongestRetry));
}

void UlogPull::stop(base::RunTime now) {
  now_ = now;
  if (state_ != State::kIdle || stream_.began()) {
    hooks_.command({.id = MavCmd::kLoggingStop}, ignore);
  }
  restart(now);
  wanted_ = false;
}

void UlogPull::restart(base::RunTime now) {
  now_ = now;
  end_file();
  request_.reset();
  state_ = State::kIdle;
  next_ask_ = now;
  retry_ = kFirstRetry;
}

void UlogPull::end_file() {
  stream_.reset();
  hooks_.end();
}

}  // namespace cas::casd
