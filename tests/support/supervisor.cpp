// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/supervisor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace cas::test {
namespace {

using std::chrono::duration_cast;
using std::chrono::microseconds;
using std::chrono::milliseconds;

base::Descriptor notify_socket(const std::string& path) {
  base::Descriptor fd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  if (::bind(fd.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("no notify socket");
  }
  return fd;
}

/// Signals after which systemd sees a clean end.
bool ends_cleanly(int signal) {
  return signal == SIGHUP || signal == SIGINT || signal == SIGTERM || signal == SIGPIPE;
}

}  // namespace

Supervisor::Supervisor(const UnitFile& unit, std::map<std::string, std::string> words)
    : unit_(unit),
      words_(std::move(words)),
      restart_after_(unit.span("RestartSec", "100ms")),
      watchdog_(unit.span("WatchdogSec", "0")),
      abort_patience_(unit.span("TimeoutStopSec", "90s")),
      notify_(notify_socket(folder_ / "notify")),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  thread_ = std::thread([this] { supervise(); });
}

Supervisor::~Supervisor() {
  ending_.store(true);
  ::eventfd_write(wake_.get(), 1);
  thread_.join();
}

std::optional<std::string> Supervisor::wait_ready(base::Duration patience) {
  const bool over = wait_until(
      [this] {
        const State now = state();
        return now == State::kRunning || now == State::kFailed;
      },
      patience);
  const std::lock_guard lock(mutex_);
  return over && state_ == State::kRunning ? std::optional(status_) : std::nullopt;
}

void Supervisor::restart() {
  {
    const std::lock_guard lock(mutex_);
    restart_wanted_ = true;
    state_ = State::kStarting;  // from now on READY means the next process
  }
  signal(SIGTERM);
}

void Supervisor::reload() { signal(SIGHUP); }

base::RunTime Supervisor::signal(int number) {
  const std::lock_guard lock(mutex_);
  if (number == SIGKILL && state_ == State::kRunning) state_ = State::kWaiting;
  const base::RunTime when = base::steady_now();
  if (pid_ > 0) ::kill(pid_, number);
  return when;
}

Supervisor::State Supervisor::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

int Supervisor::starts() const {
  const std::lock_guard lock(mutex_);
  return starts_;
}

int Supervisor::feeds() const {
  const std::lock_guard lock(mutex_);
  return feeds_;
}

pid_t Supervisor::pid() const {
  const std::lock_guard lock(mutex_);
  return pid_;
}

std::string Supervisor::output() const { return TemporaryFolder::read(folder_ / "output"); }

void Supervisor::supervise() {
  start();
  while (!ending_.load()) {
    base::Duration wait = std::chrono::hours(1);
    const base::RunTime now = base::steady_now();
    if (!process_ && state() == State::kWaiting) wait = next_start_ - now;
    if (process_ && watchdog_.count() > 0)
      wait = fed_ + (aborted_ ? abort_patience_ : watchdog_) - now;
    const auto left = std::max<std::int64_t>(0, duration_cast<milliseconds>(wait).count());
    std::array<pollfd, 3> events{
        {{notify_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}, {process_.get(), POLLIN, 0}}};
    ::poll(events.data(), events.size(), static_cast<int>(left));
    if (events[0].revents != 0) listen();
    if (process_ && events[2].revents != 0) bury();
    if (process_ && watchdog_.count() > 0) watch_over();
    if (!process_ && state() == State::kWaiting && base::steady_now() >= next_start_) start();
  }
  if (process_) {
    signal(SIGKILL);
    ::waitpid(pid(), nullptr, 0);
  }
}

bool Supervisor::may_start(base::RunTime now) {
  const base::Duration interval = unit_.span("StartLimitIntervalSec", "10s");
  const std::size_t burst = std::stoul(unit_.value("StartLimitBurst", "5"));
  while (!recent_starts_.empty() && now - recent_starts_.front() > interval) {
    recent_starts_.pop_front();
  }
  if (interval.count() > 0 && recent_starts_.size() >= burst) return false;
  recent_starts_.push_back(now);
  return true;
}

void Supervisor::start() {
  if (!may_start(base::steady_now())) {
    const std::lock_guard lock(mutex_);
    state_ = State::kFailed;
    return;
  }
  for (const std::string& line : unit_.all("ExecStartPre")) {
    ::waitpid(spawn(command(line)), nullptr, 0);
  }
  const pid_t pid = spawn(command(unit_.value("ExecStart")));
  process_ = base::Descriptor(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  fed_ = base::steady_now();
  aborted_ = false;
  const std::lock_guard lock(mutex_);
  pid_ = pid;
  ++starts_;
  state_ = State::kStarting;
}

/// Reads the program's notifications: READY=1 with its STATUS, WATCHDOG=1.
void Supervisor::listen() {
  std::array<char, 4096> text;
  for (;;) {
    const ssize_t size = ::recv(notify_.get(), text.data(), text.size(), 0);
    if (size <= 0) return;
    fed_ = base::steady_now();
    const std::string message(text.data(), static_cast<std::size_t>(size));
    if (message.find("WATCHDOG=1") != std::string::npos) {
      const std::lock_guard lock(mutex_);
      ++feeds_;
    }
    if (message.find("READY=1") == std::string::npos) continue;
    const std::size_t at = message.find("STATUS=");
    const std::lock_guard lock(mutex_);
    if (at != std::string::npos) status_ = message.substr(at + 7, message.find('\n', at) - at - 7);
    if (!restart_wanted_) state_ = State::kRunning;
  }
}

/// A program that does not feed its watchdog gets SIGABRT, and if that does not end it, SIGKILL.
void Supervisor::watch_over() {
  const base::RunTime now = base::steady_now();
  if (now < fed_ + (aborted_ ? abort_patience_ : watchdog_)) return;
  signal(aborted_ ? SIGKILL : SIGABRT);
  aborted_ = true;
  fed_ = now;
}

/// The program has ended: another one, or the end of the matter.
void Supervisor::bury() {
  int status = 0;
  ::waitpid(pid(), &status, 0);
  process_ = base::Descriptor();
  const base::RunTime now = base::steady_now();
  const std::lock_guard lock(mutex_);
  pid_ = -1;
  if (std::exchange(restart_wanted_, false)) {
    state_ = State::kWaiting;
    next_start_ = now;
  } else if (restarts_after(status)) {
    state_ = State::kWaiting;
    next_start_ = now + restart_after_;
  } else {
    const bool clean =
        WIFEXITED(status) ? WEXITSTATUS(status) == 0 : ends_cleanly(WTERMSIG(status));
    state_ = clean ? State::kStopped : State::kFailed;
  }
}

bool Supervisor::restarts_after(int status) const {
  const std::string when = unit_.value("Restart", "no");
  if (when == "always") return true;
  if (when != "on-failure") return false;
  if (WIFSIGNALED(status)) return !ends_cleanly(WTERMSIG(status));
  std::istringstream prevented(unit_.value("RestartPreventExitStatus"));
  for (int code = 0; prevented >> code;) {
    if (code == WEXITSTATUS(status)) return false;
  }
  return WEXITSTATUS(status) != 0;
}

std::vector<std::string> Supervisor::command(const std::string& line) const {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    const auto other = words_.find(word);
    words.push_back(other == words_.end() ? word : other->second);
  }
  return words;
}

pid_t Supervisor::spawn(const std::vector<std::string>& command) const {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  std::vector<std::string> variables = {"NOTIFY_SOCKET=" + (folder_ / "notify").string(),
                                        "CAS_RUNTIME_DIR=" + (folder_ / "cas").string()};
  if (watchdog_.count() > 0) {
    variables.push_back("WATCHDOG_USEC=" +
                        std::to_string(duration_cast<microseconds>(watchdog_).count()));
  }
  std::vector<char*> environment;
  for (std::string& variable : variables) environment.push_back(variable.data());
  for (char** old = environ; *old != nullptr; ++old) environment.push_back(*old);
  environment.push_back(nullptr);
  const std::string output = folder_ / "output";
  const pid_t pid = ::fork();
  if (pid != 0) return pid;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int out = ::open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  ::dup2(out, 1);
  ::dup2(out, 2);
  ::execve(arguments[0], arguments.data(), environment.data());
  ::_exit(127);
}

}  // namespace cas::test
