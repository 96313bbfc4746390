// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/probe_packets.hpp"

#include <algorithm>
#include <span>

#include "base/error.hpp"
#include "mavlink/common/ping.hpp"
#include "mavlink/common/timesync.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/station_heartbeat.hpp"

namespace cas::hils {

namespace {

using mavlink::common::Ping;
using mavlink::common::Timesync;

/// Keeps the highest byte from zero, which MAVLink 2 would cut off: each question has one length.
constexpr std::uint32_t kPingMark = 0x80000000U;
constexpr std::uint32_t kNumberMask = 0x7fffffffU;
constexpr std::int64_t kTimesyncMark = 0x4341'5354'0000'0000;
constexpr std::int64_t kTimesyncMask = 0x7fff'ffff'0000'0000;

/// V2_EXTENSION of the public dialect, which ours leaves out. Source: mavlink.io, common.xml.
struct Padding {
  static constexpr std::uint32_t kId = 248;
  static constexpr std::uint8_t kCrcExtra = 8;
  static constexpr std::size_t kMaxLength = 254;
  static constexpr std::size_t kFixed = 5;  ///< bytes of the fields before the payload
  /// From 0x8000 on types are private.
  static constexpr std::uint16_t kPrivateType = 0xCA50;
  static constexpr std::uint8_t kFill = 0x55;  ///< no packet starts with it

  void pack(std::uint8_t* out) const {
    mav::put<std::uint16_t>(out, kPrivateType);
    out[2] = 0;  // network
    out[3] = to.system;
    out[4] = to.component;
    std::fill_n(out + kFixed, fill, kFill);
    std::fill_n(out + kFixed + fill, kMaxLength - kFixed - fill, std::uint8_t{0});
  }

  mav::Source to{};
  std::size_t fill = 0;
};

constexpr std::size_t kAroundFill = mav::kHeaderBytesV2 + Padding::kFixed + mav::kChecksumBytes;
static_assert(ProbePackets::kLeastPadding == kAroundFill + 1);
static_assert(ProbePackets::kMostPadding ==
              mav::kHeaderBytesV2 + Padding::kMaxLength + mav::kChecksumBytes);

bool is_for_us(std::uint8_t system, std::uint8_t component) {
  return system == ProbePackets::kOwn.system && component == ProbePackets::kOwn.component;
}

}  // namespace

std::string_view to_string(QuestionKind kind) {
  return kind == QuestionKind::kPing ? "PING" : "TIMESYNC";
}

template <class Message>
std::size_t ProbePackets::append(const Message& message) {
  const std::span<const std::uint8_t> packet = encode_(message);
  bytes_.insert(bytes_.end(), packet.begin(), packet.end());
  return packet.size();
}

std::size_t ProbePackets::ask(QuestionKind kind, std::uint32_t number) {
  if (kind == QuestionKind::kPing) {
    return append(Ping{.time_usec = number, .seq = kPingMark | number});
  }
  Timesync question;
  question.ts1 = kTimesyncMark | static_cast<std::int64_t>(number);
  return append(question);
}

void ProbePackets::pad(std::size_t bytes) {
  CAS_CHECK(bytes >= kLeastPadding && bytes <= kMostPadding);
  append(Padding{.to = autopilot_, .fill = bytes - kAroundFill});
}

void ProbePackets::heartbeat() {
  append(mav::services::station_heartbeat(mavlink::common::MavType::kGeneric));
}

void ProbePackets::drop_first(std::size_t count) {
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(count));
}

std::optional<EchoedNumber> read_answer(const mav::PacketView& packet) {
  if (const auto ping = mav::decode<Ping>(packet)) {
    if (!is_for_us(ping->target_system, ping->target_component)) return std::nullopt;
    return EchoedNumber{QuestionKind::kPing, ping->seq & kNumberMask};
  }
  if (const auto sync = mav::decode<Timesync>(packet)) {
    if (sync->tc1 == 0 || (sync->ts1 & kTimesyncMask) != kTimesyncMark) return std::nullopt;
    return EchoedNumber{QuestionKind::kTimesync, static_cast<std::uint32_t>(sync->ts1)};
  }
  return std::nullopt;
}

}  // namespace cas::hils
