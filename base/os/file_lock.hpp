// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fcntl.h>

namespace cas::base {

/// Locks of open file descriptions over a whole file: one is released with its last descriptor,
/// however the process ends, a child inherits it, and it conflicts within one process too.
inline struct flock whole_file(short type) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  return lock;
}

/// Takes the lock of a file that is open for writing. @return false if another holds it
inline bool take_file_lock(int fd) {
  struct flock lock = whole_file(F_WRLCK);
  return ::fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

/// Whether another open file description holds the lock. Only asks, so it blocks no one.
inline bool is_file_locked(int fd) {
  struct flock lock = whole_file(F_RDLCK);
  return ::fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type == F_WRLCK;
}

}  // namespace cas::base
