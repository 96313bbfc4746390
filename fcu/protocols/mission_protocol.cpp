// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/mission_protocol.hpp"

#include <algorithm>

#include "mavlink/common/mission_current.hpp"
#include "mavlink/common/mission_item_reached.hpp"
#include "mavlink/common/mission_request_int.hpp"

namespace cas::fcu {

using base::RunTime;
using mav::Source;
using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

constexpr base::Duration kRetry = std::chrono::milliseconds(250);
constexpr int kMostTries = 10;
constexpr std::size_t kMostDownloads = 8;                        // at once,
constexpr base::Duration kForgotten = std::chrono::seconds(10);  // those that ask for nothing end

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

void MissionProtocol::acknowledge(Source to, int version, MavMissionType type,
                                  MavMissionResult result) {
  MissionAck ack;
  ack.target_system = to.system;
  ack.target_component = to.component;
  ack.type = result;
  ack.mission_type = type;
  outbox_.reply(ack, version);
}

bool MissionProtocol::is_flown() const {
  return commander_.armed() && commander_.mode() == FlightMode::kMission;
}

void MissionProtocol::on_count(const MissionCount& m, Source from, int version, RunTime now) {
  if (m.mission_type != MavMissionType::kMission) {
    // An empty fence is as good as none.
    acknowledge(from, version, m.mission_type,
                m.count == 0 ? MavMissionResult::kAccepted : MavMissionResult::kUnsupported);
    return;
  }
  if (m.count > kMaxItems) {
    return acknowledge(from, version, m.mission_type, MavMissionResult::kNoSpace);
  }
  const bool others_turn = upload_ && !(upload_->from == from);
  if (is_flown() || others_turn) {
    return acknowledge(from, version, m.mission_type, MavMissionResult::kDenied);
  }
  upload_ = Upload{from, version, m.count, {}, now, 0};
  if (m.count == 0) return finish(MavMissionResult::kAccepted);
  request_next(now);
}

void MissionProtocol::request_next(RunTime now) {
  MissionRequestInt request;
  request.target_system = upload_->from.system;
  request.target_component = upload_->from.component;
  request.seq = static_cast<std::uint16_t>(upload_->items.size());
  request.mission_type = MavMissionType::kMission;
  outbox_.reply(request, upload_->version);
  upload_->asked = now;
}

void MissionProtocol::finish(MavMissionResult result) {
  acknowledge(upload_->from, upload_->version, MavMissionType::kMission, result);
  if (result == MavMissionResult::kAccepted) {
    commander_.mission().set_items(std::move(upload_->items));
  }
  upload_.reset();
}

void MissionProtocol::on_item(const MissionItemInt& m, Source from, RunTime now) {
  if (!upload_ || !(upload_->from == from)) return;
  if (m.seq < upload_->items.size()) return;  // a repeated answer
  if (m.seq > upload_->items.size()) return request_next(now);
  const MissionItem item = from_wire(m);
  const MavMissionResult result = MissionTask::check(item);
  if (result != MavMissionResult::kAccepted) return finish(result);
  upload_->items.push_back(item);
  upload_->tries = 0;
  if (upload_->items.size() == upload_->count) return finish(MavMissionResult::kAccepted);
  request_next(now);
}

void MissionProtocol::on_request_list(const MissionRequestList& m, Source from, int version,
                                      RunTime now) {
  MissionCount count;
  count.target_system = from.system;
  count.target_component = from.component;
  count.mission_type = m.mission_type;
  if (m.mission_type == MavMissionType::kMission) {
    const std::vector<MissionItem>& items = commander_.mission().items();
    count.count = static_cast<std::uint16_t>(items.size());
    std::erase_if(downloads_, [&](const Download& each) {
      return each.from == from || now - each.used > kForgotten;
    });
    if (downloads_.size() == kMostDownloads) downloads_.pop_front();
    downloads_.push_back({from, items, now});
  }
  outbox_.reply(count, version);
}

/// The mission that a station downloads; else the present one.
const std::vector<MissionItem>& MissionProtocol::items_for(Source from, RunTime now) {
  const auto found =
      std::ranges::find_if(downloads_, [&](const Download& each) { return each.from == from; });
  if (found == downloads_.end() || now - found->used > kForgotten) {
    return commander_.mission().items();
  }
  found->used = now;
  return found->items;
}

void MissionProtocol::on_ack(const MissionAck& m, Source from) {
  if (m.mission_type != MavMissionType::kMission) return;
  std::erase_if(downloads_, [&](const Download& each) { return each.from == from; });
  const bool cancelled = m.type == MavMissionResult::kOperationCancelled;
  if (cancelled && upload_ && upload_->from == from) upload_.reset();
}

void MissionProtocol::on_request(std::uint16_t seq, MavMissionType type, Source from, int version,
                                 RunTime now) {
  const std::vector<MissionItem>& items = items_for(from, now);
  if (type != MavMissionType::kMission || seq >= items.size()) {
    return acknowledge(from, version, type, MavMissionResult::kInvalidSequence);
  }
  const MissionItem& item = items[seq];
  MissionItemInt m;
  m.target_system = from.system;
  m.target_component = from.component;
  m.seq = seq;
  m.frame = item.frame;
  m.command = item.command;
  m.current = seq == commander_.mission().current() ? 1 : 0;
  m.autocontinue = item.autocontinue ? 1 : 0;
  m.param1 = static_cast<float>(item.param[0]);
  m.param2 = static_cast<float>(item.param[1]);
  m.param3 = static_cast<float>(item.param[2]);
  m.param4 = static_cast<float>(item.param[3]);
  m.x = item.x;
  m.y = item.y;
  m.z = static_cast<float>(item.z);
  m.mission_type = type;
  outbox_.reply(m, version);
}

void MissionProtocol::on_clear(const MissionClearAll& m, Source from, int version) {
  if (is_flown()) return acknowledge(from, version, m.mission_type, MavMissionResult::kDenied);
  const bool ours =
      m.mission_type == MavMissionType::kMission || m.mission_type == MavMissionType::kAll;
  if (ours) commander_.mission().set_items({});
  acknowledge(from, version, m.mission_type, MavMissionResult::kAccepted);
}

void MissionProtocol::on_set_current(const MissionSetCurrent& m) {
  if (!commander_.mission().set_current(m.seq)) {
    texts_.warn("No mission item " + std::to_string(m.seq));
    return;
  }
  mavlink::common::MissionCurrent current;
  current.seq = m.seq;
  current.total = static_cast<std::uint16_t>(commander_.mission().items().size());
  outbox_.send(current);
}

void MissionProtocol::update(RunTime now) {
  if (const auto reached = commander_.mission().take_reached()) {
    outbox_.send(MissionItemReached{*reached});
  }
  if (!upload_ || now - upload_->asked < kRetry) return;
  if (++upload_->tries > kMostTries) {
    return finish(MavMissionResult::kOperationCancelled);
  }
  request_next(now);
}

}  // namespace cas::fcu
