// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/time/clock.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/words/drop_cause.hpp"

namespace cas::casd {

/// A packet, borrowed from its owner.
struct PacketRef {
  const PacketInfo* info = nullptr;
  std::span<const std::uint8_t> bytes;
};

/// Takes packets for one destination, from any thread, without blocking.
class PacketPort {
 public:
  virtual ~PacketPort() = default;
  virtual void deliver(std::span<const PacketRef> packets, base::RunTime now) = 0;
};

/// A packet that was finished without being sent.
struct Unsent {
  std::size_t index = 0;           ///< among the packets to write
  std::optional<DropCause> cause;  ///< none: no peer was there for it, or the loss is counted
};

/// Result of an attempt to write packets.
struct WriteResult {
  std::size_t packets = 0;              ///< finished: written completely, or unsent
  std::size_t part_of_next = 0;         ///< bytes of the next one that were written, too (streams)
  bool broken = false;                  ///< the descriptor is unusable
  base::RunTime done{};                 ///< when the call had returned; zero: it took no time
  std::uint64_t refused_earlier = 0;    ///< sent packets whose refusal this write reported
  std::span<const Unsent> unsent = {};  ///< of `packets`, in their order; good until the next write
};

/// Writes packets to a descriptor in as few system calls as it can, never blocking. Owns the
/// descriptor: it is closed with the writer, when no thread can be inside any more.
class PacketWriter {
 public:
  virtual ~PacketWriter() = default;
  virtual WriteResult write(std::span<const PacketRef> packets) = 0;
  /// Writes the rest of a packet that was begun (streams). @return how many bytes, in part_of_next
  virtual WriteResult write_rest(std::span<const std::uint8_t>) { return {}; }
  /// Spoils the checksum of a begun packet whose rest it keeps itself.
  virtual void spoil_rest() {}
  /// Bytes that it adds to each packet.
  virtual std::size_t added_bytes() const { return 0; }
  /// Bytes that were written and have not left this machine; 0 where the driver cannot tell.
  virtual std::size_t unsent() const { return 0; }
  /// Whether the other side has made progress since the last call: it has read written bytes, or
  /// some have left this machine. True where the driver cannot tell.
  virtual bool moved() { return true; }
  /// Whether moved() counts bytes and so misses nothing; else a read of the other side may go
  /// unseen.
  virtual bool counts_moves() const { return false; }
  /// Switches moved() on or off, at first on. While off, the port need not track reads; reads while
  /// off do not count later.
  virtual void watch(bool /*on*/) {}
  /// Makes a line move again that only seems to stand still: at the end of a packet.
  virtual void nudge() {}
  /// Discards the bytes that the driver still holds. @return false: it still holds them
  virtual bool flush() { return false; }
  /// Descriptor to poll when it takes no more.
  virtual int descriptor() const = 0;
};

}  // namespace cas::casd
