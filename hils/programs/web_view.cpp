// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/web_view.hpp"

#include <poll.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "base/time/clock.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

namespace {

constexpr base::Duration kReadyTimeout = std::chrono::seconds(20);
constexpr int kPoll_ms = 50;

}  // namespace

WebView::WebView(const RunPlaces& places) {
  // A page that is open from an earlier run finds the next one at the same address.
  if (start(places, "127.0.0.1:5791") || start(places, "127.0.0.1:0")) return;
  throw RunStopped("casweb did not start; its last lines:" + casweb_->log_tail(), false);
}

bool WebView::start(const RunPlaces& places, const std::string& listen) {
  const std::filesystem::path programs =
      std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::filesystem::path file = places.sockets / "casweb.address";
  ChildProcess::Options options;
  options.name = "casweb";
  options.arguments = {(programs / "casweb").string(),
                       "--listen",
                       listen,
                       "--casd",
                       places.command_port,
                       "--hilsim",
                       places.simulator_control(),
                       "--address-file",
                       file};
  options.log_file = places.run / "casweb.log";
  options.notify_socket = places.sockets / "casweb.notify";
  casweb_ = std::make_unique<ChildProcess>(std::move(options));
  const base::RunTime deadline = base::steady_now() + kReadyTimeout;
  while (!casweb_->take_notifications()) {
    if (casweb_->poll_exit() || base::steady_now() > deadline) return false;
    pollfd entries[] = {{casweb_->notify_fd(), POLLIN, 0}, {casweb_->pidfd(), POLLIN, 0}};
    ::poll(entries, 2, kPoll_ms);
  }
  std::getline(std::ifstream(file), address_);
  return true;
}

}  // namespace cas::hils
