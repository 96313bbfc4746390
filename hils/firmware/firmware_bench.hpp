// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hils/firmware/pty_cable.hpp"
#include "hils/programs/run_programs.hpp"

namespace cas::hils {

/// casd, hilsim and the firmware as programs, in this order, so that the firmware finds its peers;
/// of several vehicles each has a firmware of its own. On a board (RunRequest::fcu_devices) the
/// firmware runs already, and there is no program and no cable.
class FirmwareBench {
 public:
  /// @throws base::ConfigError if the firmware's program is not there, or may not be started
  FirmwareBench(const RunRequest& request, const RunPaths& paths);

  /// Empties the folder of each firmware in the results first: parameters that an earlier flight
  /// left there would be in force. A `cwd` of the scenario is left as it is.
  void start();
  /// The exit code of the firmware says nothing about the flight.
  void stop();

  /// What a reader of the verdict must know of the firmware's folders.
  const std::vector<std::string>& remarks() const { return remarks_; }
  /// How the firmware of a vehicle ended by itself, with its last lines; nullopt: it runs.
  std::optional<std::string> own_end(std::size_t vehicle, std::size_t lines);
  /// Size of its output so far: what grows is alive.
  std::uintmax_t output_bytes(std::size_t vehicle) const;
  /// The last lines of its output.
  std::string last_lines(std::size_t vehicle) const;

  /// Whether the firmware runs on a board.
  bool is_board() const { return is_board_; }
  /// Ends the firmware of one vehicle, and starts it again in its folder. Its log goes on. Not of a
  /// board.
  void reboot(std::size_t vehicle);

  /// Kills casd at once, as a fault of the scenario.
  void kill_casd() { programs_.kill_casd(); }
  void start_casd() { programs_.start_casd(); }
  /// The serial line of a firmware that has one, and runs as a program.
  PtyCable& cable() { return *cable_; }

  Supervisor& supervisor() { return supervisor_; }
  /// Bytes that the serial line lost because a program did not read them.
  std::uint64_t lost_bytes() const { return cable_ ? cable_->lost_bytes() : 0; }

 private:
  /// In HITL the machine must keep up with real time; in software time waits for the firmware.
  bool keeps_ledgers() const { return scenario_.firmware->on_serial_line; }
  ChildProcess::Options firmware_options(std::size_t instance) const;
  void check_program(const ChildProcess::Options& options) const;
  void prepare_folder(const std::filesystem::path& folder);

  const Scenario& scenario_;
  const RunPaths& paths_;
  Supervisor supervisor_;
  RunPrograms programs_;
  bool is_board_;
  std::optional<PtyCable> cable_;
  std::vector<ChildProcess::Options> firmware_options_;  ///< of each vehicle
  std::vector<ChildProcess*> firmware_;
  std::vector<std::string> remarks_;
};

}  // namespace cas::hils
