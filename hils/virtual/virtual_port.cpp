// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_port.hpp"

#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/rpc/server.hpp"
#include "casd/port/call_json.hpp"
#include "casd/port/vehicle_methods.hpp"

namespace cas::hils {

struct VirtualPort::Methods {
  Methods(casd::VehicleCommander& commander, casd::GainMap gains,
          std::function<base::RunTime()> now)
      : vehicles(server, commander, std::move(gains),
                 {.now = std::move(now),
                  .link_name = [](casd::LinkId link) { return std::to_string(link); },
                  .audit = {}}) {}

  boost::asio::io_context io;  ///< never runs
  base::rpc::Server server{io};
  casd::VehicleMethods vehicles;
};

VirtualPort::VirtualPort(casd::VehicleCommander& commander, casd::GainMap gains,
                         std::function<base::RunTime()> now)
    : commander_(commander),
      methods_(std::make_unique<Methods>(commander, std::move(gains), std::move(now))) {}

VirtualPort::~VirtualPort() = default;

VehicleReport VirtualPort::report(std::uint8_t system) const {
  VehicleReport report;
  const casd::VehicleState* state = commander_.find(system);
  if (state == nullptr) return report;
  report.heard = true;
  report.type = casd::type_word(state->type());
  report.vtol = state->vtol_word();
  report.armed = state->armed();
  report.in_air = state->landed_word() == "in_air";
  report.on_ground = state->landed_word() == "on_ground";
  if (const auto& position = state->local_position()) {
    const auto& message = position->message;
    report.has_position = true;
    report.p_N = {message.x, message.y, message.z};
    report.v_N = {message.vx, message.vy, message.vz};
  }
  if (const auto& attitude = state->attitude()) {
    report.roll_rad = attitude->message.roll;
    report.pitch_rad = attitude->message.pitch;
    report.yaw_rad = attitude->message.yaw;
  }
  return report;
}

void VirtualPort::give(const FlightStep& step, std::uint8_t system, const Done& done) {
  call(step_calls(step, false, system), 0, done);
}

/// One after the other; the first refusal ends it.
void VirtualPort::call(const std::vector<CasdCall>& calls, std::size_t first, const Done& done) {
  if (first == calls.size()) return done(std::nullopt);
  const auto& [method, params] = calls[first];
  methods_->server.call(
      method, params,
      {.result = [this, calls, done, first](auto&&) { call(calls, first + 1, done); },
       .error = [done](int, const std::string& message, auto&&) { done(Refusal{message}); },
       .client = "hils"});
}

}  // namespace cas::hils
