// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "mavlink/common/enums.hpp"
#include "mavlink/common/file_transfer_protocol.hpp"

// Payload of FILE_TRANSFER_PROTOCOL (https://mavlink.io/en/services/ftp.html).
namespace cas::mav::services {

inline constexpr std::size_t kFtpDataBytes = 239;

/// A request, or its answer: a header of 12 bytes, little-endian, then the data.
///
///   0 seq  2 session  3 opcode  4 size  5 req_opcode  6 burst_complete  7 padding  8 offset  12
///   data
struct FtpPayload {
  std::uint16_t seq = 0;  ///< an answer's is one more than its request's
  std::uint8_t session = 0;
  mavlink::common::MavFtpOpcode opcode{};
  std::uint8_t size = 0;                       ///< of the data; of a request to read: bytes wanted
  mavlink::common::MavFtpOpcode req_opcode{};  ///< of an answer: opcode of the request
  bool burst_complete = false;                 ///< the last packet of a burst
  std::uint32_t offset = 0;                    ///< in a file: bytes; in a folder: entries
  std::array<std::uint8_t, kFtpDataBytes> data{};

  bool is_answer() const {
    using Opcode = mavlink::common::MavFtpOpcode;
    return opcode == Opcode::kAck || opcode == Opcode::kNak;
  }
  /// The first `size` bytes of data, at most kFtpDataBytes.
  std::span<const std::uint8_t> bytes() const {
    return std::span(data).first(std::min<std::size_t>(size, kFtpDataBytes));
  }
  /// The same up to the first NUL.
  std::string_view text() const {
    const std::string_view all(reinterpret_cast<const char*>(data.data()), bytes().size());
    return all.substr(0, all.find('\0'));
  }
  /// The number in the first four bytes: a length, a checksum.
  std::uint32_t number() const {
    return std::uint32_t{data[0]} | std::uint32_t{data[1]} << 8U | std::uint32_t{data[2]} << 16U |
           std::uint32_t{data[3]} << 24U;
  }
  /// @param bytes  at most kFtpDataBytes; more is cut off
  void set_bytes(std::span<const std::uint8_t> bytes) {
    size = static_cast<std::uint8_t>(std::min(bytes.size(), kFtpDataBytes));
    std::copy_n(bytes.begin(), size, data.begin());
  }
  void set_text(std::string_view text) {
    set_bytes({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  void set_number(std::uint32_t value) {
    size = 4;
    for (unsigned i = 0; i < 4; ++i) data[i] = static_cast<std::uint8_t>(value >> 8 * i);
  }
  friend bool operator==(const FtpPayload&, const FtpPayload&) = default;
};

/// The message of a payload, without its addressee.
mavlink::common::FileTransferProtocol ftp_message(const FtpPayload& payload);
/// The payload of a message. `size` is as it came: more than kFtpDataBytes is a fault of the
/// sender.
FtpPayload ftp_payload(const mavlink::common::FileTransferProtocol& message);

/// MAVLink's CRC-32 (https://mavlink.io/en/crc.html): zlib's polynomial, from 0, without the
/// inversion at the end. @param crc  of the preceding bytes
std::uint32_t ftp_crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

/// A file or folder in a folder.
struct FtpEntry {
  bool folder = false;
  std::string name{};
  std::uint32_t size = 0;  ///< bytes; of a folder 0
  friend bool operator==(const FtpEntry&, const FtpEntry&) = default;
};

/// Why a server refuses.
struct FtpFailure {
  mavlink::common::MavFtpErr code{};  ///< kNone: it does not
  std::uint8_t error_number = 0;      ///< with kFailerrno: errno of the server's system

  bool failed() const { return code != mavlink::common::MavFtpErr::kNone; }
};

/// "there is no such file (FileNotFound)", ...
std::string describe(const FtpFailure& failure);

}  // namespace cas::mav::services
