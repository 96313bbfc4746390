// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/conversation.hpp"

#include <optional>
#include <stdexcept>

#include "casd/tlog/tlog_files.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

namespace mv = mavlink::common;

Conversation recorded(const std::string& name) {
  Conversation all;
  std::optional<std::uint64_t> first_us;
  casd::TlogReader log;
  if (!log.open(source_dir() + "/tests/firmware/recorded/" + name + ".tlog")) {
    throw std::runtime_error("no recorded conversation " + name);
  }
  while (const auto record = log.next()) {  // messages of other dialects, too
    if (!first_us) first_us = record->unix_us;
    const base::RunTime at{std::chrono::seconds(100) +
                           std::chrono::microseconds(record->unix_us - *first_us)};
    all.push_back({at, {record->packet.begin(), record->packet.end()}});
  }
  return all;
}

Manner manner_of(const Conversation& conversation) {
  using E = mv::EstimatorStatusFlags;
  Manner manner;
  std::optional<mv::MavState> first_state;
  mv::MavLandedState landed{};
  int estimates = 0;
  int standing = 0;
  int constant = 0;
  base::RunTime first_estimate{};
  base::RunTime last_estimate{};
  for (const Said& said : conversation) {
    const mav::PacketView packet = said.view();
    if (packet.source.component != 1) continue;  // the station's
    manner.messages.insert(packet.message_id);
    if (const auto heartbeat = mav::decode<mv::Heartbeat>(packet)) {
      if (!first_state) first_state = heartbeat->system_status;
    } else if (const auto status = mav::decode<mv::SysStatus>(packet)) {
      using S = mv::MavSysStatusSensor;
      manner.enables_checks |= mv::has(status->onboard_control_sensors_enabled, S::kPrearmCheck);
      manner.passes_checks |= mv::has(status->onboard_control_sensors_health, S::kPrearmCheck);
    } else if (const auto state = mav::decode<mv::ExtendedSysState>(packet)) {
      landed = state->landed_state;
    } else if (const auto estimator = mav::decode<mv::EstimatorStatus>(packet)) {
      if (estimates++ == 0) first_estimate = said.at;
      last_estimate = said.at;
      const bool stands = landed == mv::MavLandedState::kOnGround;
      if (!stands || !mv::has(estimator->flags, E::kPosHorizAbs)) continue;
      ++standing;
      constant += mv::has(estimator->flags, E::kConstPosMode) ? 1 : 0;
    }
  }
  manner.boots_uninit = first_state == mv::MavState::kUninit;
  manner.stands_still_const = standing > 0 && constant == standing;
  if (estimates > 1) {
    manner.estimator_hz = (estimates - 1) / base::to_seconds(last_estimate - first_estimate);
  }
  return manner;
}

}  // namespace cas::test
