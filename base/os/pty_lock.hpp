// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "base/export.hpp"
#include "base/os/descriptor.hpp"

namespace cas::base {

/// Which pseudo-terminal: the kernel gives the number of one that is gone to the next, so the time
/// at which its node was made (or its mode or owner changed) is part of it.
struct PtyIdentity {
  std::uint64_t device = 0;     ///< st_rdev of the slave
  std::int64_t changed_ns = 0;  ///< st_ctim of the slave, ns since 1970

  friend bool operator==(const PtyIdentity&, const PtyIdentity&) = default;
};

/// Identity of the slave that `fd` has open; nullopt when `fd` is no pseudo-terminal's slave.
CAS_BASE_EXPORT std::optional<PtyIdentity> identify_pty(int fd);

/// The lock file LINK.lock beside the symlink LINK of an offered pseudo-terminal. The program holds
/// its lock while it runs (a crash releases it), and the file records the slave that LINK leads to.
/// So a reader tells an offer from a symlink that was left behind.
class CAS_BASE_EXPORT PtyLock {
 public:
  /// @throws ConfigError when another program offers LINK, or LINK.lock is a file of another kind
  explicit PtyLock(const std::filesystem::path& link);
  /// Removes the lock file.
  ~PtyLock();
  PtyLock(const PtyLock&) = delete;
  PtyLock& operator=(const PtyLock&) = delete;

  /// Names the slave from now on: before the symlink points to it, and again after its mode or
  /// owner has changed. No effect if it is recorded already. @throws ConfigError
  void name(int slave);
  /// Clears the record: before the pair is closed.
  void clear() noexcept;

 private:
  void write(const PtyIdentity& identity);

  std::filesystem::path file_;
  Descriptor lock_;
  PtyIdentity named_;
};

/// The program lock found at a path.
enum class PtyOffer : std::uint8_t {
  kNone,   ///< no running program holds a lock there
  kOther,  ///< one does, and names another terminal
  kThis    ///< one does, and names this one
};

/// Whether `slave`, opened by way of `path`, is the terminal that a running program offers there.
/// Where `path` leads over several symlinks, the lock beside any of them counts. A lock counts only
/// from root, from the owner of the terminal or from the caller's own user.
CAS_BASE_EXPORT PtyOffer pty_offer(std::filesystem::path path, int slave);

}  // namespace cas::base
