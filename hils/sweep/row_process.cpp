// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/row_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.hpp"

namespace cas::hils {

namespace {

constexpr int kExecFailed = 127;

[[noreturn]] void fail(const std::string& what) {
  throw base::ConfigError(what + ": " + std::strerror(errno));
}

/// The child's side between fork and exec: calls that are safe there only.
[[noreturn]] void become(char* const* argv, int log_fd, pid_t parent) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kExecFailed);  // the parent died before prctl
  const int null_fd = ::open("/dev/null", O_RDONLY);
  ::dup2(null_fd, STDIN_FILENO);
  ::dup2(log_fd, STDOUT_FILENO);
  ::dup2(log_fd, STDERR_FILENO);
  ::execv(argv[0], argv);
  ::_exit(kExecFailed);
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

}  // namespace

RowProcess::RowProcess(std::vector<std::string> arguments, const std::filesystem::path& log_file)
    : begin_(base::steady_now()) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const base::Descriptor log(
      ::open(log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_APPEND, 0644));
  if (!log) fail("cannot write " + log_file.string());
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) fail("cannot start a process for a run");
  if (pid_ == 0) become(argv.data(), log.get(), parent);
  ::setpgid(pid_, pid_);
  pidfd_ = base::Descriptor(static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0)));
  if (pidfd_) return;
  kill();
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
  fail("cannot watch the process of a run");
}

RowProcess::~RowProcess() {
  if (pid_ <= 0) return;
  kill();
  ::waitpid(pid_, nullptr, 0);
}

RowProcess::RowProcess(RowProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), pidfd_(std::move(other.pidfd_)), begin_(other.begin_) {}

std::optional<ProcessEnd> RowProcess::poll_end() {
  int status = 0;
  rusage usage{};
  if (pid_ <= 0 || ::wait4(pid_, &status, WNOHANG, &usage) != pid_) return std::nullopt;
  pid_ = -1;
  ProcessEnd end{.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime),
                 .max_rss_mib = static_cast<double>(usage.ru_maxrss) / 1024};
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    end.code = 128 + signal;
    end.words = "was ended by signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
  } else {
    end.code = WEXITSTATUS(status);
    end.words = "ended with exit code " + std::to_string(end.code);
  }
  return end;
}

void RowProcess::kill() {
  if (pid_ > 0) ::kill(-pid_, SIGKILL);
}

std::filesystem::path own_program() { return std::filesystem::read_symlink("/proc/self/exe"); }

}  // namespace cas::hils
