// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <poll.h>
#include <sys/epoll.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/time/clock.hpp"

namespace cas::casd {

/// A descriptor with the serial number of its opening. The system reuses numbers of descriptors
/// after a close; serials are never reused.
class OpenDescriptor {
 public:
  OpenDescriptor() = default;
  /// @param fd  just opened, and owned by somebody else
  explicit OpenDescriptor(int fd);

  explicit operator bool() const { return fd_ >= 0; }
  int get() const { return fd_; }

  friend bool operator==(const OpenDescriptor&, const OpenDescriptor&) = default;

 private:
  int fd_ = -1;
  std::uint64_t serial_ = 0;
};

/// What a thread waits for: descriptors and the earliest moment at which something is due.
///
/// Each turn names all of them anew, and only the differences from the last turn take a system
/// call (epoll): a wait costs the same for two descriptors and for hundreds.
class PollSet {
 public:
  static constexpr base::RunTime kNever = base::RunTime::max();

  /// @throws base::ConfigError when there is no descriptor to be had
  PollSet();

  /// Begins a turn.
  void clear() {
    size_ = 0;
    deadline_ = kNever;
  }
  /// @param fd      none: the entry stays without events
  /// @param events  of poll(2)
  /// @return where the answer will be found
  std::size_t add(const OpenDescriptor& fd, short events) {
    const Wanted wanted{fd, events};
    if (size_ == entries_.size()) entries_.emplace_back();
    Entry& entry = entries_[size_];
    if (entry.wanted != wanted) {
      entry.wanted = wanted;
      changed_ = true;
    }
    return size_++;
  }
  void wake_by(base::RunTime when) { deadline_ = std::min(deadline_, when); }
  base::RunTime deadline() const { return deadline_; }

  /// Waits for an event, no longer than `limit`; nothing: for ever.
  /// @return 0, or an errno; when descriptors cannot be watched, at once, with POLLERR for these
  int wait(const std::optional<timespec>& limit);
  /// Watches nothing until the next turn: another thread may close a descriptor from here on.
  void release();
  /// Events that poll(2) reported at the last wait.
  short revents(std::size_t index) const { return entries_[index].revents; }

 private:
  struct Wanted {
    OpenDescriptor fd;
    short events = 0;

    friend bool operator==(const Wanted&, const Wanted&) = default;
  };
  struct Entry {
    Wanted wanted;
    Wanted registered;  ///< what the kernel watches for this entry
    short revents = 0;
  };

  int apply_changes();
  int register_entry(std::size_t index);
  void forget_events();

  base::Descriptor epoll_;
  std::vector<Entry> entries_;  ///< those of this turn, and behind them what earlier ones had more
  std::size_t size_ = 0;
  std::size_t size_before_ = 0;  ///< of the last wait
  bool changed_ = false;         ///< wanted and registered differ
  base::RunTime deadline_ = kNever;
  std::vector<epoll_event> events_;
  std::size_t event_count_ = 0;
  bool in_trouble_ = false;  ///< some entries could not be watched
};

}  // namespace cas::casd
