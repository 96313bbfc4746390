// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "fcu/line_config.hpp"
#include "hils/run_request.hpp"

namespace cas::hils {

/// Where the pieces of one run are.
struct RunPlaces {
  std::filesystem::path out;         ///< results: truth.csv, flight.tlog, summary.json
  std::filesystem::path run;         ///< effective configurations, ledgers, figures, program output
  std::filesystem::path sockets;     ///< short-lived: control sockets, the PTY's link
  std::uint16_t simulator_port = 0;  ///< hilsim's end of link "sim"
  std::uint16_t casd_port = 0;       ///< casd's end of link "sim"
  std::uint16_t ground_station_port = 0;  ///< where casd's link "gcs" sends; 0: no such link

  std::filesystem::path simulator_config() const { return run / "hilsim.yaml"; }
  std::filesystem::path casd_config() const { return run / "casd.yaml"; }
  std::filesystem::path fcu_config() const { return run / "fcu.yaml"; }
  std::filesystem::path simulator_ledger() const { return run / "simulator_ledger.csv"; }
  std::filesystem::path controller_ledger() const { return run / "controller_ledger.csv"; }
  std::filesystem::path casd_stats() const { return run / "casd_stats.json"; }
  std::filesystem::path simulator_stats() const { return run / "hilsim_stats.json"; }
  std::filesystem::path casd_ledger() const { return run / "casd_ledger.csv"; }
  std::filesystem::path truth_csv() const { return out / "truth.csv"; }
  std::filesystem::path flight_tlog() const { return out / "flight.tlog"; }
  std::filesystem::path fcu_link() const { return sockets / "fcu0"; }
  std::filesystem::path simulator_control() const { return sockets / "hilsim"; }
  std::filesystem::path fcu_control() const { return sockets / "fcu"; }
  std::filesystem::path command_port() const { return sockets / "casd"; }
};

/// How the simulator's interface plugin hands over its packets.
enum class Transport { kUdp, kBus };

/// The configuration of hilsim for a run, as YAML text.
std::string simulator_config(const RunRequest& request, Transport transport,
                             const RunPlaces& places);
/// The configuration of fcu_emulator (and of the controller on the virtual clock), as YAML text.
std::string fcu_config(const RunRequest& request);
/// The topology of casd, as YAML text.
std::string casd_config(const RunRequest& request, const RunPlaces& places);
/// The serial line of a run: the scenario's with the request's preset; ideal without a line.
fcu::LineConfig line_of(const RunRequest& request);
/// Writes the three into `places.run`. @throws base::ConfigError
void write_configs(const RunRequest& request, Transport transport, const RunPlaces& places);

/// Name of the one vehicle of a run, and the folder of its topics.
inline constexpr const char* kVehicleName = "iris0";

}  // namespace cas::hils
