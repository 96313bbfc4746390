// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "casd/port/command_json.hpp"
#include "casd/port/command_params.hpp"
#include "casd/port/command_server.hpp"

namespace cas::casd {
namespace {

using base::RunTime;
using nlohmann::json;

json accepted(std::uint8_t system, const Outcome&) {
  return json{{"vehicle", system}, {"result", "ACCEPTED"}};
}

/// Period for SET_MESSAGE_INTERVAL: `hz` above 0, 0 for off, absent for the vehicle's default.
double period_us(CommandParams& params) {
  const std::optional<double> hz = params.optional_number("hz");
  if (!hz) return 0;
  if (*hz < 0 || *hz > 10000) throw BadParams("\"hz\" must be from 0 (off) to 10000");
  return *hz == 0 ? -1 : 1e6 / *hz;
}

/// Seven numbers; null stands for NaN.
std::array<float, 7> command_numbers(const json& list) {
  std::array<float, 7> numbers{};
  if (list.is_null()) return numbers;
  if (!list.is_array() || list.size() > numbers.size()) {
    throw BadParams("\"params\" must be a list of at most 7 numbers");
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].is_null()) {
      numbers[i] = std::numeric_limits<float>::quiet_NaN();
    } else if (list[i].is_number()) {
      numbers[i] = list[i].get<float>();
    } else {
      throw BadParams("\"params\" must hold numbers or null (NaN)");
    }
  }
  return numbers;
}

}  // namespace

void CommandServer::add_flight_methods() {
  add(
      "vehicle.arm", true,
      [this](CommandParams& params) -> Action {
        const VehicleCommander::ArmOptions options{.force = params.flag("force"),
                                                   .not_hil = params.flag("not_hil")};
        return [this, options](std::uint8_t system, RunTime now, Done done) {
          commander_.arm(system, options, now, std::move(done));
        };
      },
      accepted);
  add(
      "vehicle.disarm", true,
      [this](CommandParams& params) -> Action {
        return [this, force = params.flag("force")](std::uint8_t system, RunTime now, Done done) {
          commander_.disarm(system, force, now, std::move(done));
        };
      },
      accepted);
  add(
      "vehicle.takeoff", true,
      [this](CommandParams& params) -> Action {
        const double altitude_m = params.number("altitude_m");
        if (!(altitude_m > 0)) throw BadParams("\"altitude_m\" must be above 0");
        return [this, altitude_m](std::uint8_t system, RunTime now, Done done) {
          commander_.takeoff(system, altitude_m, now, std::move(done));
        };
      },
      accepted);
  const auto plain = [this](const std::string& name,
                            void (VehicleCommander::*verb)(std::uint8_t, RunTime, Done)) {
    add(
        name, true,
        [this, verb](CommandParams&) -> Action {
          return [this, verb](std::uint8_t system, RunTime now, Done done) {
            (commander_.*verb)(system, now, std::move(done));
          };
        },
        accepted);
  };
  plain("vehicle.land", &VehicleCommander::land);
  plain("vehicle.hold", &VehicleCommander::hold);
  plain("vehicle.rtl", &VehicleCommander::return_home);
  plain("vehicle.reboot", &VehicleCommander::reboot);
  add(
      "vehicle.goto", true,
      [this](CommandParams& params) -> Action {
        const VehicleCommander::Target target{params.number("north_m"), params.number("east_m"),
                                              params.number("down_m"),
                                              params.optional_number("yaw_deg")};
        return [this, target](std::uint8_t system, RunTime now, Done done) {
          commander_.go_to(system, target, now, std::move(done));
        };
      },
      accepted);
  add(
      "vehicle.mode", true,
      [this](CommandParams& params) -> Action {
        return [this, mode = params.text("mode")](std::uint8_t system, RunTime now, Done done) {
          commander_.set_mode(system, mode, now, std::move(done));
        };
      },
      accepted);
}

void CommandServer::add_raw_methods() {
  add(
      "vehicle.manual_control", true,
      [this](CommandParams& params) -> Action {
        const auto stick = [&params](const std::string& key, double low) {
          const double value = params.optional_number(key).value_or(0);
          if (!(value >= low && value <= 1)) {
            throw BadParams("\"" + key + "\" must be from " + (low < 0 ? "-1" : "0") + " to 1");
          }
          return value;
        };
        const VehicleCommander::Sticks sticks{
            .pitch = stick("pitch", -1),
            .roll = stick("roll", -1),
            .throttle = stick("throttle", 0),
            .yaw = stick("yaw", -1),
            .buttons = static_cast<std::uint16_t>(
                params.optional_integer("buttons", 0, 0xffff).value_or(0))};
        const bool not_hil = params.flag("not_hil");
        return [this, sticks, not_hil](std::uint8_t system, RunTime now, Done done) {
          commander_.manual_control(system, sticks, not_hil, now, std::move(done));
        };
      },
      [](std::uint8_t system, const Outcome&) {
        return json{{"vehicle", system}, {"result", "SENT"}};
      });
  add(
      "vehicle.message_interval", true,
      [this](CommandParams& params) -> Action {
        const std::uint32_t id = message_id(params.value("message"));
        return [this, id, period = period_us(params)](std::uint8_t system, RunTime now, Done done) {
          commander_.message_interval(system, id, period, now, std::move(done));
        };
      },
      accepted);
  add(
      "vehicle.command", true,
      [this](CommandParams& params) -> Action {
        VehicleCommand command;
        command.id = static_cast<mavlink::common::MavCmd>(params.integer("command", 0, 0xffff));
        command.params = command_numbers(params.value("params"));
        const bool not_hil = params.flag("not_hil");
        return [this, command, not_hil](std::uint8_t system, RunTime now, Done done) {
          commander_.command(system, command, not_hil, now, std::move(done));
        };
      },
      accepted);
}

}  // namespace cas::casd
