// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "base/export.hpp"
#include "base/os/pty_lock.hpp"

namespace cas::base {

/// A pseudo-terminal in place of a serial port, offered under a constant symlink.
///
/// Raw from birth, so that nothing is echoed to the peer; one slave is kept open, so that the
/// master never reads EIO when the peer goes; the symlink is replaced by rename, so that it always
/// points to something; a lock beside it keeps a second program off the same name, and confirms to
/// openers of the symlink that it still names this pseudo-terminal (PtyLock).
class CAS_BASE_EXPORT Pty {
 public:
  /// @param link  symlink to offer the slave under; its folder is made
  /// @throws base::ConfigError
  explicit Pty(std::filesystem::path link);
  ~Pty();
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  /// Non-blocking master; -1 while hung up.
  int master() const { return master_; }
  /// The slave, as the peer opens it: shows how many bytes wait there unread.
  int slave() const { return slave_; }
  /// "/dev/pts/N"; empty while hung up.
  const std::string& slave_name() const { return slave_name_; }
  const std::filesystem::path& link() const { return link_; }

  /// Unplugs: the peer reads EIO or end of file, the symlink is gone.
  void hang_up();
  /// Plugs in again: a fresh pair under the same symlink. Stays hung up when it throws.
  /// @throws base::ConfigError
  void open();
  /// The lock names this pseudo-terminal again, if its mode or owner was changed. Call now and
  /// then.
  /// @throws base::ConfigError
  void refresh_lock();

 private:
  void open_pair();
  void place_link() const;
  void close_pair();

  std::filesystem::path link_;
  PtyLock lock_;
  std::string slave_name_;
  int master_ = -1;
  int slave_ = -1;
};

}  // namespace cas::base
