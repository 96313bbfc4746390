// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/ftp_payload.hpp"

#include <system_error>

namespace cas::mav::services {

using mavlink::common::FileTransferProtocol;
using mavlink::common::MavFtpErr;
using mavlink::common::MavFtpOpcode;

namespace {

constexpr std::size_t kHeaderBytes = 12;

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    table[i] = i;
    for (int bit = 0; bit < 8; ++bit) {
      table[i] = table[i] >> 1U ^ ((table[i] & 1U) != 0 ? 0xEDB88320U : 0U);
    }
  }
  return table;
}

}  // namespace

FileTransferProtocol ftp_message(const FtpPayload& payload) {
  FileTransferProtocol message;
  auto& out = message.payload;
  static_assert(sizeof out == kHeaderBytes + kFtpDataBytes);
  put<std::uint16_t>(out.data(), payload.seq);
  out[2] = payload.session;
  out[3] = static_cast<std::uint8_t>(payload.opcode);
  out[4] = payload.size;
  out[5] = static_cast<std::uint8_t>(payload.req_opcode);
  out[6] = payload.burst_complete ? 1 : 0;
  put<std::uint32_t>(out.data() + 8, payload.offset);
  std::copy(payload.data.begin(), payload.data.end(), out.begin() + kHeaderBytes);
  return message;
}

FtpPayload ftp_payload(const FileTransferProtocol& message) {
  const auto& in = message.payload;
  FtpPayload payload;
  get<std::uint16_t>(in.data(), payload.seq);
  payload.session = in[2];
  payload.opcode = static_cast<MavFtpOpcode>(in[3]);
  payload.size = in[4];
  payload.req_opcode = static_cast<MavFtpOpcode>(in[5]);
  payload.burst_complete = in[6] != 0;
  get<std::uint32_t>(in.data() + 8, payload.offset);
  std::copy(in.begin() + kHeaderBytes, in.end(), payload.data.begin());
  return payload;
}

std::uint32_t ftp_crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  static constexpr auto kTable = crc_table();
  for (const std::uint8_t byte : bytes) crc = crc >> 8U ^ kTable[(crc ^ byte) & 0xFFU];
  return crc;
}

std::string describe(const FtpFailure& failure) {
  switch (failure.code) {
    case MavFtpErr::kNone:
      return "no error (None)";
    case MavFtpErr::kFail:
      return "it failed, without a reason (Fail)";
    case MavFtpErr::kFailerrno:
      return "its file system failed with errno " + std::to_string(failure.error_number) +
             " (FailErrno), which is '" + std::generic_category().message(failure.error_number) +
             "' here";
    case MavFtpErr::kInvaliddatasize:
      return "the request has a wrong size (InvalidDataSize)";
    case MavFtpErr::kInvalidsession:
      return "the file is not open there (InvalidSession)";
    case MavFtpErr::kNosessionsavailable:
      return "too many files are open there (NoSessionsAvailable)";
    case MavFtpErr::kEof:
      return "there is nothing behind the end (EOF)";
    case MavFtpErr::kUnknowncommand:
      return "it has no such operation (UnknownCommand)";
    case MavFtpErr::kFileexists:
      return "the name is taken (FileExists)";
    case MavFtpErr::kFileprotected:
      return "it must not be changed (FileProtected)";
    case MavFtpErr::kFilenotfound:
      return "there is no such file or folder (FileNotFound)";
  }
  return "error " + std::to_string(static_cast<unsigned>(failure.code));
}

}  // namespace cas::mav::services
