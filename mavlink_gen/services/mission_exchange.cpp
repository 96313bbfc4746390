// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/mission_exchange.hpp"

#include <algorithm>
#include <utility>

#include "mavlink/common/mission_request.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/address.hpp"

namespace cas::mav::services {
namespace {

using namespace mavlink::common;

constexpr std::size_t kMaxItems = 65535;  // MISSION_COUNT has 16 bits

/// Decodes a packet of this message that is for `self` and hands it on.
template <class Message, class Handler>
void take(const PacketView& packet, Source self, Handler&& handler) {
  const auto message = decode<Message>(packet);
  if (message && is_for(*message, self)) handler(*message);
}

MissionAck whole(MavMissionType type) {
  MissionAck ack;
  ack.type = MavMissionResult::kAccepted;
  ack.mission_type = type;
  return ack;
}

}  // namespace

std::string describe(MavMissionResult result) {
  switch (result) {
    case MavMissionResult::kAccepted:
      return "accepted";
    case MavMissionResult::kUnsupportedFrame:
      return "frame not supported";
    case MavMissionResult::kUnsupported:
      return "not supported";
    case MavMissionResult::kNoSpace:
      return "no space";
    case MavMissionResult::kInvalidSequence:
      return "no such item";
    case MavMissionResult::kDenied:
      return "denied";
    case MavMissionResult::kOperationCancelled:
      return "cancelled";
    default:
      return "refused with result " + std::to_string(static_cast<unsigned>(result));
  }
}

void MissionExchange::upload(Items items, Time now, Done done, Type type) {
  if (items.size() > kMaxItems) {
    return done(failure(OutcomeKind::kInvalid, "a mission has at most 65535 items"), items);
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].seq = static_cast<std::uint16_t>(i);
    items[i].mission_type = type;
  }
  MissionCount count;
  count.count = static_cast<std::uint16_t>(items.size());
  count.mission_type = type;
  Transfer transfer{.kind = Kind::kUpload, .type = type, .items = std::move(items)};
  transfer.count = transfer.items.size();
  transfer.done = std::move(done);
  transfer.last = count;
  start(std::move(transfer), now);
}

void MissionExchange::download(Time now, Done done, Type type) {
  MissionRequestList request;
  request.mission_type = type;
  Transfer transfer{.kind = Kind::kDownload, .type = type};
  transfer.done = std::move(done);
  transfer.last = request;
  start(std::move(transfer), now);
}

void MissionExchange::clear(Time now, Done done, Type type) {
  MissionClearAll clear;
  clear.mission_type = type;
  Transfer transfer{.kind = Kind::kClear, .type = type};
  transfer.done = std::move(done);
  transfer.last = clear;
  start(std::move(transfer), now);
}

/// Begins a transfer with the message in `last`.
void MissionExchange::start(Transfer transfer, Time now) {
  if (transfer_) {
    return transfer.done(failure(OutcomeKind::kRefused, "another mission transfer is under way"),
                         {});
  }
  transfer.give_up = now + timing_.whole_timeout;
  transfer_ = std::move(transfer);
  say(transfer_->last, now);
}

void MissionExchange::say(Message message, Time now) {
  transfer_->last = message;
  transfer_->sent = 1;
  transfer_->deadline = now + timing_.answer_timeout;
  send_(transfer_->last);
}

void MissionExchange::on_packet(const PacketView& packet, Source self, Time now) {
  if (!transfer_) return;
  const auto request = [&](const auto& m) { on_request(m.seq, m.mission_type, now); };
  switch (packet.message_id) {
    case MissionRequestInt::kId:
      return take<MissionRequestInt>(packet, self, request);
    case MissionRequest::kId:
      return take<MissionRequest>(packet, self, request);
    case MissionCount::kId:
      return take<MissionCount>(packet, self, [&](const auto& m) { on_count(m, now); });
    case MissionItemInt::kId:
      return take<MissionItemInt>(packet, self, [&](const auto& m) { on_item(m, now); });
    case MissionAck::kId:
      return take<MissionAck>(packet, self, [&](const auto& m) { on_ack(m); });
    default:
      return;
  }
}

void MissionExchange::on_request(std::uint16_t seq, Type type, Time now) {
  Transfer& transfer = *transfer_;
  if (transfer.kind != Kind::kUpload || type != transfer.type) return;
  if (seq >= transfer.items.size()) return;
  transfer.asked_for = std::max<std::size_t>(transfer.asked_for, seq + 1U);
  say(transfer.items[seq], now);
}

void MissionExchange::on_count(const MissionCount& message, Time now) {
  Transfer& transfer = *transfer_;
  if (transfer.kind != Kind::kDownload || message.mission_type != transfer.type) return;
  if (transfer.count) return;  // a repeated answer
  transfer.count = message.count;
  ask_for_next(now);
}

void MissionExchange::on_item(const MissionItemInt& message, Time now) {
  Transfer& transfer = *transfer_;
  if (transfer.kind != Kind::kDownload || message.mission_type != transfer.type) return;
  if (!transfer.count || message.seq != transfer.items.size()) return;  // a repeated answer
  transfer.items.push_back(message);
  ask_for_next(now);
}

void MissionExchange::ask_for_next(Time now) {
  const Transfer& transfer = *transfer_;
  if (transfer.items.size() == transfer.count) {
    send_(whole(transfer.type));
    return finish({});
  }
  MissionRequestInt request;
  request.seq = static_cast<std::uint16_t>(transfer.items.size());
  request.mission_type = transfer.type;
  say(request, now);
}

void MissionExchange::on_ack(const MissionAck& message) {
  const Transfer& transfer = *transfer_;
  if (message.mission_type != transfer.type) return;
  if (message.type != MavMissionResult::kAccepted) {
    finish(failure(OutcomeKind::kRefused, progress() + ": " + describe(message.type)));
  } else if (transfer.kind == Kind::kUpload && transfer.asked_for < transfer.items.size()) {
    finish(failure(OutcomeKind::kRefused, progress() + ", then it ended the transfer"));
  } else if (transfer.kind != Kind::kDownload) {
    finish({});
  }
}

void MissionExchange::tick(Time now) {
  if (!transfer_) return;
  Transfer& transfer = *transfer_;
  if (now >= transfer.give_up) {
    return finish(failure(OutcomeKind::kTimeout, progress() + "; the rest would take too long"));
  }
  if (now < transfer.deadline) return;
  if (transfer.sent >= timing_.tries) {
    return finish(failure(OutcomeKind::kTimeout, progress() + ", then nothing more came"));
  }
  ++transfer.sent;
  transfer.deadline = now + timing_.answer_timeout;
  send_(transfer.last);
}

void MissionExchange::give_up(const Outcome& outcome) {
  if (transfer_) finish(outcome);
}

void MissionExchange::finish(const Outcome& outcome) {
  const Transfer ended = std::move(*transfer_);
  transfer_.reset();  // the callback may begin another one
  ended.done(outcome, ended.items);
}

/// "the vehicle asked for 2 of 5 items".
std::string MissionExchange::progress() const {
  const Transfer& transfer = *transfer_;
  if (transfer.kind == Kind::kClear) return "the vehicle was told to clear its items";
  if (!transfer.count) return "the vehicle was asked for its items";
  const bool up = transfer.kind == Kind::kUpload;
  return std::string("the vehicle ") + (up ? "asked for " : "sent ") +
         std::to_string(up ? transfer.asked_for : transfer.items.size()) + " of " +
         std::to_string(*transfer.count) + " items";
}

}  // namespace cas::mav::services
