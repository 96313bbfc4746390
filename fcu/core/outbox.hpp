// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "mavlink_gen/runtime/codec.hpp"

namespace cas::fcu {

/// Takes one whole packet for the line.
using PacketSink = std::function<void(std::span<const std::uint8_t>)>;
/// Observes each HIL packet used or sent: message id, its time_usec, whether it was sent.
using HilObserver = std::function<void(std::uint32_t id, std::uint64_t time_usec, bool sent)>;

/// Packs messages, numbers them, counts them and hands them to the line.
class Outbox {
 public:
  static constexpr std::size_t kIds = 512;  ///< largest message id counted, plus one

  Outbox(mav::Source source, PacketSink sink) : source_(source), sink_(std::move(sink)) {}

  template <class Message>
  void send(const Message& message) {
    put<Message>(mav::encode(message, source_, sequence_++, buffer_));
  }

  /// Answers in the version that was asked in, as far as MAVLink 1 can carry the message.
  template <class Message>
  void reply(const Message& message, int version) {
    if constexpr (Message::kId <= 0xFF) {
      if (version == 1) {
        put<Message>(mav::encode_v1(message, source_, sequence_++, buffer_));
        return;
      }
    }
    send(message);
  }

  mav::Source source() const { return source_; }
  const std::array<std::uint64_t, kIds>& counts() const { return counts_; }

 private:
  template <class Message>
  void put(std::size_t size) {
    static_assert(Message::kId < kIds);
    ++counts_[Message::kId];
    sink_({buffer_.data(), size});
  }

  mav::Source source_;
  PacketSink sink_;
  std::uint8_t sequence_ = 0;
  std::array<std::uint8_t, mav::kMaxPacketBytes> buffer_{};
  std::array<std::uint64_t, kIds> counts_{};
};

}  // namespace cas::fcu
