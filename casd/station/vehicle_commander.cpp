// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/vehicle_commander.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "casd/station/motion_interlock.hpp"
#include "casd/station/overhearing.hpp"
#include "casd/station/request_chain.hpp"
#include "casd/station/vehicle_command.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/param_value.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/timesync.hpp"
#include "mavlink_gen/services/address.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;

using Streams = std::span<const std::pair<std::uint32_t, double>>;

constexpr std::pair<std::uint32_t, double> kArduPilotStreams[] = {
    {SysStatus::kId, 1},         {ExtendedSysState::kId, 2},  {Attitude::kId, 10},
    {LocalPositionNed::kId, 10}, {GlobalPositionInt::kId, 5}, {HomePosition::kId, 0.5},
    {GpsRawInt::kId, 1},         {kEkfStatusReport, 1},
};

/// PX4 streams most by itself, on some links without its estimator's status, else at 0.5 Hz.
constexpr std::pair<std::uint32_t, double> kPx4Streams[] = {{EstimatorStatus::kId, 1}};

/// Streams that commanding needs and that an autopilot may not send by itself.
Streams streams_of(Autopilot autopilot) {
  if (autopilot == Autopilot::kArduPilot) return kArduPilotStreams;
  return autopilot == Autopilot::kPx4 ? Streams(kPx4Streams) : Streams();
}

/// Farther from home than any vehicle here flies: a number beyond it is a slip.
constexpr double kFarthest_m = 100'000;

}  // namespace

/// The rates that a vehicle is asked for after it was met or has restarted: those that commanding
/// needs, then those of its link.
struct VehicleCommander::RateRound {
  base::RunTime asked_at;
  std::vector<MessageRate> rates;
  std::size_t own = 0;  ///< the first ones: nobody is told of their refusals
  std::size_t next = 0;
  std::string refused{};  ///< a sentence; empty: nothing was
};

VehicleCommander::VehicleCommander(CommanderOptions options, SendPacket send)
    : options_(options),
      send_(std::move(send)),
      encoder_(options.self),
      heartbeat_(options.heartbeat_hz,
                 [this](const Heartbeat& message, std::span<const Path> to) {
                   send_(encoder_(message), to);
                 }),
      table_([this](VehicleState state) { return make(std::move(state)); }, options.link_name),
      takeoff_(
          table_, [this] { return now_; },
          [this](const KnownVehicle& vehicle, std::string_view word, bool not_hil, Done done) {
            set_mode(vehicle.state.source().system, word, now_, std::move(done), not_hil);
          },
          [this](const KnownVehicle& vehicle, const VehicleCommand& command, bool not_hil,
                 Done done) {
            start(vehicle.state.source().system, command, now_, std::move(done),
                  {.not_hil = not_hil});
          }) {}

std::unique_ptr<KnownVehicle> VehicleCommander::make(VehicleState state) {
  const auto send_each = [this](const VehicleState& to, const auto& message) {
    std::visit([&](const auto& each) { send(to, each); }, message);
  };
  return std::make_unique<KnownVehicle>(std::move(state), send_each, options_.command_timing,
                                        options_.param_timing);
}

void VehicleCommander::set_commanding(double heartbeat_hz, bool allow_not_hil, bool ask_on_sight) {
  heartbeat_.set_rate(heartbeat_hz);
  options_.allow_not_hil = allow_not_hil;
  options_.ask_on_sight = ask_on_sight;
}

namespace {

/// Messages that a vehicle also sends of which no stream was requested.
bool comes_without_request(std::uint32_t message_id) {
  constexpr std::uint32_t kSuch[] = {Heartbeat::kId,  CommandAck::kId, ParamValue::kId,
                                     Statustext::kId, Timesync::kId,   AutopilotVersion::kId};
  return std::ranges::find(kSuch, message_id) != std::end(kSuch);
}

}  // namespace

void VehicleCommander::on_packet(const Origin& from, const mav::PacketView& packet,
                                 base::RunTime now) {
  now_ = now;
  overhear(table_, options_.self, from, packet, now);
  if (packet.source.system == options_.self.system) return;
  const KnownVehicle* const before = table_.find(packet.source.system);
  KnownVehicle* const vehicle = table_.track(from, packet, now);
  if (vehicle == nullptr) return;
  const bool restarted = vehicle->state.restarted_at() > vehicle->asked_at &&
                         now - vehicle->asked_at > kVehicleTimeout;  // its clock may leap about
  if (!comes_without_request(packet.message_id)) vehicle->told_at = now;
  const bool never_asked = vehicle != before || vehicle->asked_at == base::RunTime{};
  if (!vehicle->state.is_high_latency() &&
      (never_asked || restarted || has_stopped_telling(*vehicle, now))) {
    greet(*vehicle, now);
  }
  dispatch(*vehicle, packet, now);
  heartbeat_.keep_up(*vehicle, now);
}

/// An ArduPilot that reboots within the silence limit has forgotten its requested streams, and
/// sends no message with its clock that would show the restart.
bool VehicleCommander::has_stopped_telling(const KnownVehicle& vehicle, base::RunTime now) {
  const auto& attitude = vehicle.state.attitude();
  return vehicle.state.autopilot() == Autopilot::kArduPilot && attitude &&
         attitude->at > vehicle.asked_at && now - vehicle.told_at > kVehicleTimeout;
}

/// Requests the messages that commanding needs and that a vehicle may not send by itself, and the
/// rates of its link. Nothing is requested over a high latency link, where each packet costs.
void VehicleCommander::greet(KnownVehicle& vehicle, base::RunTime now) {
  const std::uint8_t system = vehicle.state.source().system;
  vehicle.asked_at = now;
  if (options_.ask_on_sight) {
    for (const std::uint32_t id : {AutopilotVersion::kId, HomePosition::kId}) {
      start(system, request_command(id), now, [](const Outcome&) {});
    }
  }
  std::vector<MessageRate> rates = options_.request_rates
                                       ? options_.request_rates(vehicle.state.link())
                                       : std::vector<MessageRate>();
  std::size_t own = 0;
  const Streams streams = options_.ask_on_sight ? streams_of(vehicle.state.autopilot()) : Streams();
  for (const auto& [id, hz] : streams) {
    if (std::ranges::count(rates, id, &MessageRate::message_id) > 0) continue;
    rates.insert(rates.begin() + static_cast<std::ptrdiff_t>(own++), MessageRate{id, hz});
  }
  now_ = now;
  ask_for_rates(system, std::make_shared<RateRound>(RateRound{now, std::move(rates), own}));
}

/// Asks for one rate at a time. A restart ends the round: none of its requests wait before those of
/// the next one.
void VehicleCommander::ask_for_rates(std::uint8_t system, const std::shared_ptr<RateRound>& round) {
  const KnownVehicle* const vehicle = table_.find(system);
  if (vehicle == nullptr || vehicle->asked_at != round->asked_at) return;
  if (round->next == round->rates.size()) {
    if (!round->refused.empty()) table_.notice(system, round->refused, now_);
    return;
  }
  const bool is_own = round->next < round->own;
  const MessageRate rate = round->rates[round->next++];
  const double period_us = rate.hz > 0 ? 1e6 / rate.hz : -1;
  message_interval(system, rate.message_id, period_us, now_,
                   [this, system, rate, round, is_own](const Outcome& outcome) {
                     if (!outcome.ok() && !is_own) {
                       round->refused +=
                           round->refused.empty()
                               ? fmt::format("vehicle {} does not send message ", system)
                               : "; nor message ";
                       round->refused += fmt::format("{} at {} Hz: {}", rate.message_id,
                                                     number_text(rate.hz), outcome.message);
                     }
                     ask_for_rates(system, round);
                   });
}

void VehicleCommander::dispatch(KnownVehicle& vehicle, const mav::PacketView& packet,
                                base::RunTime now) {
  switch (packet.message_id) {
    case CommandAck::kId:
      if (const auto ack = mav::decode<CommandAck>(packet);
          ack && mav::services::is_for(*ack, options_.self)) {
        // In lockstep time may stand still: no HEARTBEAT comes by itself then.
        if (vehicle.commands.on_ack(*ack, now)) {
          vehicle.commands.start(request_command(Heartbeat::kId), now, [](const Outcome&) {});
        }
      }
      break;
    case Heartbeat::kId:
      vehicle.commands.on_heartbeat(now);
      if (!vehicle.state.armed() && vehicle.state.armed_at() > vehicle.takeoff_height.written()) {
        vehicle.takeoff_height.put_back(now);
      }
      break;
    case ExtendedSysState::kId:
      // The navigator reads the parameter when it begins to climb: not before it is in the air,
      // unless the takeoff fails.
      // ArduPlane's mode TAKEOFF reads it until the climb ends: it stays to the disarm.
      if (vehicle.state.autopilot() == Autopilot::kPx4 &&
          (vehicle.state.landed() == MavLandedState::kTakeoff ||
           vehicle.state.landed() == MavLandedState::kInAir)) {
        vehicle.takeoff_height.put_back(now);
      }
      break;
    case ParamValue::kId:
      if (const auto value = mav::decode<ParamValue>(packet)) {
        vehicle.params.on_value(*value, vehicle.state.param_encoding(), now);
      }
      break;
    case Statustext::kId:
      on_status_text(vehicle);
      break;
    default:
      break;
  }
}

void VehicleCommander::on_status_text(KnownVehicle& vehicle) {
  const std::uint64_t count = vehicle.state.status_text_count();
  if (count == vehicle.texts_seen) return;
  vehicle.texts_seen = count;
  const StatusText& text = vehicle.state.status_texts().back();
  vehicle.commands.on_status_text(text.text);
  vehicle.params.on_status_text(text.text);
  if (on_text_) on_text_(vehicle.state, text);
}

void VehicleCommander::tick(base::RunTime now) {
  now_ = now;
  heartbeat_.tick(table_.all(), now);
  for (const auto& [system, vehicle] : table_.all()) {
    vehicle->commands.tick(now);
    vehicle->params.tick(now);
  }
  table_.tick(now);
}

base::RunTime VehicleCommander::next_tick(base::RunTime now) const {
  base::RunTime next = now + kRestTick;
  const auto no_later_than = [&next](const std::optional<base::RunTime>& due) {
    if (due) next = std::min(next, *due);
  };
  no_later_than(heartbeat_.due());
  for (const auto& [system, vehicle] : table_.all()) {
    no_later_than(vehicle->commands.due());
    no_later_than(vehicle->params.due());
  }
  return std::max(now, next);
}

void VehicleCommander::wall_tick(base::RunTime wall) {
  for (const auto& [system, vehicle] : table_.all()) vehicle->commands.wall_tick(wall);
}

template <class M>
void VehicleCommander::send(const VehicleState& vehicle, M message) {
  if constexpr (requires { message.target_system; }) {
    message = mav::services::addressed(message, vehicle.source());
  } else {
    message.target = vehicle.source().system;
  }
  // Without paths the router would ask every link for this system id.
  const std::vector<Path> paths = vehicle.paths();
  if (!paths.empty()) send_(encoder_(message), paths);
}

void VehicleCommander::manual_control(std::uint8_t system, const Sticks& sticks, bool not_hil,
                                      base::RunTime now, Done done) {
  KnownVehicle* vehicle = known(system, done);
  if (vehicle == nullptr || interlocked(*vehicle, not_hil, now, done)) return;
  constexpr double kFull = 1000;
  const auto scaled = [](double stick, double low) {
    return static_cast<std::int16_t>(std::lround(std::clamp(stick, low, 1.0) * kFull));
  };
  mavlink::common::ManualControl message;
  message.x = scaled(sticks.pitch, -1);
  message.y = scaled(sticks.roll, -1);
  message.z = scaled(sticks.throttle, 0);
  message.r = scaled(sticks.yaw, -1);
  message.buttons = sticks.buttons;
  send(vehicle->state, message);
  done(Outcome{});
}

const VehicleState* VehicleCommander::find(std::uint8_t system) const {
  const KnownVehicle* vehicle = table_.find(system);
  return vehicle == nullptr ? nullptr : &vehicle->state;
}

const Hands& VehicleCommander::hands(std::uint8_t system) const { return table_.hands(system); }

std::vector<const VehicleState*> VehicleCommander::vehicles() const {
  std::vector<const VehicleState*> all;
  for (const auto& [system, vehicle] : table_.all()) all.push_back(&vehicle->state);
  return all;
}

bool VehicleCommander::any_armed(base::RunTime now) const { return table_.any_armed(now); }

KnownVehicle* VehicleCommander::known(std::uint8_t system, const Done& done) {
  if (KnownVehicle* vehicle = table_.find(system)) return vehicle;
  done(failure(OutcomeKind::kNoSuchVehicle, fmt::format("no vehicle {} has been heard", system)));
  return nullptr;
}

/// The interlock is asked before each transmission, because much can change between two of them or
/// while the command waits in line.
void VehicleCommander::start(std::uint8_t system, const VehicleCommand& command, base::RunTime now,
                             Done done, const Terms& terms) {
  now_ = now;
  KnownVehicle* const vehicle = known(system, done);
  if (vehicle == nullptr) return;
  // The exchange is the vehicle's own: it does not outlive its state.
  const auto objection = [this, &state = vehicle->state, command, not_hil = terms.not_hil,
                          renewal = terms.renewal](base::RunTime at) {
    const Motion motion =
        motion_of(renewal ? renewal() : command, addressee_of(state.heartbeat().message));
    return interlock(state, motion, not_hil, at);
  };
  if (const std::optional<Outcome> why = objection(now)) return done(*why);
  vehicle->commands.start(command, now, std::move(done), objection, terms.doubt, terms.renewal);
}

std::optional<std::string> VehicleCommander::hil_doubt(std::uint8_t system,
                                                       base::RunTime now) const {
  const VehicleState* const state = find(system);
  if (state == nullptr) return fmt::format("no vehicle {} has been heard", system);
  const std::optional<std::string> rival = rival_words(*state, table_, now);
  return rival ? rival : not_in_hil(*state, now);
}

std::optional<Outcome> VehicleCommander::interlock(const VehicleState& state, Motion motion,
                                                   bool not_hil, base::RunTime now) const {
  return motion_interlock(motion, state, table_,
                          {.request = not_hil, .configuration = options_.allow_not_hil}, now);
}

/// Answers `done` and returns true when the interlock keeps motors from starting.
bool VehicleCommander::interlocked(const KnownVehicle& vehicle, bool not_hil, base::RunTime now,
                                   const Done& done) const {
  const std::optional<Outcome> why = interlock(vehicle.state, Motion::kSpins, not_hil, now);
  if (why) done(*why);
  return why.has_value();
}

void VehicleCommander::arm(std::uint8_t system, ArmOptions options, base::RunTime now, Done done) {
  now_ = now;
  const VehicleCommand command = arm_command(true, options.force);
  KnownVehicle* const vehicle = known(system, done);
  if (vehicle == nullptr) return;
  Hands& hands = table_.hands(system);
  const bool not_hil = options.not_hil;
  const auto is_newest = [this, system, request = ++hands.arm_requests] {
    return table_.find(system) != nullptr && table_.hands(system).arm_requests == request;
  };
  start(system, command, now,
        [this, system, command, not_hil, is_newest,
         done = explained(*vehicle, std::move(done))](const Outcome& armed) {
          if (armed.kind != OutcomeKind::kRefused || !is_newest()) return done(armed);
          if (!find(system)->waits_for_sticks()) return done(armed);
          // PX4 will not arm in a stick mode without a transmitter: go to HOLD and retry.
          set_mode(
              system, "HOLD", now_,
              [this, system, command, not_hil, is_newest, done](const Outcome& held) {
                if (!held.ok()) return done(held);
                if (!is_newest()) {
                  return done(failure(OutcomeKind::kRefused,
                                      describe(command.id) + " was replaced by a newer request"));
                }
                start(system, command, now_, done, {.not_hil = not_hil});
              });
        },
        {.not_hil = not_hil});
}

/// Adds the vehicle's known complaints to a refusal. Texts from before the request do not count:
/// their reasons may be over.
Done VehicleCommander::explained(const KnownVehicle& vehicle, Done done) {
  const std::uint8_t system = vehicle.state.source().system;
  const std::uint64_t texts_before = vehicle.state.status_text_count();
  return [this, system, texts_before, done = std::move(done)](const Outcome& outcome) {
    const VehicleState* state = find(system);
    if (outcome.kind != OutcomeKind::kRefused || state == nullptr) return done(outcome);
    Outcome told = outcome;
    for (const std::string& complaint : complaints(*state, now_, texts_before)) {
      if (told.message.find(complaint) == std::string::npos) told.message += "; " + complaint;
    }
    done(told);
  };
}

void VehicleCommander::disarm(std::uint8_t system, bool force, base::RunTime now, Done done) {
  command(system, arm_command(false, force), false, now, std::move(done));
}

void VehicleCommander::command(std::uint8_t system, const VehicleCommand& command, bool not_hil,
                               base::RunTime now, Done done) {
  now_ = now;
  KnownVehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  if (command.id == MavCmd::kInjectFailure) {
    if (!on_failure_) {
      return done(failure(OutcomeKind::kRefused, "no failure can be injected from here"));
    }
    return on_failure_(system, command, std::move(done));
  }
  Hands& hands = table_.hands(system);
  if (stops(command)) ++hands.disarms;
  if (stops(command) || command.id == MavCmd::kComponentArmDisarm) ++hands.arm_requests;
  start(system, command, now, std::move(done), {.not_hil = not_hil});
  if (stops(command)) vehicle->commands.on_disarm("a newer request to disarm", now);
}

void VehicleCommander::takeoff(std::uint8_t system, double altitude_m, base::RunTime now, Done done,
                               bool not_hil) {
  now_ = now;
  KnownVehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  if (!(altitude_m > 0 && altitude_m <= Takeoff::kHighest_m)) {
    done(failure(OutcomeKind::kInvalid, "a takeoff altitude is above 0 m and at most 10 km"));
    return;
  }
  if (interlocked(*vehicle, not_hil, now, done)) return;
  takeoff_.begin(*vehicle, altitude_m, not_hil, std::move(done));
}

namespace {

/// The mode in which a vehicle stays where it is without a pilot.
std::string_view holding_mode(const VehicleState& state) {
  switch (state.mode_set()) {
    case ModeSet::kCopter:
      return "BRAKE";  // LOITER follows the sticks
    case ModeSet::kPlane:
      return state.vtol_word() == "multicopter" ? "QLOITER" : "LOITER";
    case ModeSet::kSub:
      return "POSHOLD";
    default:
      return "HOLD";
  }
}

}  // namespace

void VehicleCommander::land(std::uint8_t system, base::RunTime now, Done done) {
  const KnownVehicle* const vehicle = known(system, done);
  if (vehicle == nullptr) return;
  if (vehicle->state.mode_set() != ModeSet::kPlane) {
    start(system, here_command(vehicle->state, MavCmd::kNavLand), now, std::move(done));
  } else if (vehicle->state.vtol_word().empty()) {
    // ArduPlane lands where its mission says.
    start(system, VehicleCommand{.id = MavCmd::kDoLandStart}, now, std::move(done));
  } else {
    set_mode(system, "QLAND", now, std::move(done));
  }
}

void VehicleCommander::return_home(std::uint8_t system, base::RunTime now, Done done) {
  start(system, VehicleCommand{.id = MavCmd::kNavReturnToLaunch}, now, std::move(done));
}

void VehicleCommander::hold(std::uint8_t system, base::RunTime now, Done done) {
  if (const KnownVehicle* vehicle = known(system, done)) {
    set_mode(system, holding_mode(vehicle->state), now, std::move(done));
  }
}

void VehicleCommander::set_mode(std::uint8_t system, std::string_view word, base::RunTime now,
                                Done done, bool not_hil) {
  now_ = now;
  KnownVehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  const VehicleState& state = vehicle->state;
  const std::optional<std::uint32_t> mode = custom_mode(state.mode_set(), word);
  if (!mode) {
    const std::string words = base::joined(mode_words(state.mode_set()), " ");
    done(failure(OutcomeKind::kInvalid, "'" + std::string(word) + "' is no mode of " +
                                            std::string(name(state.autopilot())) +
                                            (words.empty() ? std::string() : "; it has " + words)));
    return;
  }
  const auto doubt = [&state, mode]() -> std::optional<std::string> {
    if (state.heartbeat().message.custom_mode == *mode) return std::nullopt;
    return "it is in " + state.mode();
  };
  const auto renewal = [&state, mode] { return mode_command(state, *mode); };
  start(system, renewal(), now, std::move(done),
        {.not_hil = not_hil, .doubt = doubt, .renewal = renewal});
}

void VehicleCommander::go_to(std::uint8_t system, const Target& target, base::RunTime now,
                             Done done, bool not_hil) {
  const KnownVehicle* vehicle = known(system, done);
  if (vehicle == nullptr) return;
  const std::optional<HomeAmsl> home = vehicle->state.home();
  if (!home) {
    done(failure(OutcomeKind::kRefused, vehicle_text(vehicle->state) +
                                            " has not told its home position yet; wait for its "
                                            "position estimate"));
    return;
  }
  const double north_m = target.north_m - home->x_m;
  const double east_m = target.east_m - home->y_m;
  const double down_m = target.down_m - home->z_m;
  if (!(std::hypot(north_m, east_m, down_m) <= kFarthest_m)) {
    done(failure(OutcomeKind::kInvalid, "a place to go to lies within 100 km of home"));
    return;
  }
  VehicleCommand command = reposition_command(*home, north_m, east_m, down_m, target.yaw_deg);
  if (target.radius_m) command = circling(command, vehicle->state.autopilot(), *target.radius_m);
  start(system, command, now, std::move(done), {.not_hil = not_hil});
}

void VehicleCommander::message_interval(std::uint8_t system, std::uint32_t message_id,
                                        double period_us, base::RunTime now, Done done) {
  start(system, interval_command(message_id, period_us), now, std::move(done));
}

void VehicleCommander::reboot(std::uint8_t system, base::RunTime now, Done done, bool not_hil) {
  VehicleCommand command{.id = MavCmd::kPreflightRebootShutdown};
  command.params[0] = 1;
  start(system, command, now, std::move(done), {.not_hil = not_hil});
}

void VehicleCommander::answer_log(std::uint8_t system, const LogAnswer& answer) {
  const VehicleState* const vehicle = find(system);
  if (vehicle == nullptr) return;
  std::visit([&](const auto& message) { send(*vehicle, message); }, answer);
}

void VehicleCommander::read_param(std::uint8_t system, const std::string& name, base::RunTime now,
                                  Done done) {
  now_ = now;
  if (KnownVehicle* vehicle = known(system, done)) vehicle->params.read(name, now, std::move(done));
}

void VehicleCommander::set_param(std::uint8_t system, const std::string& name, double value,
                                 base::RunTime now, Done done, bool not_hil) {
  now_ = now;
  if (KnownVehicle* vehicle = known(system, done)) {
    const bool spins = motion_of_parameter(name) == Motion::kSpins && !leads_into_hil(name, value);
    if (spins && interlocked(*vehicle, not_hil, now, done)) return;
    if (name == vehicle->takeoff_height.parameter()) vehicle->takeoff_height.keep();
    ParamExchange::Objection objection;
    if (spins) {
      objection = [this, &state = vehicle->state, not_hil](base::RunTime at) {
        return interlock(state, Motion::kSpins, not_hil, at);
      };
    }
    vehicle->params.set(name, value, now, std::move(done), std::move(objection));
  }
}

void VehicleCommander::list_params(std::uint8_t system, base::RunTime now, Done done) {
  now_ = now;
  if (KnownVehicle* vehicle = known(system, done)) vehicle->params.list(now, std::move(done));
}

std::optional<mav::services::ListProgress> VehicleCommander::list_progress(
    std::uint8_t system) const {
  const KnownVehicle* vehicle = table_.find(system);
  return vehicle == nullptr ? std::nullopt : vehicle->params.list_progress();
}

std::optional<mavlink::common::MavParamType> VehicleCommander::param_type(
    std::uint8_t system, const std::string& name) const {
  const KnownVehicle* vehicle = table_.find(system);
  if (vehicle == nullptr) return std::nullopt;
  const auto& known = vehicle->params.known();
  const auto found = known.find(name);
  if (found == known.end()) return std::nullopt;
  return found->second.type;
}

void VehicleCommander::set_gains(std::uint8_t system, const GainLoop& loop,
                                 const GainValues& values, base::RunTime now, Done done,
                                 bool not_hil) {
  now_ = now;
  if (const std::optional<std::string> why = unsupported(loop, values)) {
    done(failure(OutcomeKind::kRefused, *why));
    return;
  }
  std::vector<Request> requests;
  const auto add = [&](const std::optional<std::string>& name, const std::optional<double>& value) {
    if (!name) return;
    requests.push_back([this, system, name = *name, value, not_hil](Done next) {
      if (value) {
        set_param(system, name, *value, now_, std::move(next), not_hil);
      } else {
        read_param(system, name, now_, std::move(next));
      }
    });
  };
  add(loop.p, values.p);
  add(loop.i, values.i);
  add(loop.d, values.d);
  run_chain(std::move(requests), std::move(done));
}

}  // namespace cas::casd
