// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/ticking_thread.hpp"

#include <poll.h>
#include <sys/eventfd.h>

#include <array>
#include <chrono>
#include <stop_token>
#include <utility>

#include "base/error.hpp"
#include "base/os/lack_of_memory.hpp"

namespace cas::hils {

TickingThread::TickingThread(int fd, base::Duration period, std::function<void()> work)
    : wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw base::ConfigError("cannot open an eventfd");
  const auto run = [fd, wake = wake_.get(), period,
                    work = std::move(work)](const std::stop_token& stop) {
    const std::stop_callback on_stop(stop, [wake] { ::eventfd_write(wake, 1); });
    const auto patience = std::chrono::duration_cast<std::chrono::milliseconds>(period);
    while (!stop.stop_requested()) {
      std::array<pollfd, 2> ends{pollfd{fd, POLLIN, 0}, pollfd{wake, POLLIN, 0}};
      ::poll(ends.data(), ends.size(), static_cast<int>(patience.count()));
      if (!stop.stop_requested()) base::outlive_lack_of_memory("a station of hils", work);
    }
  };
  thread_ = std::jthread(run);
}

}  // namespace cas::hils
