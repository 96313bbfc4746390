// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/os/result_file.hpp"
#include "hils/programs/child_process.hpp"
#include "hils/sweep/row_flight.hpp"

namespace cas::hils {

/// Flies tasks, each in a process of its own, several at once. A run that dies or hangs costs its
/// own result. For one thread.
class FlightPool {
 public:
  /// @param folder      for the files of runs under way; made here, and gone with the object
  /// @param deadline_s  wall-clock time after which a run has hung
  /// @param flown_by    words of this program that fly the task of a folder, which comes last
  FlightPool(const base::ResultPlace& folder, double deadline_s,
             std::vector<std::string> flown_by = {"sweep", "fly"});
  /// Ends the flights under way.
  ~FlightPool();
  FlightPool(const FlightPool&) = delete;
  FlightPool& operator=(const FlightPool&) = delete;

  /// @throws base::ConfigError when the process cannot be started
  void start(const RowTask& task);
  std::size_t size() const { return flights_.size(); }
  /// Until a run has ended, the next deadline may be over, or there is something to read.
  /// @param input  descriptor; -1: none @return whether it has something, or has ended
  bool wait(int input = -1) const;
  /// Hands over the result of each run that has ended or hung; its row is the task's.
  /// @throws base::ConfigError when the machine let a run down (a full disk), RunStopped when one
  /// was interrupted, BoardError when a board stopped it
  void take_ended(const std::function<void(RowResult&&)>& take);

 private:
  struct Flight {
    std::size_t row;
    std::filesystem::path folder;
    std::unique_ptr<ChildProcess> process;
  };
  RowResult result_of(const Flight& flight, const ExitStatus& end) const;
  static std::optional<RowResult> written_result(const Flight& flight);

  static void clear(const base::ResultPlace& folder);

  base::ResultPlace place_;
  double deadline_s_;
  std::vector<std::string> flown_by_;
  std::string host_;
  std::list<Flight> flights_;
};

/// Notes SIGINT and SIGTERM while it lives, so that sweeps and tuning can end in good order.
class StopRequest {
 public:
  StopRequest();
  ~StopRequest();
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;
  static bool raised();

 private:
  struct Actions;
  std::unique_ptr<Actions> before_;
};

}  // namespace cas::hils
