// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hils/run/scratch_folder.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// A private folder with a short path, for sockets and the PTY's link, and the place of casd's
/// socket; removed at the end.
class RunDirectory {
 public:
  /// Below XDG_RUNTIME_DIR, else below the temporary folder. @throws base::ConfigError
  RunDirectory();
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;
  const std::filesystem::path& path() const { return folder_.path(); }
  /// Path of the Unix socket of the run's casd: in the user's runtime folder, where casctl looks
  /// for it; in this one if there is no such folder or its path is too long for a socket.
  const std::filesystem::path& command_socket() const { return command_socket_; }

 private:
  ScratchFolder folder_;
  std::filesystem::path command_socket_;
};

/// UDP ports of 127.0.0.1 that are free now, all different. @throws base::ConfigError
std::vector<std::uint16_t> free_udp_ports(std::size_t count);

/// Paths and names of the parts of one vehicle of a run. With several vehicles the names of files
/// bear the vehicle's and those of links its number.
struct VehiclePaths {
  std::filesystem::path out;            ///< results: truth.csv, sensors/, flight.ulg
  std::filesystem::path run;            ///< effective configuration, ledgers
  std::filesystem::path sockets;        ///< short-lived: control socket, the PTY's link
  std::string suffix{};                 ///< behind the names of files: "_NAME"
  std::string tty = "fcu0";             ///< the PTY's link
  std::string simulator_link = "sim";   ///< casd's link to the simulator
  std::string controller_link = "fcu";  ///< casd's link to the controller
  std::uint16_t simulator_port = 0;     ///< hilsim's end of the simulator's link
  std::uint16_t casd_port = 0;          ///< casd's end of it

  std::string emulator() const { return "fcu_emulator" + suffix; }
  std::filesystem::path fcu_config() const { return run / ("fcu" + suffix + ".yaml"); }
  std::filesystem::path simulator_ledger() const { return csv("simulator_ledger"); }
  std::filesystem::path controller_ledger() const { return csv("controller_ledger"); }
  std::filesystem::path clouds_csv() const { return csv("clouds"); }
  std::filesystem::path truth_csv() const { return out / ("truth" + suffix + ".csv"); }
  std::filesystem::path sensors() const { return out / ("sensors" + suffix); }
  std::filesystem::path flight_ulog() const { return out / ("flight" + suffix + ".ulg"); }
  std::filesystem::path fcu_link() const { return sockets / tty; }
  std::filesystem::path fcu_control() const { return sockets / ("fcu" + suffix); }

 private:
  std::filesystem::path csv(const char* name) const { return run / (name + suffix + ".csv"); }
};

/// Paths and ports of one run.
struct RunPaths {
  std::filesystem::path out;      ///< results: flight.tlog, summary.json
  std::filesystem::path run;      ///< effective configurations, ledgers, figures, program output
  std::filesystem::path sockets;  ///< short-lived: control sockets
  std::filesystem::path command_port{};     ///< casd's Unix socket
  std::uint16_t ground_station_port = 0;    ///< where casd's link "gcs" sends; 0: no such link
  std::vector<std::uint16_t> companions{};  ///< UDP ports of hils, for a link of casd each
  std::vector<VehiclePaths> vehicles;       ///< in the order of the scenario

  /// Paths below `out`; no port is chosen yet.
  static RunPaths of(const Scenario& scenario, const std::filesystem::path& out,
                     const std::filesystem::path& sockets);
  /// Gives each vehicle's link two ports that are free now. @throws base::ConfigError
  void choose_ports();

  std::filesystem::path simulator_config() const { return run / "hilsim.yaml"; }
  std::filesystem::path casd_config() const { return run / "casd.yaml"; }
  std::filesystem::path casd_stats() const { return run / "casd_stats.json"; }
  std::filesystem::path simulator_stats() const { return run / "hilsim_stats.json"; }
  std::filesystem::path casd_ledger() const { return run / "casd_ledger.csv"; }
  std::filesystem::path flight_tlog() const { return out / "flight.tlog"; }
  std::filesystem::path flight_mcap() const { return out / "flight.mcap"; }
  std::filesystem::path plugin_figures() const { return out / "plugin_figures.json"; }
  std::filesystem::path simulator_control() const { return sockets / "hilsim"; }
  std::filesystem::path run_port() const { return sockets / "hils"; }
  std::filesystem::path command_token() const { return sockets / "casd.token"; }
  /// The ends of the serial line of stock firmware.
  std::filesystem::path casd_tty() const { return sockets / "casd_tty"; }
  std::filesystem::path firmware_tty() const { return sockets / "firmware_tty"; }
  /// The line on which it takes its sensors from plugin external_ahrs.
  std::filesystem::path ahrs_tty() const { return sockets / "ahrs_tty"; }
  /// And that on which it takes fixes from plugin ubx.
  std::filesystem::path gps_tty() const { return sockets / "gps_tty"; }
};

}  // namespace cas::hils
