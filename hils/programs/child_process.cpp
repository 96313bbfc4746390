// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/child_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <string_view>

#include "base/error.hpp"
#include "base/os/result_file.hpp"

namespace cas::hils {

namespace {

constexpr int kExecFailed = 127;

[[noreturn]] void fail(const std::string& what) {
  throw base::ConfigError(what + ": " + std::strerror(errno));
}

base::Descriptor open_notify_socket(const std::filesystem::path& path) {
  base::Descriptor fd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) fail("cannot open a notify socket");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = path.string();
  if (name.size() >= sizeof(address.sun_path)) {
    throw base::ConfigError("the path of the notify socket is too long: " + name);
  }
  std::memcpy(address.sun_path, name.c_str(), name.size() + 1);
  ::unlink(name.c_str());
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    fail("cannot bind " + name);
  }
  return fd;
}

/// The environment of this process with NOTIFY_SOCKET, where there is one, and the variables `own`.
std::vector<std::string> environment_with(const std::string& notify_socket,
                                          std::vector<std::string> own) {
  if (!notify_socket.empty()) own.push_back("NOTIFY_SOCKET=" + notify_socket);
  std::vector<std::string> variables = own;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view theirs(*entry);
    const std::string_view name = theirs.substr(0, theirs.find('=') + 1);
    const auto same = [name](const std::string& mine) { return mine.starts_with(name); };
    if (std::none_of(own.begin(), own.end(), same)) variables.emplace_back(theirs);
  }
  return variables;
}

/// The child's side between fork and exec: calls that are safe there only.
[[noreturn]] void become(char* const* argv, char* const* envp, const char* cwd, int log_fd,
                         pid_t parent) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kExecFailed);  // the parent died before prctl
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int null_fd = ::open("/dev/null", O_RDONLY);
  ::dup2(null_fd, STDIN_FILENO);
  ::dup2(log_fd, STDOUT_FILENO);
  ::dup2(log_fd, STDERR_FILENO);
  if (*cwd != 0 && ::chdir(cwd) != 0) ::_exit(kExecFailed);
  ::execve(argv[0], argv, envp);
  constexpr std::string_view kMessage = "cannot execute the program\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kMessage.data(), kMessage.size());
  ::_exit(kExecFailed);
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

ExitStatus to_exit_status(int status, const rusage& usage) {
  ExitStatus exit;
  exit.cpu_s = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
  exit.max_rss_mib = static_cast<double>(usage.ru_maxrss) / 1024;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    exit.code = 128 + signal;
    exit.words = fmt::format("was ended by signal {} ({})", signal, ::strsignal(signal));
  } else {
    exit.code = WEXITSTATUS(status);
    exit.words = fmt::format("ended with exit code {}", exit.code);
  }
  return exit;
}

}  // namespace

std::vector<char*> exec_words(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

ChildProcess::ChildProcess(Options options) : options_(std::move(options)) {
  const bool notifies = !options_.notify_socket.empty();
  if (notifies) notify_ = open_notify_socket(options_.notify_socket);
  std::vector<std::string> environment =
      environment_with(options_.notify_socket.string(), options_.environment);
  ready_ = !notifies || !options_.says_ready;
  const std::vector<char*> argv = exec_words(options_.arguments);
  const std::vector<char*> envp = exec_words(environment);
  const base::ResultPlace place{options_.log_file.parent_path(), options_.log_file.filename()};
  const base::Descriptor log =
      options_.appends ? base::append_result(place) : base::make_result(place);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) fail("cannot start " + options_.name);
  if (pid_ == 0) {
    become(argv.data(), envp.data(), options_.cwd.c_str(), log.get(), parent);
  }
  ::setpgid(pid_, pid_);
  pidfd_ = base::Descriptor(static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0)));
  if (pidfd_) return;
  kill();
  ::waitpid(pid_, nullptr, 0);
  fail("cannot watch " + options_.name);
}

ChildProcess::~ChildProcess() {
  if (exit_ || pid_ < 0) return;
  kill();
  ::waitpid(pid_, nullptr, 0);
}

bool ChildProcess::take_notifications() {
  std::array<char, 4096> buffer{};
  while (true) {
    const ssize_t size = ::recv(notify_.get(), buffer.data(), buffer.size(), 0);
    if (size <= 0) return ready_;
    std::string_view text(buffer.data(), static_cast<std::size_t>(size));
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string_view line = text.substr(0, end);
      if (line == "READY=1") ready_ = true;
      text.remove_prefix(std::min(end + 1, text.size()));
    }
  }
}

const std::optional<ExitStatus>& ChildProcess::poll_exit() {
  if (exit_) return exit_;
  int status = 0;
  rusage usage{};
  if (::wait4(pid_, &status, WNOHANG, &usage) == pid_) exit_ = to_exit_status(status, usage);
  return exit_;
}

const std::optional<ExitStatus>& ChildProcess::wait_exit(base::Duration patience) {
  constexpr double kLongestLook_s = 60;
  while (!poll_exit()) {
    const double left_s = base::to_seconds(begin_ + patience - base::steady_now());
    if (left_s <= 0) break;
    pollfd ended{pidfd_.get(), POLLIN, 0};
    ::poll(&ended, 1, static_cast<int>(std::min(left_s, kLongestLook_s) * 1000) + 1);
  }
  return exit_;
}

void ChildProcess::terminate() {
  if (!exit_ && pid_ > 0) ::kill(-pid_, SIGTERM);
}

void ChildProcess::kill() {
  if (!exit_ && pid_ > 0) ::kill(-pid_, SIGKILL);
}

std::string ChildProcess::log_tail(std::size_t lines) const {
  std::ifstream in(options_.log_file);
  std::deque<std::string> tail;
  for (std::string line; std::getline(in, line);) {
    tail.push_back(line);
    if (tail.size() > lines) tail.pop_front();
  }
  std::string text;
  for (const std::string& line : tail) text += "\n    " + line;
  return text;
}

std::filesystem::path own_program() { return std::filesystem::read_symlink(kSameProgram); }

std::filesystem::path sibling_program(const std::string& name) {
  return own_program().parent_path() / name;
}

}  // namespace cas::hils
