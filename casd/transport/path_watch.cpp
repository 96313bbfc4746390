// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/path_watch.hpp"

#include <sys/inotify.h>

#include <array>
#include <system_error>

namespace cas::casd {

void PathWatch::arm() {
  inotify_.reset();
  inotify_ = base::Descriptor(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  if (!inotify_) return;
  constexpr std::uint32_t kEvents =
      IN_CREATE | IN_MOVED_TO | IN_ATTRIB | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;
  std::error_code ignored;
  std::filesystem::path folder = std::filesystem::absolute(path_, ignored).parent_path();
  while (::inotify_add_watch(inotify_.get(), folder.c_str(), kEvents) < 0) {
    if (folder == folder.parent_path()) return;
    folder = folder.parent_path();
  }
}

bool PathWatch::take_changes() {
  alignas(inotify_event) std::array<char, 4096> events;
  bool any = false;
  while (inotify_ && ::read(inotify_.get(), events.data(), events.size()) > 0) any = true;
  return any;
}

}  // namespace cas::casd
