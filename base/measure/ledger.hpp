// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/export.hpp"
#include "base/time/clock.hpp"

namespace cas::base {

/// One HIL packet at one point of its way. (message_id, time_usec) is its identity at every point.
struct LedgerEntry {
  enum class Direction : std::uint8_t { kSent, kReceived };
  Direction direction = Direction::kSent;
  std::uint32_t message_id = 0;
  std::uint64_t time_usec = 0;  ///< the packet's own stamp (or the stamp it echoes)
  std::int64_t at_ns = 0;       ///< RunTime at this point: CLOCK_MONOTONIC in real time
};

/// Remembers each HIL packet that a program sent or received, for the accounts of a run.
/// Memory grows in chunks ahead of need; nothing is written before `write()`.
class CAS_BASE_EXPORT PacketLedger {
 public:
  /// @param expected  entries to reserve room for
  explicit PacketLedger(std::size_t expected = 1 << 20);
  /// Notes a packet that left this program at `at`.
  void sent(std::uint32_t message_id, std::uint64_t time_usec, RunTime at);
  /// Notes a packet that came to this program at `at`.
  void received(std::uint32_t message_id, std::uint64_t time_usec, RunTime at);
  /// In the order in which they were noted.
  const std::vector<LedgerEntry>& entries() const { return entries_; }

  /// CSV with header "direction,message_id,time_usec,at_ns".
  std::string csv() const;
  /// Writes it as CSV, beside and renamed. @throws ConfigError when it cannot be written
  void write(const std::filesystem::path& file) const;
  /// Reads a file of write(). @throws ConfigError when it cannot be read
  static std::vector<LedgerEntry> read(const std::filesystem::path& file);

 private:
  std::vector<LedgerEntry> entries_;
};

}  // namespace cas::base
