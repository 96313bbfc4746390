// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/uio.h>

#include <cstddef>
#include <optional>
#include <utility>

#include "base/os/descriptor.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/packet_port.hpp"

namespace cas::casd {

/// Tells whether the program at the other end of a pseudo-terminal reads.
///
/// Linux has no count of what that program has not read. But each of its reads that leaves no more
/// than 128 bytes wakes those who wait to write, though there was room all the time: an edge of
/// EPOLLOUT. A write of our own makes one, too, which is taken away at once. On a busy machine the
/// reader often runs before that, and its edge goes with ours: a write that took its time is in
/// doubt, and counts as read.
class ReaderWatch {
 public:
  explicit ReaderWatch(int fd);
  /// Looks, or not: each look costs system calls. Beginning forgets earlier edges.
  void watch(bool on);
  bool watches() const { return on_; }
  /// Something was written, in so long a time.
  void wrote(base::Duration took);
  /// Whether something was read since the last call, or is in doubt.
  bool has_read();
  /// Whether a read was seen at all. Until then nobody has read, or this kernel does not tell.
  bool tells() const { return tells_; }
  /// Whether writes since the last call of take_doubt() or has_read() are in doubt.
  bool in_doubt() const { return in_doubt_; }
  bool take_doubt() { return std::exchange(in_doubt_, false); }

 private:
  bool take_edge();

  base::Descriptor epoll_;
  bool on_ = true;
  bool tells_ = false;
  bool in_doubt_ = false;
};

/// Packets end to end into a byte stream: a serial line or a TCP connection.
class StreamWriter final : public PacketWriter {
 public:
  enum class Kind {
    kSerial,          ///< a line whose driver counts unsent bytes
    kPseudoTerminal,  ///< no line behind it
    kSocket
  };
  StreamWriter(base::Descriptor descriptor, Kind kind);

  WriteResult write(std::span<const PacketRef> packets) override;
  WriteResult write_rest(std::span<const std::uint8_t> bytes) override;
  std::size_t unsent() const override;
  /// Until a read was seen, a terminal is believed to be read as long as it has room: a kernel that
  /// does not tell must not stop the line.
  bool moved() override;
  bool counts_moves() const override { return kind_ == Kind::kSerial; }
  void watch(bool on) override;
  void nudge() override;
  /// Leaves a terminal as it is of which no read was seen: room made so would look like a reader.
  bool flush() override;
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
