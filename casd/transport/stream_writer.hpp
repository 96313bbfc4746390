// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/uio.h>

#include <cstddef>
#include <optional>

#include "base/os/descriptor.hpp"
#include "casd/packet/packet_port.hpp"

namespace cas::casd {

/// Tells whether the program at the other end of a pseudo-terminal reads.
///
/// Linux has no count of what that program has not read. But each of its reads that leaves no more
/// than 128 bytes wakes those who wait to write, though there was room all the time: an edge of
/// EPOLLOUT. A write of our own makes one, too, which is taken away at once; where the reader was
/// quick, its edge goes with it, and the next read must tell.
class ReaderWatch {
 public:
  explicit ReaderWatch(int fd);
  /// Something was written.
  void wrote() { take_edge(); }
  /// Whether something was read since the last write. True until that was seen once: a kernel that
  /// does not tell must not stop the line.
  bool has_read();

 private:
  bool take_edge();

  base::Descriptor epoll_;
  bool tells_ = false;
};

/// Packets end to end into a byte stream: a serial line or a TCP connection.
class StreamWriter final : public PacketWriter {
 public:
  enum class Kind {
    kSerial,          ///< a line whose driver knows what it has not sent
    kPseudoTerminal,  ///< no line behind it
    kSocket
  };
  StreamWriter(base::Descriptor descriptor, Kind kind);

  WriteResult write(std::span<const PacketRef> packets) override;
  std::ptrdiff_t write_rest(std::span<const std::uint8_t> bytes) override;
  std::size_t unsent() const override;
  bool moved() override;
  void nudge() override;
  void flush() override;
  int descriptor() const override { return descriptor_.get(); }

 private:
  std::ptrdiff_t write_vector(iovec* parts, std::size_t count);
  bool driver_moved();

  base::Descriptor descriptor_;
  Kind kind_;
  std::optional<ReaderWatch> reader_;  ///< of a pseudo-terminal
  bool full_ = false;                  ///< it took no more
  bool made_room_ = false;             ///< and then it did again
  std::size_t held_ = 0;               ///< by the driver, at the last look
  std::size_t written_ = 0;            ///< since then
};

}  // namespace cas::casd
