// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// Parameters by name, in the order of their writing.
using WrittenParams = std::vector<std::pair<std::string, double>>;

/// Parameters that the setparam steps of a flight have written so far, each with its newest value.
WrittenParams written_params(std::span<const Stage> stages);

/// Takes the firmware of one vehicle through a reboot: its program ends, as with a power cycle, and
/// is started again where it keeps its parameters.
struct FirmwareReboot {
  std::function<void()> restart;             ///< ends the program, and starts it again
  std::function<base::SimTime()> look;       ///< at simulated time
  std::function<double()> heartbeats;        ///< heard of the vehicle so far
  std::function<void(base::Duration)> wait;  ///< notices programs that died
  /// The vehicle's present value; nullopt: it does not answer.
  std::function<std::optional<double>(const std::string&)> parameter;

  /// @param written  values that it must still have afterwards
  /// @param written_at  of the newest of them: it is given the time to store them
  /// @param patience  real time: until its HEARTBEAT comes, simulated time does not measure the
  ///                  firmware's boot
  /// @return why the reboot has failed
  std::optional<std::string> run(const WrittenParams& written, base::SimTime written_at,
                                 base::Duration patience) const;

 private:
  std::optional<std::string> wait_until_heard(base::RunTime deadline) const;
  std::optional<std::string> compare(const WrittenParams& written, base::RunTime deadline) const;
};

}  // namespace cas::hils
