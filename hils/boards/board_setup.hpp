// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "casd/words/external_ahrs_params.hpp"
#include "hils/boards/board_list.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// A parameter that a set-up changes.
struct ParamChange {
  std::string name;
  double before = 0;
  double after = 0;
  std::string meaning{};

  bool operator==(const ParamChange&) const = default;
};

/// What setting up an ArduPilot for plugin external_ahrs changes; without those that it does not
/// show before External AHRS is on (EAHRS_TYPE). Pure.
/// @param port  serial port of the board with the sensors' line, from 0
/// @throws base::ConfigError for a parameter that the firmware does not have
std::vector<ParamChange> external_ahrs_changes(const casd::ParamValues& now, int port);

/// What gives back the parameters of a file of lines NAME VALUE, as `hils board setup` leaves it.
/// Pure. @param file  its name, for errors @throws base::ConfigError with file and line
std::vector<ParamChange> restoring_changes(std::string_view text, const std::string& file,
                                           const casd::ParamValues& now);

/// How `hils board setup` is asked.
struct BoardSetup {
  int port = -1;                    ///< of the sensors' line
  std::filesystem::path restore{};  ///< gives these back instead
  std::filesystem::path saved{};    ///< where the old values are written before any change
  bool writes = false;              ///< else the changes are only shown
};

/// Shows the changes, and makes them. @throws BoardError, RunStopped, base::ConfigError
void set_up_board(Supervisor& supervisor, const Board& board, const std::filesystem::path& by_id,
                  const BoardSetup& setup);

}  // namespace cas::hils
