// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cas::sim {

/// Class and id of a UBX message.
struct UbxId {
  std::uint8_t group = 0;
  std::uint8_t id = 0;
  bool operator==(const UbxId&) const = default;
};

namespace ubx {
inline constexpr UbxId kNavDop{0x01, 0x04};
inline constexpr UbxId kNavPvt{0x01, 0x07};
inline constexpr UbxId kNavTimeGps{0x01, 0x20};
inline constexpr UbxId kNavSat{0x01, 0x35};
inline constexpr UbxId kNavRelPosNed{0x01, 0x3C};
inline constexpr UbxId kAckNak{0x05, 0x00};
inline constexpr UbxId kAckAck{0x05, 0x01};
inline constexpr UbxId kCfgPrt{0x06, 0x00};
inline constexpr UbxId kCfgMsg{0x06, 0x01};
inline constexpr UbxId kCfgRate{0x06, 0x08};
inline constexpr UbxId kCfgValSet{0x06, 0x8A};
inline constexpr UbxId kCfgValGet{0x06, 0x8B};
inline constexpr UbxId kMonVer{0x0A, 0x04};
inline constexpr UbxId kMonRf{0x0A, 0x38};
}  // namespace ubx

/// Appends B5 62, class, id, length, payload and the two sums of Fletcher over all but the first
/// two bytes.
void append_ubx(std::vector<std::uint8_t>& out, UbxId id, std::span<const std::uint8_t> payload);

/// Finds the frames in a stream of bytes. What is no frame, or a wrong sum, is skipped and counted.
class UbxParser {
 public:
  /// A longer payload, which no driver sends, is no frame.
  static constexpr std::size_t kMostPayload = 1024;

  struct Counts {
    std::uint64_t frames = 0;
    std::uint64_t bad_checksums = 0;
    std::uint64_t garbage_bytes = 0;
  };

  /// Calls on_frame(UbxId, std::span<const std::uint8_t> payload) for each.
  template <class OnFrame>
  void feed(std::span<const std::uint8_t> bytes, OnFrame&& on_frame) {
    for (const std::uint8_t byte : bytes) {
      if (!take(byte)) continue;
      on_frame(UbxId{frame_[2], frame_[3]},
               std::span(frame_).subspan(kHead, frame_.size() - kFrame));
      frame_.clear();
    }
  }
  const Counts& counts() const { return counts_; }

 private:
  static constexpr std::size_t kHead = 6;
  static constexpr std::size_t kFrame = 8;  ///< with the sums

  /// @return whether a frame is complete
  bool take(std::uint8_t byte);
  void restart(std::uint8_t byte);

  std::vector<std::uint8_t> frame_;
  Counts counts_;
};

}  // namespace cas::sim
