// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace cas::test {

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  const std::string notify_path = folder_ / "notify";
  notify_fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  notify_path.copy(address.sun_path, sizeof address.sun_path - 1);
  if (::bind(notify_fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    throw std::runtime_error("no notify socket");
  }
  const std::string output = folder_ / "output";
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ != 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::setenv("NOTIFY_SOCKET", notify_path.c_str(), 1);
  const int out = ::open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(out, 1);
  ::dup2(out, 2);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

ChildProcess::~ChildProcess() {
  if (!ended()) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(notify_fd_);
}

std::optional<std::string> ChildProcess::wait_ready(base::Duration patience) {
  std::string status;
  const bool ready = wait_until(
      [&] {
        std::array<char, 4096> text;
        const ssize_t size = ::recv(notify_fd_, text.data(), text.size(), 0);
        if (size <= 0) return ended();
        const std::string message(text.data(), static_cast<std::size_t>(size));
        if (message.find("READY=1") == std::string::npos) return false;
        const std::size_t at = message.find("STATUS=");
        if (at != std::string::npos) status = message.substr(at + 7);
        return true;
      },
      patience);
  if (!ready || exit_code_) return std::nullopt;
  return status.substr(0, status.find('\n'));
}

void ChildProcess::signal(int number) { ::kill(pid_, number); }

std::optional<int> ChildProcess::wait_exit(base::Duration patience) {
// A flight under a sanitizer, beside others, takes many times as long.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  patience *= 6;
#endif
  wait_until([&] { return ended(); }, patience);
  return exit_code_;
}

Ended ChildProcess::end(base::Duration patience) {
  const int code = wait_exit(patience).value_or(-1);
  return {code, output()};
}

std::string ChildProcess::output() const {
  std::ostringstream text;
  text << std::ifstream(folder_ / "output").rdbuf();
  return text.str();
}

bool ChildProcess::ended() {
  if (exit_code_) return true;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return false;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return true;
}

std::string word_after(const std::string& status, const std::string& name) {
  const std::string words = " " + status + " ";
  const std::size_t at = words.find(" " + name + " ");
  const std::size_t begin = at + name.size() + 2;
  if (at == std::string::npos || begin >= words.size()) {
    throw std::runtime_error("no word after \"" + name + "\" in \"" + status + "\"");
  }
  return words.substr(begin, words.find(' ', begin) - begin);
}

}  // namespace cas::test
