// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/boards/board_list.hpp"
#include "hils/boards/board_lock.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// Choice of `--fcu` for one vehicle.
struct FcuChoice {
  std::size_t vehicle = 0;  ///< its place in the scenario
  std::string controller;   ///< a board's name, or the path of a serial port
};

/// Reads the words behind `--fcu`: one CONTROLLER where one vehicle flies, VEHICLE=CONTROLLER for
/// each of several; those that are left out have the emulator. Pure. @throws base::ConfigError
std::vector<FcuChoice> parse_fcu_words(const std::vector<std::string>& words,
                                       const VehicleNames& vehicles);

/// Whether a controller's word is a board's name: it has no slash, and the list knows it. Pure.
/// @throws base::ConfigError for a word that is neither that nor a path, where there is a list
bool is_board(const std::string& controller, const BoardList* list, bool is_path);

/// A vehicle whose board went away in a flight that did not pass has failed, whatever else is
/// wrong: its packets are missing because of that, and no other try would say more. Pure.
/// @param gone  sentences by vehicle
void fail_absent(const std::map<std::size_t, std::string>& gone, RunResult& run);

/// The real controllers of one run: boards that it holds until it ends, and ports by their path.
class FlightBoards {
 public:
  /// Locks the boards, also those named by their port, in an order common to all runs, so that two
  /// runs do not deadlock.
  ///
  /// @param file  boards.yaml (find_board_list()); empty: there is none
  /// @param wait  longest wait for boards that others hold; nullopt: no wait
  /// @throws BoardError (kExitBoardBusy), base::ConfigError
  FlightBoards(const std::vector<FcuChoice>& choices, const std::filesystem::path& file,
               const std::string& purpose, std::optional<base::Duration> wait);

  FlightBoards(const FlightBoards&) = delete;
  FlightBoards& operator=(const FlightBoards&) = delete;

  /// Where a vehicle's controller is at this moment, whatever it does.
  /// @throws BoardError (kExitBoardAbsent)
  FcuDevice device(std::size_t vehicle, std::optional<unsigned> baud) const;

  /// Restarts each controller before another flight. @throws BoardError, RunStopped
  void restart(const std::filesystem::path& logs, std::optional<unsigned> baud) const;

  /// Waits until each board has booted the firmware that is expected, and notes in
  /// `out`/boards.json which boards these are.
  /// @return the controllers, by vehicle @throws BoardError, RunStopped, base::ConfigError
  std::map<std::size_t, FcuDevice> prepare(const std::filesystem::path& out,
                                           const VehicleNames& vehicles,
                                           std::optional<unsigned> baud) const;

  /// Fetches the newest log of each board whose `log` says so into `out`: board.ulg or, of several
  /// vehicles, VEHICLE/board.ulg. Prints the result on standard error.
  /// @throws RunStopped when the user interrupts
  void fetch_logs(const std::filesystem::path& out, const VehicleNames& vehicles) const;
  /// Longest time that it may take.
  base::Duration log_time() const;

  /// A sentence on a port, given by its path, that is not there; nullopt: all are.
  std::optional<std::string> missing_port() const;
  /// A sentence for each board that is gone, after a flight; by vehicle.
  std::map<std::size_t, std::string> absences() const;

 private:
  /// The board of the list whose port that is; nullptr: none.
  const Board* board_at(const std::filesystem::path& port) const;

  std::optional<BoardList> list_;
  std::map<std::size_t, const Board*> boards_;
  std::map<std::size_t, std::string> ports_;
  std::vector<BoardLock> locks_;
};

}  // namespace cas::hils
