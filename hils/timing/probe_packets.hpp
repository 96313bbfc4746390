// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

/// Messages that autopilots answer at once and do not act on.
enum class QuestionKind : std::uint8_t { kPing, kTimesync };
std::string_view to_string(QuestionKind kind);

/// The number of a question, which its answer repeats.
struct EchoedNumber {
  QuestionKind kind{};
  std::uint32_t number = 0;
};

/// The packets of a measurement, collected in the order of sending.
///
/// Padding is V2_EXTENSION of a private type, addressed to the autopilot: neither PX4 nor ArduPilot
/// has a handler for it, and a board passes packets addressed to itself on to no other link.
class ProbePackets {
 public:
  /// A sender that no autopilot, simulator or ground station of CAS is.
  static constexpr mav::Source kOwn{.system = 254, .component = 191};
  /// The least that pad() can make.
  static constexpr std::size_t kLeastPadding = 18;
  static constexpr std::size_t kMostPadding = 266;

  /// Whom padding is for.
  void address(mav::Source autopilot) { autopilot_ = autopilot; }
  /// @return the bytes that it takes, whatever the number
  std::size_t ask(QuestionKind kind, std::uint32_t number);
  /// One packet of `bytes`, from kLeastPadding to kMostPadding.
  void pad(std::size_t bytes);
  /// Some boards open their USB port for MAVLink when the first HEARTBEAT comes. It is of type
  /// GENERIC: one of a ground station would be missed when it ends.
  void heartbeat();

  /// Bytes to send.
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  void drop_first(std::size_t count);

 private:
  template <class Message>
  std::size_t append(const Message& message);

  mav::Encoder encode_{kOwn};
  mav::Source autopilot_{};
  std::vector<std::uint8_t> bytes_;
};

/// The question that a packet answers; nullopt for every other one.
std::optional<EchoedNumber> read_answer(const mav::PacketView& packet);

}  // namespace cas::hils
