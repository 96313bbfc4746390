// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/supervisor.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "base/error.hpp"

namespace cas::hils {

namespace {

/// Time between SIGTERM and SIGKILL when the run has been stopped.
constexpr int kLastPatienceMs = 3000;

sigset_t stop_signals() {
  sigset_t set;
  ::sigemptyset(&set);
  ::sigaddset(&set, SIGINT);
  ::sigaddset(&set, SIGTERM);
  ::sigaddset(&set, SIGHUP);
  return set;
}

base::Descriptor open_signals() {
  const sigset_t set = stop_signals();
  if (::pthread_sigmask(SIG_BLOCK, &set, nullptr) != 0) {
    throw base::ConfigError("cannot block signals");
  }
  base::Descriptor fd(::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!fd) throw base::ConfigError("cannot open a signalfd");
  return fd;
}

}  // namespace

Supervisor::Supervisor()
    : signals_(open_signals()), wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw base::ConfigError("cannot open an eventfd");
  watcher_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
}

Supervisor::~Supervisor() {
  watcher_.request_stop();
  watcher_.join();
  for (const auto& child : children_) child->terminate();
  for (const auto& child : children_) {
    pollfd end{child->pidfd(), POLLIN, 0};
    if (!child->poll_exit()) ::poll(&end, 1, kLastPatienceMs);
    child->poll_exit();
  }
}

ChildProcess& Supervisor::start(ChildProcess::Options options, base::Duration timeout) {
  ChildProcess& child = launch(std::move(options));
  wait_ready(child, timeout);
  return child;
}

ChildProcess& Supervisor::launch(ChildProcess::Options options) {
  check();
  // PR_SET_PDEATHSIG kills the child when the forking thread exits, so fork here, not on the
  // watcher.
  auto owned = std::make_unique<ChildProcess>(std::move(options));
  ChildProcess& child = *owned;
  {
    const base::MutexLock lock(mutex_);
    children_.push_back(std::move(owned));
  }
  wake();
  return child;
}

void Supervisor::wait_ready(const ChildProcess& child, base::Duration timeout) {
  base::MutexLock lock(mutex_);
  const bool in_time = changed_.wait_for(
      lock, timeout, [&]() CAS_REQUIRES(mutex_) { return child.ready() || !stopped_.empty(); });
  if (!stopped_.empty()) throw RunStopped(stopped_, interrupted_);
  if (!in_time) {
    throw RunStopped(fmt::format("{} was not ready within {} s; its last lines:{}", child.name(),
                                 static_cast<int>(base::to_seconds(timeout)), child.log_tail()),
                     false);
  }
}

void Supervisor::check() const {
  const base::MutexLock lock(mutex_);
  if (!stopped_.empty()) throw RunStopped(stopped_, interrupted_);
}

void Supervisor::wait(base::Duration time) {
  base::MutexLock lock(mutex_);
  changed_.wait_for(lock, time, [this]() CAS_REQUIRES(mutex_) { return !stopped_.empty(); });
  if (!stopped_.empty()) throw RunStopped(stopped_, interrupted_);
}

bool Supervisor::stop(ChildProcess& child, base::Duration patience) {
  return stop(std::vector{&child}, patience) == nullptr;
}

ChildProcess* Supervisor::stop(const std::vector<ChildProcess*>& children,
                               base::Duration patience) {
  base::MutexLock lock(mutex_);
  for (ChildProcess* child : children) {
    expected_to_end_.insert(child);
    child->terminate();
  }
  const auto has_ended = [](ChildProcess* child) { return child->poll_exit().has_value(); };
  const auto all_ended = [&] { return std::ranges::all_of(children, has_ended); };
  std::set<ChildProcess*> late;
  if (!changed_.wait_for(lock, patience, all_ended)) {
    for (ChildProcess* child : children) {
      if (has_ended(child)) continue;
      late.insert(child);
      child->kill();
    }
    changed_.wait(lock, all_ended);
  }
  const auto bad = std::ranges::find_if(children, [&](ChildProcess* child) {
    return late.contains(child) || child->poll_exit()->code != 0;
  });
  return bad == children.end() ? nullptr : *bad;
}

std::optional<std::string> Supervisor::own_end(ChildProcess& child) {
  const base::MutexLock lock(mutex_);
  if (expected_to_end_.contains(&child)) return std::nullopt;
  const auto& exit = child.poll_exit();
  return exit ? std::optional(exit->words) : std::nullopt;
}

void Supervisor::kill(ChildProcess& child) {
  base::MutexLock lock(mutex_);
  expected_to_end_.insert(&child);
  child.kill();
  changed_.wait(lock, [&] { return child.poll_exit().has_value(); });
}

std::vector<std::pair<std::string, double>> Supervisor::cpu_s() const {
  const base::MutexLock lock(mutex_);
  std::vector<std::pair<std::string, double>> times;
  for (const auto& child : children_) {
    if (const auto& exit = child->poll_exit()) times.emplace_back(child->name(), exit->cpu_s);
  }
  return times;
}

/// Waits for signals, ends of programs and notifications, until closing.
void Supervisor::watch(const std::stop_token& stop) {
  const std::stop_callback wake_up(stop, [this] { wake(); });
  while (!stop.stop_requested()) {
    std::vector<pollfd> fds{{signals_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}};
    std::vector<ChildProcess*> watched;
    {
      const base::MutexLock lock(mutex_);
      for (const auto& child : children_) {
        if (ended_.contains(child.get())) continue;
        watched.push_back(child.get());
        fds.push_back({child->pidfd(), POLLIN, 0});
        fds.push_back({child->notify_fd(), POLLIN, 0});
      }
    }
    ::poll(fds.data(), fds.size(), patience_ms());
    if (fds[0].revents != 0) on_signal();
    std::uint64_t ignored = 0;
    [[maybe_unused]] const auto drained = ::read(wake_.get(), &ignored, sizeof(ignored));
    const base::MutexLock lock(mutex_);
    for (std::size_t i = 0; i < watched.size(); ++i) {
      watched[i]->take_notifications();
      if (fds[2 + 2 * i].revents != 0) on_exit(*watched[i]);
    }
    if (end_at_ && base::steady_now() >= *end_at_) end_programs();
    changed_.notify_all();
  }
}

/// Until the programs of a stopped run end.
int Supervisor::patience_ms() const {
  const base::MutexLock lock(mutex_);
  if (!end_at_) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(*end_at_ - base::steady_now());
  return std::max(0, static_cast<int>(left.count()));
}

void Supervisor::linger(base::Duration patience) {
  const base::MutexLock lock(mutex_);
  linger_ = patience;
}

void Supervisor::end_lingering() {
  const base::MutexLock lock(mutex_);
  linger_ = base::Duration::zero();
  if (end_at_) end_programs();
}

void Supervisor::end_programs() {
  end_at_.reset();
  linger_ = base::Duration::zero();
  for (const auto& child : children_) {
    expected_to_end_.insert(child.get());
    child->terminate();
  }
}

void Supervisor::wake() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(wake_.get(), &one, sizeof(one));
}

void Supervisor::on_signal() {
  signalfd_siginfo info{};
  if (::read(signals_.get(), &info, sizeof(info)) != sizeof(info)) return;
  const base::MutexLock lock(mutex_);
  stop_run("interrupted", true);
}

void Supervisor::on_exit(ChildProcess& child) {
  const auto& exit = child.poll_exit();
  if (!exit) return;
  ended_.insert(&child);
  if (expected_to_end_.contains(&child) || !child.ends_run()) return;
  stop_run(child.name() + " " + exit->words +
               " before the run was over; its last lines:" + child.log_tail(),
           false);
}

void Supervisor::stop_run(const std::string& sentence, bool interrupted) {
  if (stopped_.empty() || interrupted) {
    stopped_ = sentence;
    interrupted_ = interrupted;
  }
  if (linger_ > base::Duration::zero() && !end_at_) {
    end_at_ = base::steady_now() + linger_;  // a second signal, or another end, does not wait
  } else {
    end_programs();
  }
  changed_.notify_all();
}

}  // namespace cas::hils
