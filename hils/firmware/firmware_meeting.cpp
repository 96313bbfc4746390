// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_meeting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "base/config/vehicle.hpp"
#include "hils/firmware/first_sign.hpp"
#include "hils/flight/flight_plan.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {
namespace {

using base::rpc::Json;

/// All in real time.
constexpr base::Duration kVersionPatience = std::chrono::seconds(20);
/// A firmware that has neither connected nor sent a byte nor printed one for so long will not come.
/// PX4 and ArduCopter connect within 2 s.
constexpr base::Duration kFirstSignPatience = std::chrono::seconds(20);
/// For all parameters of a firmware. casd ends a list 10 s after the last new parameter.
constexpr base::Duration kParamPatience = std::chrono::minutes(20);
/// Lines of a firmware's output that an error quotes.
constexpr std::size_t kTailLines = 8;
constexpr base::Duration kAskAgain = std::chrono::seconds(3);

class FirmwareMeeting {
 public:
  FirmwareMeeting(FlightDeck& deck, std::size_t vehicle, AskedVehicle asked, RunRecord& record)
      : deck_(deck), vehicle_(vehicle), asked_(asked), record_(record) {}

  /// In real time: until the firmware is there, the simulator's time runs at its own speed and says
  /// nothing of how long the firmware takes.
  void wait_for_heartbeat() {
    const base::RunTime begin = base::steady_now();
    const base::Duration patience = deck_.scenario.steps.front().timeout;
    std::uintmax_t output = 0;
    base::RunTime spoke = begin;  // on a busy machine a start script takes long, and says so
    VehicleReport vehicle;
    while (!(vehicle = vehicle_report(deck_.casd, asked_)).heard) {
      if (const auto end = deck_.bench.own_end(vehicle_, kTailLines)) {
        const std::string& hint = deck_.scenario.firmware->hint;
        throw RunStopped(*end + (hint.empty() ? "" : "\n" + hint), false);
      }
      const base::RunTime now = base::steady_now();
      if (const auto bytes = deck_.bench.output_bytes(vehicle_); bytes != output) {
        output = bytes;
        spoke = now;
      }
      if (now - begin > patience || now - spoke > kFirstSignPatience) {
        check_first_sign(now - begin, now - begin > patience);
      }
      deck_.supervisor.wait(FlightPlan::kLookPeriod);
    }
    const bool has_wing =
        base::Vehicle::load(deck_.scenario.vehicles.at(vehicle_).vehicle).aero.has_value();
    if (const auto why = mismatch(vehicle, deck_.scenario.firmware->autopilot, has_wing)) {
      throw RunStopped(*why, false);
    }
    record_.system = call("vehicle.state").value("system", record_.system);
  }

  /// Waits until the firmware reports the version that the scenario wants, and repeats the request:
  /// casd's own, upon the first HEARTBEAT, may have come too early.
  std::optional<std::string> check_version() {
    const Firmware& firmware = *deck_.scenario.firmware;
    const bool wanted = !firmware.least_version.empty();
    const base::RunTime deadline = base::steady_now() + kVersionPatience;
    for (base::RunTime ask_at = base::steady_now() + kAskAgain;;) {
      record_.firmware->version = vehicle_report(deck_.casd, asked_).firmware;
      if (!wanted || !record_.firmware->version.empty() || base::steady_now() > deadline) break;
      if (base::steady_now() > ask_at) {
        ask_for_version();
        ask_at = base::steady_now() + kAskAgain;
      }
      deck_.supervisor.wait(FlightPlan::kLookPeriod);
    }
    if (wanted && is_of_a_tree_without_tags(record_.firmware->version)) {
      record_.firmware->remarks.push_back(fmt::format(
          "the firmware says v{}, as a tree cloned without tags does: firmware.least_version ({}) "
          "was not checked",
          record_.firmware->version, firmware.least_version));
    }
    return version_fault(firmware, record_.firmware->version);
  }

  /// Before the first step: an autopilot counts flights and hours in its parameters later.
  void read_params() {
    try {
      const Json answer = call("param.list", Json::object(), kParamPatience);
      record_.firmware->params = digest_of(answer.at("parameters"));
    } catch (const base::rpc::CallError& error) {
      record_.firmware->remarks.push_back(std::string("the firmware's parameters were not read: ") +
                                          error.what());
    }
  }

 private:
  template <class... Patience>
  Json call(const std::string& method, const Json& params = Json::object(), Patience... patience) {
    return deck_.casd.call(method, about(asked_, params), patience...);
  }

  /// A firmware of which nothing at all has come is not waited for any longer.
  void check_first_sign(base::Duration waited, bool too_long) {
    const Scenario& scenario = deck_.scenario;
    const FirstSign sign =
        first_sign(deck_.simulator.client().call("sim.stats", Json::object()),
                   deck_.casd.call("link.list", Json::object()), scenario.vehicles[vehicle_].name,
                   scenario.firmware->on_serial_line);
    if (sign.anything && !too_long) return;
    const std::string which =
        asked_ ? fmt::format(" of the vehicle with system id {}", *asked_) : "";
    const std::string said =
        deck_.bench.is_board()
            ? ""
            : fmt::format("; its last lines (run/firmware{}.log):{}", scenario.suffix_of(vehicle_),
                          deck_.bench.last_lines(vehicle_));
    throw RunStopped(fmt::format("the firmware{} was not heard within {:.0f} s of real time: {}{}",
                                 which, base::to_seconds(waited), sign.words, said),
                     false);
  }

  /// A refusal means that it has none to tell, or not yet.
  void ask_for_version() {
    try {
      call("vehicle.command",
           {{"command", static_cast<int>(mavlink::common::MavCmd::kRequestMessage)},
            {"params", {mavlink::common::AutopilotVersion::kId}}});
    } catch (const base::rpc::CallError&) {
    }
  }

  FlightDeck& deck_;
  std::size_t vehicle_;
  AskedVehicle asked_;
  RunRecord& record_;
};

}  // namespace

std::optional<std::string> version_fault(const Firmware& wanted, const std::string& version) {
  if (wanted.least_version.empty()) return std::nullopt;
  if (version.empty()) {
    return fmt::format(
        "the firmware did not tell its version within {:.0f} s, and firmware.least_version is {}",
        base::to_seconds(kVersionPatience), wanted.least_version);
  }
  if (is_of_a_tree_without_tags(version)) return std::nullopt;
  if (is_at_least(version, wanted.least_version)) return std::nullopt;
  return fmt::format("the firmware is v{}, and firmware.least_version is {}", version,
                     wanted.least_version);
}

std::optional<std::string> meet_firmware(FlightDeck& deck, std::size_t vehicle, AskedVehicle asked,
                                         RunRecord& record) {
  FirmwareMeeting meeting(deck, vehicle, asked, record);
  meeting.wait_for_heartbeat();
  if (auto fault = meeting.check_version()) return fault;
  meeting.read_params();
  return std::nullopt;
}

}  // namespace cas::hils
