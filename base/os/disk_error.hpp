// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <cerrno>
#include <string>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"

namespace cas::base {

/// A file was not written, or not to its end, because the disk did not take it: not the fault of
/// the one who named the file.
class CAS_BASE_EXPORT DiskError : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

/// @param error  errno of a write @throws DiskError if there was no room, else ConfigError
[[noreturn]] inline void throw_unwritten(const std::string& sentence, int error) {
  if (error == ENOSPC || error == EDQUOT) throw DiskError(sentence);
  throw ConfigError(sentence);
}

/// Closes a written file, if it is open. @return errno of close(2), by which some file systems
/// report an earlier write that failed; 0 without an error
inline int close_written(Descriptor& file) {
  const int fd = file.release();
  return fd < 0 || ::close(fd) == 0 ? 0 : errno;
}

}  // namespace cas::base
