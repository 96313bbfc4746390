// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/mission_protocol.hpp"

#include "fcu/core/fcu_core.hpp"
#include "mavlink/common/mission_ack.hpp"
#include "mavlink/common/mission_current.hpp"
#include "mavlink/common/mission_item_reached.hpp"
#include "mavlink/common/mission_request_int.hpp"

namespace cas::fcu {

using base::RunTime;
using mav::Source;
using mavlink::common::MavMissionResult;
using mavlink::common::MavMissionType;
using mavlink::common::MissionAck;
using mavlink::common::MissionClearAll;
using mavlink::common::MissionCount;
using mavlink::common::MissionItemInt;
using mavlink::common::MissionItemReached;
using mavlink::common::MissionRequestInt;
using mavlink::common::MissionRequestList;
using mavlink::common::MissionSetCurrent;

namespace {

constexpr base::Duration kRetry = std::chrono::milliseconds(250);
constexpr int kMostTries = 10;

void acknowledge(FcuCore& core, Source to, int version, MavMissionType type,
                 MavMissionResult result) {
  MissionAck ack;
  ack.target_system = to.system;
  ack.target_component = to.component;
  ack.type = result;
  ack.mission_type = type;
  core.outbox.reply(ack, version);
}

MissionItem from_wire(const MissionItemInt& m) {
  MissionItem item;
  item.frame = m.frame;
  item.command = m.command;
  item.autocontinue = m.autocontinue != 0;
  item.param = {static_cast<double>(m.param1), static_cast<double>(m.param2),
                static_cast<double>(m.param3), static_cast<double>(m.param4)};
  item.x = m.x;
  item.y = m.y;
  item.z = static_cast<double>(m.z);
  return item;
}

}  // namespace

void MissionProtocol::on_count(const MissionCount& m, Source from, int version, FcuCore& core,
                               RunTime now) {
  if (m.mission_type != MavMissionType::kMission) {
    // An empty fence is as good as none.
    acknowledge(core, from, version, m.mission_type,
                m.count == 0 ? MavMissionResult::kAccepted : MavMissionResult::kUnsupported);
    return;
  }
  if (m.count > kMaxItems) {
    acknowledge(core, from, version, m.mission_type, MavMissionResult::kNoSpace);
    return;
  }
  const bool flown = core.commander.armed() && core.commander.mode() == FlightMode::kMission;
  if (flown) {
    acknowledge(core, from, version, m.mission_type, MavMissionResult::kDenied);
    return;
  }
  upload_ = Upload{from, version, m.count, {}, now, 0};
  if (m.count == 0) return finish(core, MavMissionResult::kAccepted);
  request_next(core, now);
}

void MissionProtocol::request_next(FcuCore& core, RunTime now) {
  MissionRequestInt request;
  request.target_system = upload_->from.system;
  request.target_component = upload_->from.component;
  request.seq = static_cast<std::uint16_t>(upload_->items.size());
  request.mission_type = MavMissionType::kMission;
  core.outbox.reply(request, upload_->version);
  upload_->asked = now;
}

void MissionProtocol::finish(FcuCore& core, MavMissionResult result) {
  acknowledge(core, upload_->from, upload_->version, MavMissionType::kMission, result);
  if (result == MavMissionResult::kAccepted) {
    core.commander.mission().set_items(std::move(upload_->items));
  }
  upload_.reset();
}

void MissionProtocol::on_item(const MissionItemInt& m, Source from, int, FcuCore& core,
                              RunTime now) {
  if (!upload_ || !(upload_->from == from)) return;
  if (m.seq < upload_->items.size()) return;  // a repeated answer
  if (m.seq > upload_->items.size()) return request_next(core, now);
  const MissionItem item = from_wire(m);
  const MavMissionResult result = MissionTask::check(item);
  if (result != MavMissionResult::kAccepted) return finish(core, result);
  upload_->items.push_back(item);
  upload_->tries = 0;
  if (upload_->items.size() == upload_->count) return finish(core, MavMissionResult::kAccepted);
  request_next(core, now);
}

void MissionProtocol::on_request_list(const MissionRequestList& m, Source from, int version,
                                      FcuCore& core) {
  MissionCount count;
  count.target_system = from.system;
  count.target_component = from.component;
  count.mission_type = m.mission_type;
  if (m.mission_type == MavMissionType::kMission) {
    count.count = static_cast<std::uint16_t>(core.commander.mission().items().size());
  }
  core.outbox.reply(count, version);
}

void MissionProtocol::on_request(std::uint16_t seq, MavMissionType type, Source from, int version,
                                 FcuCore& core) {
  const auto& items = core.commander.mission().items();
  if (type != MavMissionType::kMission || seq >= items.size()) {
    return acknowledge(core, from, version, type, MavMissionResult::kInvalidSequence);
  }
  const MissionItem& item = items[seq];
  MissionItemInt m;
  m.target_system = from.system;
  m.target_component = from.component;
  m.seq = seq;
  m.frame = item.frame;
  m.command = item.command;
  m.current = seq == core.commander.mission().current() ? 1 : 0;
  m.autocontinue = item.autocontinue ? 1 : 0;
  m.param1 = static_cast<float>(item.param[0]);
  m.param2 = static_cast<float>(item.param[1]);
  m.param3 = static_cast<float>(item.param[2]);
  m.param4 = static_cast<float>(item.param[3]);
  m.x = item.x;
  m.y = item.y;
  m.z = static_cast<float>(item.z);
  m.mission_type = type;
  core.outbox.reply(m, version);
}

void MissionProtocol::on_clear(const MissionClearAll& m, Source from, int version, FcuCore& core) {
  const bool flown = core.commander.armed() && core.commander.mode() == FlightMode::kMission;
  if (flown) return acknowledge(core, from, version, m.mission_type, MavMissionResult::kDenied);
  const bool ours =
      m.mission_type == MavMissionType::kMission || m.mission_type == MavMissionType::kAll;
  if (ours) core.commander.mission().set_items({});
  acknowledge(core, from, version, m.mission_type, MavMissionResult::kAccepted);
}

void MissionProtocol::on_set_current(const MissionSetCurrent& m, FcuCore& core, RunTime) {
  if (!core.commander.mission().set_current(m.seq)) {
    core.texts.warn("No mission item " + std::to_string(m.seq));
    return;
  }
  mavlink::common::MissionCurrent current;
  current.seq = m.seq;
  current.total = static_cast<std::uint16_t>(core.commander.mission().items().size());
  core.outbox.send(current);
}

void MissionProtocol::update(FcuCore& core, RunTime now) {
  if (const auto reached = core.commander.mission().take_reached()) {
    core.outbox.send(MissionItemReached{*reached});
  }
  if (!upload_ || now - upload_->asked < kRetry) return;
  if (++upload_->tries > kMostTries) {
    finish(core, MavMissionResult::kOperationCancelled);
    return;
  }
  request_next(core, now);
}

}  // namespace cas::fcu
