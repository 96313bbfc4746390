// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mavlink_gen/runtime/message.hpp"

namespace cas::mav::services {

/// REMOTE_LOG_DATA_BLOCK of ArduPilot's dialect: a block of its dataflash log.
struct RemoteLogDataBlock {
  static constexpr std::uint32_t kId = 184;
  static constexpr std::uint8_t kCrcExtra = 159;
  static constexpr std::size_t kBlockBytes = 200;
  static constexpr std::size_t kMinLength = 206, kMaxLength = 206;

  std::uint32_t seqno = 0;  ///< of the block; it lies at seqno * kBlockBytes in the log
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::array<std::uint8_t, kBlockBytes> data{};

  template <class Byte>
  void pack(Byte* out) const {
    put<std::uint32_t>(out, seqno);
    put<std::uint8_t>(out + 4, target_system);
    put<std::uint8_t>(out + 5, target_component);
    put<std::uint8_t>(out + 6, data);
  }
  template <class Byte>
  static RemoteLogDataBlock unpack(const Byte* in) {
    RemoteLogDataBlock message;
    get<std::uint32_t>(in, message.seqno);
    get<std::uint8_t>(in + 4, message.target_system);
    get<std::uint8_t>(in + 5, message.target_component);
    get<std::uint8_t>(in + 6, message.data);
    return message;
  }
};

/// REMOTE_LOG_BLOCK_STATUS: whether a block has come, or an order.
struct RemoteLogBlockStatus {
  static constexpr std::uint32_t kId = 185;
  static constexpr std::uint8_t kCrcExtra = 186;
  static constexpr std::size_t kMinLength = 7, kMaxLength = 7;

  // Orders in place of a block's number, with kAck.
  static constexpr std::uint32_t kStop = 2'147'483'645;
  static constexpr std::uint32_t kStart = 2'147'483'646;
  static constexpr std::uint8_t kNack = 0;
  static constexpr std::uint8_t kAck = 1;

  std::uint32_t seqno = 0;
  std::uint8_t target_system = 0;
  std::uint8_t target_component = 0;
  std::uint8_t status = kNack;

  template <class Byte>
  void pack(Byte* out) const {
    put<std::uint32_t>(out, seqno);
    put<std::uint8_t>(out + 4, target_system);
    put<std::uint8_t>(out + 5, target_component);
    put<std::uint8_t>(out + 6, status);
  }
  template <class Byte>
  static RemoteLogBlockStatus unpack(const Byte* in) {
    RemoteLogBlockStatus message;
    get<std::uint32_t>(in, message.seqno);
    get<std::uint8_t>(in + 4, message.target_system);
    get<std::uint8_t>(in + 5, message.target_component);
    get<std::uint8_t>(in + 6, message.status);
    return message;
  }
};

}  // namespace cas::mav::services
