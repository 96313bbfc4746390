// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/poll_set.hpp"

#include <atomic>
#include <cerrno>

#include "base/error.hpp"

namespace cas::casd {

static_assert(EPOLLIN == POLLIN && EPOLLOUT == POLLOUT && EPOLLERR == POLLERR &&
              EPOLLHUP == POLLHUP);

OpenDescriptor::OpenDescriptor(int fd) : fd_(fd) {
  static std::atomic<std::uint64_t> serials{0};
  if (fd >= 0) serial_ = serials.fetch_add(1, std::memory_order_relaxed) + 1;
}

PollSet::PollSet() : epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
  if (!epoll_) throw base::ConfigError("no poll descriptor: too many open files");
}

int PollSet::wait(const std::optional<timespec>& limit) {
  forget_events();
  const int trouble = changed_ || size_ != size_before_ ? apply_changes() : 0;
  in_trouble_ = trouble != 0;
  const bool at_once = limit || in_trouble_;
  if (limit && !in_trouble_) {
    pollfd any{epoll_.get(), POLLIN, 0};  // its limit is finer than that of epoll_wait
    if (::ppoll(&any, 1, &*limit, nullptr) < 0) return errno;
  }
  const int count = ::epoll_wait(epoll_.get(), events_.data(), static_cast<int>(events_.size()),
                                 at_once ? 0 : -1);
  if (count < 0) return errno;
  event_count_ = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < event_count_; ++i) {
    entries_[events_[i].data.u64].revents = static_cast<short>(events_[i].events);
  }
  return trouble;
}

void PollSet::release() {
  forget_events();
  clear();
  apply_changes();
}

void PollSet::forget_events() {
  for (; event_count_ > 0; --event_count_) {
    entries_[events_[event_count_ - 1].data.u64].revents = 0;
  }
  if (!in_trouble_) return;
  for (Entry& entry : entries_) entry.revents = 0;
}

// Remove first: the number of a closed descriptor may already belong to another entry. The kernel
// has removed closed descriptors itself, so that a failing EPOLL_CTL_DEL is no error.
int PollSet::apply_changes() {
  for (std::size_t i = size_; i < entries_.size(); ++i) entries_[i].wanted = {};
  for (Entry& entry : entries_) {
    if (entry.wanted == entry.registered || !entry.registered.fd) continue;
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, entry.registered.fd.get(), nullptr);
    entry.registered = {};
  }
  int trouble = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    const int error = register_entry(i);
    if (error == 0) continue;
    entries_[i].revents = POLLERR;
    trouble = error;
  }
  changed_ = trouble != 0;
  size_before_ = size_;
  events_.resize(std::max<std::size_t>(size_, 1));
  return trouble;
}

int PollSet::register_entry(std::size_t index) {
  Entry& entry = entries_[index];
  if (entry.wanted == entry.registered) return 0;
  if (entry.wanted.fd) {
    epoll_event event{};
    event.events = static_cast<std::uint32_t>(entry.wanted.events);
    event.data.u64 = index;
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, entry.wanted.fd.get(), &event) != 0) return errno;
  }
  entry.registered = entry.wanted;
  return 0;
}

}  // namespace cas::casd
