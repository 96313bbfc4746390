// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/foreground.hpp"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <initializer_list>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"
#include "hils/programs/child_process.hpp"

namespace cas::hils {

namespace {

constexpr int kExecFailed = 127;

sigset_t set_of(std::initializer_list<int> signals) {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : signals) ::sigaddset(&set, signal);
  return set;
}

/// The terminal whose foreground this program has, if it has one. SIGTTOU must be blocked.
class Terminal {
 public:
  Terminal() : fd_(::open("/dev/tty", O_RDWR | O_CLOEXEC)) {
    if (fd_ && ::tcgetpgrp(fd_.get()) != own_) fd_.reset();
  }
  explicit operator bool() const { return static_cast<bool>(fd_); }
  void lend_to(pid_t group) const { pass(own_, group); }
  void take_back(pid_t group) const { pass(group, own_); }

 private:
  /// Only where `from` has it still: a shell may have taken it (Ctrl-Z, bg).
  void pass(pid_t from, pid_t to) const {
    if (fd_ && ::tcgetpgrp(fd_.get()) == from) ::tcsetpgrp(fd_.get(), to);
  }

  pid_t own_ = ::getpgrp();
  base::Descriptor fd_;
};

[[noreturn]] void become(ForegroundCommand command, const sigset_t& mask, pid_t parent,
                         const Terminal& terminal) {
  ::setpgid(0, 0);
  terminal.lend_to(::getpid());
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kExecFailed);  // the parent died before prctl
  ::sigprocmask(SIG_SETMASK, &mask, nullptr);
  for (std::string& variable : command.environment) ::putenv(variable.data());
  if (command.kept >= 0) ::fcntl(command.kept, F_SETFD, 0);
  if (!command.folder.empty() && ::chdir(command.folder.c_str()) != 0) ::_exit(kExecFailed);
  ::execvp(command.arguments.front().c_str(), exec_words(command.arguments).data());
  std::fprintf(stderr, "hils: %s cannot be started\n", command.arguments.front().c_str());
  ::_exit(kExecFailed);
}

/// Stops with a command that was stopped on the terminal (Ctrl-Z), and goes on with it. So does the
/// script around this program, as if it had heard the key.
void stop_with(pid_t group, const Terminal& terminal) {
  terminal.take_back(group);
  ::kill(0, SIGTSTP);
  terminal.lend_to(group);
  ::kill(-group, SIGCONT);
}

/// @return its status of waitpid()
int wait_for(pid_t child, const sigset_t& heard, const Terminal& terminal) {
  while (true) {
    int status = 0;
    const pid_t changed = ::waitpid(child, &status, WNOHANG | (terminal ? WUNTRACED : 0));
    if (changed < 0) throw base::ConfigError("the end of the command cannot be seen");
    if (changed > 0 && !WIFSTOPPED(status)) return status;
    if (changed > 0) {
      stop_with(child, terminal);
      continue;
    }
    int signal = 0;
    ::sigwait(&heard, &signal);
    if (signal != SIGCHLD) ::kill(-child, signal);
  }
}

}  // namespace

int run_in_foreground(const ForegroundCommand& command) {
  const sigset_t heard = set_of({SIGCHLD, SIGTERM, SIGHUP, SIGINT, SIGQUIT});
  const sigset_t background = set_of({SIGTTOU});
  sigset_t before;
  ::sigprocmask(SIG_BLOCK, &heard, &before);
  ::sigprocmask(SIG_BLOCK, &background, nullptr);
  const Terminal terminal;
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw base::ConfigError(command.arguments.front() + " cannot be started");
  if (child == 0) become(command, before, parent, terminal);
  ::setpgid(child, child);
  const int status = wait_for(child, heard, terminal);
  terminal.take_back(child);
  const int end = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  // The script around this program has not heard Ctrl-C.
  if (terminal && end == SIGINT) ::kill(0, SIGINT);
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  return end != 0 ? 128 + end : WEXITSTATUS(status);
}

int go_to_background() {
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) throw base::ConfigError("no process can be started in the background");
  if (child > 0) return child;
  ::setsid();
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, fd);
  return 0;
}

void wait_to_be_ended(base::Duration most) {
  const sigset_t ends = set_of({SIGTERM, SIGINT, SIGHUP});
  ::sigprocmask(SIG_BLOCK, &ends, nullptr);
  const timespec left{.tv_sec = static_cast<time_t>(base::to_seconds(most)), .tv_nsec = 0};
  ::sigtimedwait(&ends, nullptr, &left);
}

}  // namespace cas::hils
