// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "base/os/pty_lock.hpp"
#include "tests/support/packet_stream.hpp"

namespace cas::test {

/// A pseudo-terminal as a serial line: the test holds the controller's end (the master), the
/// program under test opens the other one, usually through a symlink, which holds a lock.
class PtyPair {
 public:
  /// @param link  symlink to put at the slave; empty: none, and no lock
  explicit PtyPair(std::filesystem::path link = {});
  ~PtyPair();
  PtyPair(const PtyPair&) = delete;
  PtyPair& operator=(const PtyPair&) = delete;

  const std::string& slave() const { return slave_; }
  int master() const { return master_; }

  void write(std::span<const std::uint8_t> bytes);
  /// Reads waiting input, at most `most` bytes. @return bytes read
  std::size_t read(PacketStream& into, std::size_t most = 65536);
  /// Pulls the plug: the program reads end of file, the symlink goes.
  void hang_up();
  /// A new line under the old symlink.
  void come_back();

 private:
  void open();

  std::filesystem::path link_;
  std::optional<base::PtyLock> lock_;
  std::string slave_;
  int master_ = -1;
  int keep_ = -1;  ///< the slave, kept open so that the master never reads EIO
};

}  // namespace cas::test
