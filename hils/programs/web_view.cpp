// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/web_view.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {

namespace {

constexpr int kPoll_ms = 50;

std::filesystem::path address_file(const RunPaths& paths) {
  return paths.sockets / "casweb.address";
}

/// The token is shown on a terminal alone: logs are kept, and others read them.
std::string address_words(const std::filesystem::path& file) {
  std::string address;
  std::getline(std::ifstream(file), address);
  if (::isatty(STDERR_FILENO) != 0) return address;
  return address.substr(0, address.find('#')) + " (the address with its token is in " +
         file.string() + ")";
}

}  // namespace

WebView::WebView(const RunPaths& paths, const Supervisor& supervisor) {
  std::string fault;
  try {
    const bool listens =
        start(paths, supervisor, "127.0.0.1:5791") ||
        (casweb_->poll_exit() && casweb_->poll_exit()->code == base::kExitCommandPort &&
         start(paths, supervisor, "127.0.0.1:0"));
    if (!listens) fault = "casweb did not start; its last lines:" + casweb_->log_tail();
  } catch (const base::ConfigError& error) {
    fault = error.what();
  }
  if (!fault.empty()) {
    casweb_.reset();
    fmt::print(stderr, "hils: the run goes on without a page: {}\n", fault);
    return;
  }
  fmt::print(stderr, "Page: {}\n", address_words(address_file(paths)));
  if (!base::web_dir()) fmt::print(stderr, "hils: {}\n", built_without_page());
}

bool WebView::start(const RunPaths& paths, const Supervisor& supervisor,
                    const std::string& listen) {
  ChildProcess::Options options;
  options.name = "casweb";
  // A token of this run: a page that stays open must tell the next program at this port none that
  // it takes.
  options.arguments = {sibling_program("casweb"),
                       "--listen",
                       listen,
                       "--casd",
                       paths.command_port,
                       "--hilsim",
                       paths.simulator_control(),
                       "--hils",
                       paths.run_port(),
                       "--token-file",
                       paths.sockets / "casweb.token",
                       "--address-file",
                       address_file(paths)};
  options.log_file = paths.run / "casweb.log";
  options.notify_socket = paths.sockets / "casweb.notify";
  casweb_ = std::make_unique<ChildProcess>(std::move(options));
  const base::RunTime deadline = base::steady_now() + Supervisor::kReadyTimeout;
  while (!casweb_->take_notifications()) {
    supervisor.check();
    if (casweb_->poll_exit() || base::steady_now() > deadline) return false;
    pollfd entries[] = {{casweb_->notify_fd(), POLLIN, 0}, {casweb_->pidfd(), POLLIN, 0}};
    ::poll(entries, 2, kPoll_ms);
  }
  return true;
}

std::string built_without_page(const std::filesystem::path& page_folder) {
  const auto cause = base::read_file(page_folder / "left_out.txt");
  return "CAS was built without the page" +
         (cause ? ": " + cause->substr(0, cause->find('\n')) : std::string()) +
         " (docs/use/web.md)";
}

std::string built_without_page() {
  return built_without_page(own_program().parent_path() / "../share/cas/web");
}

}  // namespace cas::hils
