// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual_simulator.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/frames.hpp"
#include "casd/hil_stamp.hpp"
#include "mavlink/common/table.hpp"

namespace cas::hils {

namespace {

constexpr std::size_t kLedgerEntries = 1 << 17;  ///< about two minutes of flight
constexpr sim::VehicleId kVehicle{0};

}  // namespace

VirtualSimulator::VirtualSimulator(sim::SimConfig config, sim::SimOptions options,
                                   const std::string& vehicle, OnBytes on_bytes)
    : runner_(std::move(config), std::move(options)),
      wire_in_(runner_.bus().advertise<sim::WirePacket>(vehicle + "/wire_in")),
      wire_out_(runner_.bus().subscribe<sim::WirePacket>(
          vehicle + "/wire_out", [this](const sim::WirePacket& packet) { on_wire_out(packet); })),
      on_bytes_(std::move(on_bytes)),
      sent_(mavlink::common::table()),
      received_(mavlink::common::table()),
      ledger_(kLedgerEntries) {
  runner_.start();
  start_W_ = runner_.world().state(kVehicle).p_WB;
}

void VirtualSimulator::write(std::span<const std::uint8_t> bytes, base::RunTime now) {
  received_.feed(bytes, [&](const mav::PacketView& view) {
    if (const auto stamp = casd::hil_time_usec(view))
      ledger_.received(view.message_id, *stamp, now);
    Arrival arrival{.at = now, .packet = {}};
    arrival.packet.size = view.bytes.size();
    std::ranges::copy(view.bytes, arrival.packet.bytes.begin());
    arrived_.push_back(arrival);
  });
}

void VirtualSimulator::step(base::RunTime now) {
  now_ = now;
  while (!arrived_.empty() && arrived_.front().at <= now - runner_.step_size()) {
    wire_in_.publish(arrived_.front().packet);
    arrived_.pop_front();
  }
  runner_.step();
}

void VirtualSimulator::set_flight_phase(std::string_view name) {
  if (name == phase_) return;
  phase_ = name;
  runner_.set_flight_phase(name);
}

base::RunTime VirtualSimulator::next_event() const {
  return base::RunTime((runner_.time() + runner_.step_size()).time_since_epoch());
}

std::string VirtualSimulator::stats_json() const {
  using Json = nlohmann::json;
  Json plugins = Json::object();
  for (const sim::PluginFigures& figures : runner_.plugin_figures()) {
    plugins[figures.name] = Json::parse(figures.json, nullptr, false);
  }
  const Json stats{{"schema", 1},
                   {"program", "hilsim"},
                   {"time_s", base::to_seconds(runner_.time())},
                   {"steps", runner_.steps()},
                   {"plugins", std::move(plugins)}};
  return stats.dump(2) + "\n";
}

Motion VirtualSimulator::motion() const {
  const sim::BodyState& state = runner_.world().state(kVehicle);
  const Eigen::Vector3d p_W = state.p_WB - start_W_;
  return {.p_m = {p_W.y(), p_W.x(), p_W.z()},
          .v_m_s = {state.v_WB.y(), state.v_WB.x(), state.v_WB.z()},
          .rpy_rad = base::euler_rpy(base::q_ND_from_q_WB(state.q_WB))};
}

void VirtualSimulator::on_wire_out(const sim::WirePacket& packet) {
  const std::span bytes = std::span(packet.bytes).first(packet.size);
  sent_.feed(bytes, [this](const mav::PacketView& view) {
    if (const auto stamp = casd::hil_time_usec(view)) ledger_.sent(view.message_id, *stamp, now_);
  });
  on_bytes_(bytes, now_);
}

}  // namespace cas::hils
