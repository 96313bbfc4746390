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
  if (!inotify_) {
    inotify_ = base::Descriptor(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
    opened_ = OpenDescriptor(inotify_.get());
  }
  if (!inotify_) return;
  forget();
  take_events();
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

void PathWatch::forget() {
  for (const int each : watches_) ::inotify_rm_watch(inotify_.get(), each);
  watches_.clear();
}

bool PathWatch::watch(const std::filesystem::path& folder) {
  constexpr std::uint32_t kEvents =
      IN_CREATE | IN_MOVED_TO | IN_ATTRIB | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;
  const int added = ::inotify_add_watch(inotify_.get(), folder.c_str(), kEvents);
  if (added >= 0) watches_.push_back(added);
  return added >= 0;
}

bool PathWatch::take_changes() { return !watches_.empty() && take_events(); }

bool PathWatch::take_events() {
  alignas(inotify_event) std::array<char, 4096> events;
  bool any = false;
  while (::read(inotify_.get(), events.data(), events.size()) > 0) any = true;
  return any;
}

}  // namespace cas::casd
