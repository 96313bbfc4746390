// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_simulator.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/earth/frames.hpp"
#include "casd/packet/packet_info.hpp"
#include "hils/virtual/flight_ledger.hpp"
#include "libsim/hilsim/sim_report.hpp"
#include "mavlink/common/table.hpp"

namespace cas::hils {

VirtualWire::VirtualWire(sim::TopicBus& bus, const std::string& name, sim::VehicleId id,
                         OnBytes on_bytes)
    : id_(id),
      wire_in_(bus.advertise<sim::WirePacket>(name + "/wire_in")),
      wire_out_(bus.subscribe<sim::WirePacket>(
          name + "/wire_out", [this](const sim::WirePacket& packet) { on_wire_out(packet); })),
      on_bytes_(std::move(on_bytes)),
      sent_(mavlink::common::table()),
      received_(mavlink::common::table()),
      ledger_(kLedgerEntries) {}

void VirtualWire::write(std::span<const std::uint8_t> bytes, base::RunTime now) {
  received_.feed(bytes, [&](const mav::PacketView& view) {
    if (const auto stamp = casd::hil_time_usec(view))
      ledger_.received(view.message_id, *stamp, now);
    Arrival arrival{.at = now, .packet = {}};
    arrival.packet.size = view.bytes.size();
    std::ranges::copy(view.bytes, arrival.packet.bytes.begin());
    arrived_.push_back(arrival);
  });
}

void VirtualWire::start(const sim::World& world) { start_W_ = world.state(id_).p_WB; }

void VirtualWire::deliver(base::RunTime arrived_by, base::RunTime now) {
  now_ = now;
  while (!arrived_.empty() && arrived_.front().at <= arrived_by) {
    wire_in_.publish(arrived_.front().packet);
    arrived_.pop_front();
  }
}

Motion VirtualWire::motion(const sim::World& world) const {
  const sim::BodyState& state = world.state(id_);
  const Eigen::Vector3d p_W = state.p_WB - start_W_;
  return {.p_m = {p_W.y(), p_W.x(), p_W.z()},
          .v_m_s = {state.v_WB.y(), state.v_WB.x(), state.v_WB.z()},
          .rpy_rad = base::euler_rpy(base::q_ND_from_q_WB(state.q_WB))};
}

void VirtualWire::on_wire_out(const sim::WirePacket& packet) {
  const std::span bytes = std::span(packet.bytes).first(packet.size);
  sent_.feed(bytes, [this](const mav::PacketView& view) {
    if (const auto stamp = casd::hil_time_usec(view)) ledger_.sent(view.message_id, *stamp, now_);
  });
  on_bytes_(bytes, now_);
}

VirtualSimulator::VirtualSimulator(sim::SimConfig config, sim::SimOptions options,
                                   std::vector<OnBytes> on_bytes)
    : runner_(std::move(config), std::move(options)) {
  const std::vector<std::string> names = runner_.vehicle_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    wires_.push_back(std::make_unique<VirtualWire>(
        runner_.bus(), names[i], static_cast<sim::VehicleId>(i), std::move(on_bytes.at(i))));
  }
  runner_.start();
  for (const auto& wire : wires_) wire->start(runner_.world());
}

void VirtualSimulator::step(base::RunTime now) {
  for (const auto& wire : wires_) wire->deliver(now - runner_.step_size(), now);
  runner_.step();
}

base::RunTime VirtualSimulator::next_event() const {
  return base::RunTime((runner_.time() + runner_.step_size()).time_since_epoch());
}

std::string VirtualSimulator::stats_json() const {
  const nlohmann::json stats{{"schema", 1},
                             {"program", "hilsim"},
                             {"time_s", base::to_seconds(runner_.time())},
                             {"steps", runner_.steps()},
                             {"plugins", sim::plugin_figures(runner_)},
                             {"warnings", sim::warnings_report(runner_)}};
  return stats.dump(2) + "\n";
}

}  // namespace cas::hils
