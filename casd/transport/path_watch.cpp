// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/path_watch.hpp"

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <system_error>
#include <vector>

namespace cas::casd {

// Anew each time: a folder that was missing may have come.
void PathWatch::arm() {
  inotify_ = base::Descriptor(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  if (!inotify_) return;
  std::error_code ignored;
  std::filesystem::path folder = std::filesystem::absolute(path_, ignored).parent_path();
  std::vector<std::filesystem::path> missing;
  for (; !watch(folder); folder = folder.parent_path()) {
    if (folder == folder.parent_path()) return;
    missing.push_back(folder);
  }
  // What came before its parent was watched made no event.
  while (!missing.empty() && watch(missing.back())) missing.pop_back();
}

bool PathWatch::watch(const std::filesystem::path& folder) {
  constexpr std::uint32_t kEvents =
      IN_CREATE | IN_MOVED_TO | IN_ATTRIB | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;
  return ::inotify_add_watch(inotify_.get(), folder.c_str(), kEvents) >= 0;
}

bool PathWatch::take_changes() {
  alignas(inotify_event) std::array<char, 4096> events;
  bool any = false;
  while (inotify_ && ::read(inotify_.get(), events.data(), events.size()) > 0) any = true;
  return any;
}

}  // namespace cas::casd
