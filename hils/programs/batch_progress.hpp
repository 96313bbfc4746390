// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace cas::hils {

/// "compare: 3 of 20, 0:12, about 1:08 left": runs done, of all, time passed and left. The time
/// left appears once a twentieth is done.
inline std::string batch_line(std::string_view name, std::size_t done, std::size_t all,
                              std::chrono::seconds elapsed) {
  const auto clock = [](long seconds) {
    return fmt::format("{}:{:02}", seconds / 60, seconds % 60);
  };
  std::string line = fmt::format("{}: {} of {}, {}", name, done, all, clock(elapsed.count()));
  if (done > 0 && done < all && done * 20 >= all) {
    const auto left = static_cast<long>(all - done) * elapsed.count() / static_cast<long>(done);
    line += ", about " + clock(left) + " left";
  }
  return line;
}

/// Progress of many pieces of work on standard error: one line that is rewritten on a terminal;
/// elsewhere a line for each tenth, once the work has gone on for two seconds.
class BatchProgress {
 public:
  BatchProgress(std::string name, std::size_t all) : name_(std::move(name)), all_(all) {}
  ~BatchProgress() { clear(); }
  BatchProgress(const BatchProgress&) = delete;
  BatchProgress& operator=(const BatchProgress&) = delete;

  /// So many of them are done now.
  void show(std::size_t done) {
    const auto elapsed = std::chrono::duration_cast<std::chrono::seconds>(Clock::now() - begin_);
    if (terminal_) {
      std::fprintf(stderr, "\r\x1b[K%s", batch_line(name_, done, all_, elapsed).c_str());
      std::fflush(stderr);
      drawn_ = true;
      return;
    }
    const std::size_t tenth = all_ > 0 ? done * 10 / all_ : 0;
    if (elapsed < kQuiet || tenth == tenth_) return;
    tenth_ = tenth;
    std::fprintf(stderr, "%s\n", batch_line(name_, done, all_, elapsed).c_str());
  }
  /// Takes the line away.
  void clear() {
    if (drawn_) std::fprintf(stderr, "\r\x1b[K");
    drawn_ = false;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kQuiet{2};

  std::string name_;
  std::size_t all_;
  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  bool drawn_ = false;
  std::optional<std::size_t> tenth_;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace cas::hils
