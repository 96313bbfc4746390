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

namespace cas::hils {

namespace {

constexpr int kExecFailed = 127;

sigset_t set_of(std::initializer_list<int> signals) {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : signals) ::sigaddset(&set, signal);
  return set;
}

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> result;
  for (std::string& text : strings) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

[[noreturn]] void become(std::vector<std::string> command, std::vector<std::string> environment,
                         const sigset_t& mask, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kExecFailed);  // the parent died before prctl
  ::sigprocmask(SIG_SETMASK, &mask, nullptr);
  for (std::string& variable : environment) ::putenv(variable.data());
  ::execvp(command.front().c_str(), pointers(command).data());
  std::fprintf(stderr, "hils: %s cannot be started\n", command.front().c_str());
  ::_exit(kExecFailed);
}

}  // namespace

int run_in_foreground(const std::vector<std::string>& command,
                      const std::vector<std::string>& environment) {
  const sigset_t heard = set_of({SIGCHLD, SIGTERM, SIGHUP, SIGINT, SIGQUIT});
  sigset_t before;
  ::sigprocmask(SIG_BLOCK, &heard, &before);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw base::ConfigError(command.front() + " cannot be started");
  if (child == 0) become(command, environment, before, parent);
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    int signal = 0;
    ::sigwait(&heard, &signal);
    // The terminal has given the other two to the command as well.
    if (signal == SIGTERM || signal == SIGHUP) ::kill(child, signal);
  }
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
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
