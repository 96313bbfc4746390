// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ubx/ubx_frame.hpp"

namespace cas::sim {
namespace {

constexpr std::uint8_t kSync1 = 0xB5;
constexpr std::uint8_t kSync2 = 0x62;

/// Over class, id, length and payload.
std::array<std::uint8_t, 2> fletcher(std::span<const std::uint8_t> bytes) {
  std::uint8_t a = 0;
  std::uint8_t b = 0;
  for (const std::uint8_t byte : bytes) {
    a = static_cast<std::uint8_t>(a + byte);
    b = static_cast<std::uint8_t>(b + a);
  }
  return {a, b};
}

}  // namespace

void append_ubx(std::vector<std::uint8_t>& out, UbxId id, std::span<const std::uint8_t> payload) {
  const std::size_t begin = out.size();
  const std::size_t size = payload.size();
  out.insert(out.end(), {kSync1, kSync2, id.group, id.id, static_cast<std::uint8_t>(size & 0xFF),
                         static_cast<std::uint8_t>(size >> 8)});
  out.insert(out.end(), payload.begin(), payload.end());
  const auto sums = fletcher(std::span(out).subspan(begin + 2));
  out.insert(out.end(), sums.begin(), sums.end());
}

bool UbxParser::take(std::uint8_t byte) {
  frame_.push_back(byte);
  const std::size_t size = frame_.size();
  if (size == 1 && byte != kSync1) {
    ++counts_.garbage_bytes;
    frame_.clear();
  }
  if (size == 2 && byte != kSync2) restart(byte);
  if (size < kHead) return false;
  const std::size_t payload = frame_[4] + 256U * frame_[5];
  if (size == kHead && payload > kMostPayload) restart(byte);
  if (frame_.size() < payload + kFrame) return false;
  const auto sums = fletcher(std::span(frame_).subspan(2, payload + 4));
  if (sums[0] == frame_[size - 2] && sums[1] == frame_[size - 1]) {
    ++counts_.frames;
    return true;
  }
  ++counts_.bad_checksums;
  restart(byte);
  return false;
}

/// What was taken for a frame is none; the last byte may begin one.
void UbxParser::restart(std::uint8_t byte) {
  const bool may_begin = byte == kSync1;
  counts_.garbage_bytes += frame_.size() - (may_begin ? 1 : 0);
  frame_.clear();
  if (may_begin) frame_.push_back(byte);
}

}  // namespace cas::sim
