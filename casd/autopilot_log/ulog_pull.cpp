// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/ulog_pull.hpp"

#include <algorithm>
#include <chrono>
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

namespace {

constexpr std::array<std::uint8_t, 7> kMagic{'U', 'L', 'o', 'g', 0x01, 0x12, 0x35};
constexpr std::size_t kMessageHead = 3;  // length (2 bytes) and type
constexpr std::uint16_t kOldFrom =
    0x8000;  // a difference of sequences from here on: an old piece, repeated

/// ULog's dropout message ('O') of that length.
std::array<std::uint8_t, kMessageHead + 2> dropout(base::Duration lasted) {
  using std::chrono::milliseconds;
  const auto ms = std::chrono::duration_cast<milliseconds>(lasted).count();
  const auto field = static_cast<std::uint16_t>(std::clamp<std::int64_t>(ms, 0, 0xFFFF));
  return {2, 0, 'O', static_cast<std::uint8_t>(field & 0xFFU),
          static_cast<std::uint8_t>(field >> 8U)};
}

}  // namespace

std::vector<std::uint8_t> UlogStream::take(const Piece& piece, base::RunTime now) {
  std::vector<std::uint8_t> whole;
  std::span<const std::uint8_t> data = piece.data;
  if (begins(piece)) {
    begin(piece);
    whole.assign(header_.begin(), header_.end());
    data = data.subspan(kHeaderBytes);
  } else if (!began_) {
    return whole;
  } else {
    const auto ahead = static_cast<std::uint16_t>(piece.sequence - next_);
    if (ahead >= kOldFrom) return whole;
    cut_ = cut_ || ahead > 0;
  }
  next_ = static_cast<std::uint16_t>(piece.sequence + 1);
  if (cut_) {
    rest_.clear();
    if (piece.first_message >= data.size()) return whole;
    const auto gap = dropout(now - whole_at_);
    whole.assign(gap.begin(), gap.end());
    data = data.subspan(piece.first_message);
    cut_ = false;
  }
  whole_at_ = now;
  rest_.insert(rest_.end(), data.begin(), data.end());
  take_whole_messages(whole);
  return whole;
}

bool UlogStream::begins(const Piece& piece) const {
  if (piece.first_message != 0 || piece.data.size() < kHeaderBytes) return false;
  if (!std::equal(kMagic.begin(), kMagic.end(), piece.data.begin())) return false;
  return !began_ || !std::equal(header_.begin(), header_.end(), piece.data.begin());
}

void UlogStream::begin(const Piece& piece) {
  reset();
  began_ = true;
  std::copy_n(piece.data.begin(), kHeaderBytes, header_.begin());
}

void UlogStream::take_whole_messages(std::vector<std::uint8_t>& into) {
  std::size_t whole = 0;
  while (rest_.size() - whole >= kMessageHead) {
    const std::size_t length = rest_[whole] | static_cast<std::size_t>(rest_[whole + 1]) << 8U;
    if (rest_.size() - whole < kMessageHead + length) break;
    whole += kMessageHead + length;
  }
  const auto end = rest_.begin() + static_cast<std::ptrdiff_t>(whole);
  into.insert(into.end(), rest_.begin(), end);
  rest_.erase(rest_.begin(), end);
}

}  // namespace cas::casd
