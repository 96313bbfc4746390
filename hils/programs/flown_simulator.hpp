// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "hils/flight/flight_facts.hpp"

namespace cas::hils {

/// hilsim during a flight, by its control socket: asks where the vehicles are, and tells the phase.
/// The runs in real time and in lockstep fly with it.
class FlownSimulator {
 public:
  /// @param control  its socket. @throws base::rpc::ConnectionError
  explicit FlownSimulator(const std::filesystem::path& control);

  /// Asks for its status. @return simulated time
  base::SimTime look();
  /// In lockstep: lets it run until then. @return simulated time
  base::SimTime run_until(base::SimTime time);

  struct Status {
    base::SimTime time{};
    double real_time_factor = 0;
    std::uint64_t late_steps = 0;
    std::uint64_t lockstep_timeouts = 0;  ///< sensor messages without the control that was due
    bool paused = false;
    std::vector<Motion> truth;  ///< of the vehicles, from where they stood at first
  };
  /// By its newest answer.
  const Status& status() const { return status_; }
  /// Where the vehicles stood at first: north, east, up.
  const std::vector<Eigen::Vector3d>& start_m() const { return start_m_; }

  /// For conditions of its fault scripts.
  void tell_phase(std::string_view phase);
  /// For other calls.
  base::rpc::Client& client() { return client_; }

 private:
  base::SimTime take(const nlohmann::json& status);

  base::rpc::Client client_;
  Status status_;
  std::vector<Eigen::Vector3d> start_m_;
};

}  // namespace cas::hils
