// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/ulog_pull.hpp"

#include <algorithm>
#include <utility>

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

void UlogPull::take(const mav::PacketView& packet) {
  if (const auto data = mav::decode<LoggingData>(packet)) {
    take(piece_of(*data));
  } else if (const auto acked = mav::decode<LoggingDataAcked>(packet)) {
    LoggingAck ack;
    ack.sequence = acked->sequence;
    hooks_.send(ack);
    take(piece_of(*acked));
  }
}

void UlogPull::take(const UlogStream::Piece& piece) {
  if (stream_.begins(piece)) {
    if (!begin_file("ulg")) return end_file();  // after a silence it is asked again
    last_refusal_.clear();
  }
  LogPart part{.bytes = stream_.take(piece, now_)};
  if (!stream_.began()) return;
  hear();
  write(std::move(part));
}

void UlogPull::ask() {
  if (state_ == State::kRunning && is_silent()) {
    if (stream_.began()) hooks_.warn("has stopped sending its log; it is asked again");
    end_file();
    state_ = State::kIdle;
    next_ask_ = now_;
  }
  if (state_ != State::kIdle || now_ < next_ask_) return;
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
    return await_data();
  }
  state_ = State::kIdle;
  if (outcome.result == MavResult::kTemporarilyRejected) {
    // A log runs that an earlier casd began: its beginning is lost.
    hooks_.command({.id = MavCmd::kLoggingStop}, ignore);
    return ask_later(kFirstRetry, kLongestRetry);
  }
  if (outcome.message != last_refusal_) hooks_.warn("does not send its log: " + outcome.message);
  last_refusal_ = outcome.message;
  ask_later(outcome.result ? kLongestRetry : kSilence, kLongestRetry);
}

void UlogPull::ask_to_end() {
  if (state_ != State::kIdle || stream_.began()) {
    hooks_.command({.id = MavCmd::kLoggingStop}, ignore);
  }
}

void UlogPull::forget() {
  stream_.reset();
  request_.reset();
  state_ = State::kIdle;
  retry_ = kFirstRetry;
}

void UlogPull::end_file() {
  stream_.reset();
  hooks_.end();
}

}  // namespace cas::casd
