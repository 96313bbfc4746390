// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/link/poll_set.hpp"

namespace cas::casd {

/// Notices changes at the path of a device (inotify on the nearest folder that exists), so that a
/// link reopens the moment its device is back and not only at its next try.
class PathWatch {
 public:
  explicit PathWatch(std::filesystem::path path) : path_(std::move(path)) {}

  /// Watches first and then looks, so no change between the look and the wait is missed.
  /// @param look  whether the device is there; then the watch ends
  /// @return the answer of `look`
  template <class Look>
  bool found_by(Look&& look) {
    arm();
    const bool found = look();
    if (found) forget();
    return found;
  }
  /// To wait for POLLIN on; none when nothing is watched, or it cannot watch.
  OpenDescriptor descriptor() const { return watches_.empty() ? OpenDescriptor() : opened_; }
  /// Forgets the changes so far. @return true when there were any
  bool take_changes();

 private:
  void arm();
  void forget();
  bool watch(const std::filesystem::path& folder);
  bool take_events();

  std::filesystem::path path_;
  base::Descriptor inotify_;  ///< stays open: to close one takes the kernel tens of milliseconds
  OpenDescriptor opened_;     ///< `inotify_` for a PollSet
  std::vector<int> watches_;  ///< of the folders that are watched
};

}  // namespace cas::casd
