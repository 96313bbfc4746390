// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/terminal_program.hpp"

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

namespace cas::test {
namespace {

winsize size_of(std::size_t rows, std::size_t columns) {
  winsize size{};
  size.ws_row = static_cast<unsigned short>(rows);
  size.ws_col = static_cast<unsigned short>(columns);
  return size;
}

/// Sentences that go on in the next line, in one.
std::string unwrapped(const std::string& lines) {
  std::istringstream in(lines);
  std::string text;
  for (std::string word; in >> word;) text += word + " ";
  return text;
}

}  // namespace

TerminalProgram::TerminalProgram(const std::vector<std::string>& command, std::size_t rows,
                                 std::size_t columns)
    : cells_(rows, std::string(columns, ' ')) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const winsize size = size_of(rows, columns);
  pid_ = ::forkpty(&master_, nullptr, nullptr, &size);
  if (pid_ == 0) {
    ::setenv("TERM", "vt52", 1);
    ::setenv("LC_ALL", "C", 1);
    ::unsetenv("LINES");
    ::unsetenv("COLUMNS");
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::fcntl(master_, F_SETFL, O_NONBLOCK);
}

TerminalProgram::~TerminalProgram() {
  if (!exit_code_) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(master_);
}

void TerminalProgram::resize(std::size_t rows, std::size_t columns) {
  read_terminal();
  cells_.resize(rows);
  for (std::string& line : cells_) line.resize(columns, ' ');
  row_ = std::min(row_, rows - 1);
  column_ = std::min(column_, columns - 1);
  const winsize size = size_of(rows, columns);
  ::ioctl(master_, TIOCSWINSZ, &size);  // the kernel tells the program
}

void TerminalProgram::press(const std::string& keys) {
  std::size_t written = 0;
  wait_until([&] {
    const ssize_t count = ::write(master_, keys.data() + written, keys.size() - written);
    if (count > 0) written += static_cast<std::size_t>(count);
    return written == keys.size();
  });
}

const std::vector<std::string>& TerminalProgram::screen() {
  read_terminal();
  screen_ = cells_;
  for (std::string& line : screen_) line.erase(line.find_last_not_of(' ') + 1);
  return screen_;
}

std::string TerminalProgram::text() {
  std::string all;
  for (const std::string& line : screen()) all += line + "\n";
  return all;
}

bool TerminalProgram::shows(const std::string& wanted, base::Duration patience) {
  return wait_until(
      [&] {
        const std::string lines = text();
        return lines.find(wanted) != std::string::npos ||
               unwrapped(lines).find(wanted) != std::string::npos;
      },
      patience);
}

std::optional<int> TerminalProgram::wait_exit() {
  wait_until([this] {
    read_terminal();  // a program that cannot write does not end
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) != pid_) return false;
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return true;
  });
  return exit_code_;
}

void TerminalProgram::read_terminal() {
  unsigned char bytes[4096];
  for (ssize_t count = 0; (count = ::read(master_, bytes, sizeof bytes)) > 0;) {
    for (ssize_t i = 0; i < count; ++i) on_byte(bytes[i]);
  }
}

void TerminalProgram::on_byte(unsigned char byte) {
  constexpr std::size_t kPlaceOffset = 32;  // of rows and columns on the wire
  switch (expects_) {
    case Expects::kLetter:
      return on_escape(byte);
    case Expects::kRow:
      row_ = std::min<std::size_t>(byte - kPlaceOffset, cells_.size() - 1);
      expects_ = Expects::kColumn;
      return;
    case Expects::kColumn:
      column_ = std::min<std::size_t>(byte - kPlaceOffset, cells_[0].size() - 1);
      expects_ = Expects::kText;
      return;
    case Expects::kText:
      break;
  }
  switch (byte) {
    case 27:
      expects_ = Expects::kLetter;
      break;
    case '\r':
      column_ = 0;
      break;
    case '\n':
      row_ = std::min(row_ + 1, cells_.size() - 1);
      break;
    case '\b':
      column_ -= column_ > 0 ? 1 : 0;
      break;
    case '\t':
      column_ = std::min((column_ / 8 + 1) * 8, cells_[0].size() - 1);
      break;
    default:
      if (byte >= ' ') put(static_cast<char>(byte));
  }
}

void TerminalProgram::on_escape(unsigned char byte) {
  expects_ = byte == 'Y' ? Expects::kRow : Expects::kText;
  switch (byte) {
    case 'A':
      row_ -= row_ > 0 ? 1 : 0;
      break;
    case 'B':
      row_ = std::min(row_ + 1, cells_.size() - 1);
      break;
    case 'C':
      column_ = std::min(column_ + 1, cells_[0].size() - 1);
      break;
    case 'D':
      column_ -= column_ > 0 ? 1 : 0;
      break;
    case 'H':
      row_ = column_ = 0;
      break;
    case 'J':
      clear_from(row_, column_, true);
      break;
    case 'K':
      clear_from(row_, column_, false);
      break;
    default:
      break;
  }
}

void TerminalProgram::put(char c) {
  cells_[row_][column_] = c;
  column_ = std::min(column_ + 1, cells_[0].size() - 1);
}

void TerminalProgram::clear_from(std::size_t row, std::size_t column, bool to_the_end) {
  std::fill(cells_[row].begin() + static_cast<std::ptrdiff_t>(column), cells_[row].end(), ' ');
  for (std::size_t i = row + 1; to_the_end && i < cells_.size(); ++i) {
    cells_[i].assign(cells_[i].size(), ' ');
  }
}

}  // namespace cas::test
