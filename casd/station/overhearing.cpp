// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/overhearing.hpp"

#include <fmt/format.h>
#include <optional>
#include <utility>

#include "casd/packet/intervention.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/address.hpp"

namespace cas::casd {
namespace {

void note(VehicleTable& table, KnownVehicle& vehicle, Intervention intervention) {
  Hands& hands = table.hands(vehicle.state.source().system);
  if (intervention.act.disarms) {
    ++hands.arm_requests;
    ++hands.disarms;
    vehicle.commands.on_disarm(fmt::format("{}/{}: {}", intervention.by.system,
                                           intervention.by.component, intervention.act.what),
                               intervention.at);
  }
  hands.interventions.add(std::move(intervention));
}

}  // namespace

void overhear(VehicleTable& table, mav::Source self, const Origin& from,
              const mav::PacketView& packet, base::RunTime now) {
  if (!may_be_act(packet.message_id)) return;
  const auto intervention = [&](const Act& act, mav::Source by) {
    return Intervention{.by = by, .link = from.path.link, .act = act, .at = now};
  };
  if (const auto ack = mav::decode<mavlink::common::CommandAck>(packet)) {
    KnownVehicle* const vehicle = table.find(packet.source.system);
    if (vehicle == nullptr || vehicle->state.source() != packet.source) return;
    if (mav::services::is_for(*ack, self)) return;
    const std::optional<Act> act = act_of(*ack);
    if (act) note(table, *vehicle, intervention(*act, {ack->target_system, ack->target_component}));
    return;
  }
  const std::optional<Act> act = act_of(packet);
  if (!act || packet.source == self) return;
  for (const auto& [system, vehicle] : table.all()) {
    const mav::Source own = vehicle->state.source();
    const bool meant = (act->target.system == 0 || act->target.system == own.system) &&
                       (act->target.component == 0 || act->target.component == own.component);
    if (meant && packet.source != own) note(table, *vehicle, intervention(*act, packet.source));
  }
}

}  // namespace cas::casd
