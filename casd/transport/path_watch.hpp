// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "base/os/descriptor.hpp"

namespace cas::casd {

/// Tells when something changes where a device is expected (inotify on the nearest folder that
/// exists), so that a link reopens the moment its device is back instead of at its next try.
class PathWatch {
 public:
  explicit PathWatch(std::filesystem::path path) : path_(std::move(path)) {}

  /// Starts to watch. Call again after each change: a missing folder may have come.
  void arm();
  void disarm() { inotify_.reset(); }
  /// To wait for POLLIN on; -1 when it cannot watch.
  int descriptor() const { return inotify_.get(); }
  /// Forgets the changes so far. @return true when there were any
  bool take_changes();

 private:
  std::filesystem::path path_;
  base::Descriptor inotify_;
};

}  // namespace cas::casd
