// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/autopilot_logs.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "base/os/log.hpp"
#include "casd/autopilot_log/dataflash_pull.hpp"
#include "casd/autopilot_log/ulog_pull.hpp"
#include "mavlink/common/logging_data.hpp"
#include "mavlink/common/logging_data_acked.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/address.hpp"

namespace cas::casd {
namespace {

/// Whether a packet is a piece of a log for casd's own station.
bool is_piece(const mav::PacketView& packet, mav::Source self) {
  using namespace mavlink::common;
  const auto is = [&]<class Message>(const std::optional<Message>& message) {
    return message && message->target_system != 0 && mav::services::is_for(*message, self);
  };
  return is(mav::decode<LoggingData>(packet)) || is(mav::decode<LoggingDataAcked>(packet)) ||
         is(mav::decode<RemoteLogDataBlock>(packet));
}

}  // namespace

void AutopilotLogs::on_packet(const Origin& from, const mav::PacketView& packet,
                              base::RunTime now) {
  now_ = now;
  if (!is_piece(packet, self_)) return;
  const auto found = logs_.find(packet.source.system);
  const VehicleState* const vehicle = commander_.find(packet.source.system);
  if (found == logs_.end() || vehicle == nullptr || vehicle->source() != packet.source ||
      found->second->source != packet.source || !vehicle->is_at(from, now)) {
    return;
  }
  found->second->pull->on_packet(packet, now);
}

void AutopilotLogs::tick(base::RunTime now) {
  now_ = now;
  forget_lost(now);
  if (logs_.size() < kMostLogs) full_ = false;
  for (const VehicleState* vehicle : commander_.vehicles()) {
    if (Log* const log = log_of(*vehicle, now)) tick(*log, *vehicle, now);
  }
}

void AutopilotLogs::end(base::RunTime now) {
  now_ = now;
  for (const auto& [system, log] : logs_) {
    if (std::exchange(log->wanted, false)) log->pull->stop(now);
  }
  logs_.clear();
}

AutopilotLogsStatus AutopilotLogs::status(base::RunTime now) const {
  AutopilotLogsStatus all{.files = files_.status(now), .vehicles = {}};
  const auto& open = all.files.open;
  for (const auto& [system, log] : logs_) {
    AutopilotLogStatus& one = all.vehicles.emplace_back();
    one.system = system;
    one.wanted = log->wanted;
    if (log->wanted) one.trouble = log->trouble;
    const auto file = log->file ? open.find(*log->file) : open.end();
    if (file != open.end()) one.file = file->second;
  }
  return all;
}

void AutopilotLogs::forget_lost(base::RunTime now) {
  for (auto each = logs_.begin(); each != logs_.end();) {
    const VehicleState* const vehicle = commander_.find(each->first);
    const bool known = vehicle != nullptr && vehicle->source() == each->second->source;
    if (!known) each->second->pull->restart(now);  // closes the file
    each = known ? std::next(each) : logs_.erase(each);
  }
}

AutopilotLogs::Log* AutopilotLogs::log_of(const VehicleState& vehicle, base::RunTime now) {
  const std::uint8_t system = vehicle.source().system;
  const auto found = logs_.find(system);
  if (found != logs_.end()) return found->second.get();
  const Autopilot autopilot = vehicle.autopilot();
  if (autopilot == Autopilot::kOther || !is_wanted(system)) return nullptr;
  if (logs_.size() >= kMostLogs && !make_room(vehicle.link(), now)) {
    if (!std::exchange(full_, true)) {
      base::log::warn(fmt::format(
          "logs of {} vehicles are taken; vehicle {} is not asked for its log", kMostLogs, system));
    }
    return nullptr;
  }
  auto log = std::make_unique<Log>();
  log->source = vehicle.source();
  log->restarted_at = vehicle.restarted_at();
  if (autopilot == Autopilot::kPx4) {
    log->pull = std::make_unique<UlogPull>(hooks(system, *log));
  } else {
    log->pull = std::make_unique<DataflashPull>(hooks(system, *log));
  }
  return logs_.emplace(system, std::move(log)).first->second.get();
}

bool AutopilotLogs::is_wanted(std::uint8_t system) const {
  return systems_.empty() || std::ranges::find(systems_, system) != systems_.end();
}

/// Ends a log of the link that has most of them, if that is at least two more than this link has;
/// one without a file first.
bool AutopilotLogs::make_room(LinkId link, base::RunTime now) {
  std::map<LinkId, std::vector<std::uint8_t>> systems;
  for (const auto& [system, log] : logs_)
    systems[commander_.find(system)->link()].push_back(system);
  const auto size = [](const auto& entry) { return entry.second.size(); };
  const std::vector<std::uint8_t>& most = std::ranges::max_element(systems, {}, size)->second;
  if (most.size() < systems[link].size() + 2) return false;
  const auto is_idle = [this](std::uint8_t system) { return !logs_.at(system)->file; };
  const auto idle = std::ranges::find_if(most, is_idle);
  const auto ended = logs_.find(idle == most.end() ? most.back() : *idle);
  if (ended->second->wanted) ended->second->pull->stop(now);
  logs_.erase(ended);
  return true;
}

void AutopilotLogs::tick(Log& log, const VehicleState& vehicle, base::RunTime now) {
  const bool flies = log.window.update(vehicle.armed(), now);
  if (std::exchange(log.restarted_at, vehicle.restarted_at()) != vehicle.restarted_at()) {
    log.pull->restart(now);
    log.trouble.clear();
  }
  const bool silent = vehicle.heartbeat_age(now) > kVehicleTimeout;
  const bool wanted = (flies || !while_armed_) && files_.takes() && !vehicle.is_high_latency();
  if (wanted && !silent) {
    log.wanted = true;
    log.pull->tick(now);
  } else if (!wanted && std::exchange(log.wanted, false)) {
    log.pull->stop(now);
  }
}

LogPullHooks AutopilotLogs::hooks(std::uint8_t system, Log& log) {
  return {
      .send =
          [this, system](const VehicleCommander::LogAnswer& answer) {
            commander_.answer_log(system, answer);
          },
      .command =
          [this, system](const VehicleCommand& command, Done done) {
            commander_.command(system, command, false, now_, std::move(done));
          },
      .begin =
          [this, system, &log](std::string_view extension) {
            log.file = files_.begin(fmt::format("v{}", system), extension);
            log.trouble.clear();
          },
      .write = [this, &log](
                   LogPart part) { return !log.file || files_.write(*log.file, std::move(part)); },
      .end =
          [this, &log] {
            if (log.file) files_.end(*std::exchange(log.file, std::nullopt));
          },
      .warn =
          [system, &log](const std::string& sentence) {
            log.trouble = sentence;
            base::log::warn(fmt::format("vehicle {} {}", system, sentence));
          }};
}

}  // namespace cas::casd
