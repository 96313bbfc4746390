// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/rpc/client.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {

/// hilsim, casd and fcu_emulator as processes in lockstep, with UDP and a pseudo-terminal between
/// them. Simulated time is stopped between two calls of run_until().
class LockstepFixture {
 public:
  /// @param vehicle  a shipped one, or the path of a vehicle file
  explicit LockstepFixture(std::uint64_t seed, const std::string& vehicle = "iris_paper");

  /// Runs to a simulated time. @return sim.status there
  base::rpc::Json run_until(double time_s);
  /// Asks casd for something that the vehicle acknowledges. Whatever the vehicle said before has
  /// reached casd by then.
  base::rpc::Json command(const std::string& method, const base::rpc::Json& params);
  /// Waits until casd has heard the vehicle, which has said a word by now.
  bool wait_heard();
  /// Ends the programs in the order of the stream. @return whether all ended well
  bool stop();

  std::string truth() const;
  /// The bytes of flight.tlog: all packets with their times, in the order of their arrival at casd.
  std::string recording() const;
  /// Bytes that each system (id) put on the wire.
  std::map<int, std::string> streams() const;
  std::string outputs() const;

 private:
  std::string write_simulator(std::uint64_t seed, const std::string& vehicle_file, int port,
                              int casd_port);
  std::string write_casd(int port, int casd_port);

  TemporaryFolder folder_;
  std::optional<ChildProcess> fcu_;
  std::optional<ChildProcess> casd_program_;
  std::optional<ChildProcess> hilsim_;
  std::optional<base::rpc::Client> simulator_;
  std::optional<base::rpc::Client> casd_;
};

}  // namespace cas::test
