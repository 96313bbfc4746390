// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/rpc/client.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/supervisor.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {

/// hilsim, casd and fcu_emulator as programs of their own, in real time, as on a bench. The
/// sockets have fixed ports, so that casd can be ended and started again under way.
class FlightFixture {
 public:
  /// @param more  further keys of casd's topology; $DIR is a temporary folder
  explicit FlightFixture(const std::string& more = "");

  /// Starts casd under its service's unit file.
  void start_casd();
  /// Talks to the casd that runs now: after a restart.
  void connect();
  void start_controller();
  void start_simulator();
  void start_vehicle();
  Supervisor& casd() { return *casd_; }
  ChildProcess& controller() { return *fcu_; }
  ChildProcess& simulator() { return *hilsim_; }
  const std::string& casd_status() const { return status_; }

  nlohmann::json call(const std::string& method,
                      const nlohmann::json& params = nlohmann::json::object());
  nlohmann::json state() { return call("vehicle.state"); }
  /// Repeats a command until the vehicle takes it: its estimate settles after the start.
  bool command(const std::string& method, const nlohmann::json& params = nlohmann::json::object());
  /// Takes off and waits until it hangs at that height.
  bool fly_to(double altitude_m);
  bool land();

  TemporaryFolder folder;

 private:
  std::filesystem::path topology_;
  std::unique_ptr<Supervisor> casd_;
  std::unique_ptr<ChildProcess> fcu_;
  std::unique_ptr<ChildProcess> hilsim_;
  std::optional<base::rpc::Client> client_;
  std::string status_;
};

}  // namespace cas::test
