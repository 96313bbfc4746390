// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/figures/flight_batch.hpp"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/os/descriptor.hpp"
#include "hils/programs/batch_progress.hpp"

namespace cas::hils {

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

/// @return false when not all of it could be written
bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// @return false when the other end closed before that
bool read_all(int fd, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::read(fd, bytes.data(), bytes.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

/// The child's part: every `batch.jobs`-th flight from `first` on. @return its exit code
int fly_share(const FlightBatch& batch, int first, const FlyInto& fly, std::size_t result_bytes,
              int out) {
  std::vector<std::byte> result(result_bytes);
  for (int i = first; i < batch.flights; i += batch.jobs) {
    const std::uint64_t seed = batch.first_seed + static_cast<std::uint64_t>(i);
    try {
      fly(seed, result);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "flight_figures: seed %llu: %s\n", static_cast<unsigned long long>(seed),
                   error.what());
      return 1;
    }
    if (!write_all(out, result)) return 1;
  }
  return 0;
}

/// One process that flies a share of the batch.
class Job {
 public:
  Job(const FlightBatch& batch, int first, const FlyInto& fly, std::size_t result_bytes) {
    int ends[2];
    if (::pipe(ends) != 0) fail("cannot make a pipe for flights");
    results_ = base::Descriptor(ends[0]);
    const base::Descriptor out(ends[1]);
    pid_ = ::fork();
    if (pid_ < 0) fail("cannot start a process for flights");
    if (pid_ == 0) ::_exit(fly_share(batch, first, fly, result_bytes, out.get()));
  }
  /// Ends the process unless wait() was called.
  ~Job() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Job(Job&& other) noexcept
      : results_(std::move(other.results_)), pid_(std::exchange(other.pid_, -1)) {}
  Job& operator=(Job&&) = delete;

  /// The next result of its share. @return false when there is none
  bool read(std::span<std::byte> result) { return read_all(results_.get(), result); }

  /// Waits for its end. @return how it failed, in words; nullopt if it ended with exit code 0
  std::optional<std::string> wait() {
    int status = 0;
    const pid_t waited = ::waitpid(std::exchange(pid_, -1), &status, 0);
    if (waited < 0) return std::string("was lost: ") + std::strerror(errno);
    if (WIFSIGNALED(status)) {
      return "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" +
             ::strsignal(WTERMSIG(status)) + ")";
    }
    const int code = WEXITSTATUS(status);
    if (code == 0) return std::nullopt;
    return "ended with exit code " + std::to_string(code);
  }

 private:
  base::Descriptor results_;
  pid_t pid_ = -1;
};

}  // namespace

void fly_in_processes(const FlightBatch& batch, const FlyInto& fly, std::span<std::byte> results) {
  const std::size_t result_bytes = results.size() / static_cast<std::size_t>(batch.flights);
  std::vector<Job> jobs;
  jobs.reserve(static_cast<std::size_t>(batch.jobs));
  for (int first = 0; first < batch.jobs; ++first) {
    jobs.emplace_back(batch, first, fly, result_bytes);
  }
  BatchProgress progress("flights", static_cast<std::size_t>(batch.flights));
  for (int i = 0; i < batch.flights; ++i) {
    progress.show(static_cast<std::size_t>(i));
    Job& job = jobs[static_cast<std::size_t>(i % batch.jobs)];
    if (job.read(results.subspan(static_cast<std::size_t>(i) * result_bytes, result_bytes))) {
      continue;
    }
    const std::string end = job.wait().value_or("ended too early");
    throw std::runtime_error("the flight with seed " +
                             std::to_string(batch.first_seed + static_cast<std::uint64_t>(i)) +
                             " has no result: its process " + end);
  }
  for (std::size_t first = 0; first < jobs.size(); ++first) {
    const auto end = jobs[first].wait();
    if (!end) continue;
    throw std::runtime_error("the process of the flights from seed " +
                             std::to_string(batch.first_seed + first) + " on " + *end);
  }
}

}  // namespace cas::hils
