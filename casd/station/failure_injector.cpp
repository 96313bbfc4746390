// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/failure_injector.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/vehicle_heartbeat.hpp"

namespace cas::casd {
namespace {

using mav::services::FailureOrder;
using mav::services::FailureRefusal;
using mavlink::common::CommandAck;
using mavlink::common::MavCmd;
using mavlink::common::MavResult;
using mavlink::common::MavSeverity;
using mavlink::common::Statustext;

/// A refusal. @param text  for a STATUSTEXT, after "casd: " @param more  for the audit only
Outcome refused(MavResult result, std::string text, const std::string& more = {}) {
  Outcome outcome = failure(OutcomeKind::kRefused, std::move(text));
  outcome.result = result;
  if (!more.empty()) outcome.status_texts.push_back(more);
  return outcome;
}

/// The simulator's answer.
Outcome outcome_of(const CommandAck& ack) {
  if (ack.result == MavResult::kAccepted) {
    Outcome outcome;
    outcome.result = ack.result;
    return outcome;
  }
  const auto why = [&ack](std::string text, const std::string& more) {
    return refused(ack.result, std::move(text), more);
  };
  switch (static_cast<FailureRefusal>(ack.progress)) {
    case FailureRefusal::kUnit:
      return why("the simulator has no such unit", "docs/use/campaign.md has the units");
    case FailureRefusal::kType:
      return why("that unit does not fail in this way", "docs/use/campaign.md has its ways");
    case FailureRefusal::kPart:
      return why("the simulated vehicle has no such part", "or it has not sent anything yet");
    case FailureRefusal::kInstance:
      return why("the simulated vehicle has fewer of these", "instances count from 1; 0: all");
    case FailureRefusal::kByHand:
      return why("the vehicle has no plugin fault by hand",
                 "its plugins lack {plugin: fault, by_hand: true}");
    case FailureRefusal::kFull:
      return why("this run takes no more failures", "end some of them");
    default:
      return why("the simulator refused the failure", "its log says why");
  }
}

std::string sentence(const Outcome& outcome) {
  std::string text = outcome.message;
  for (const std::string& more : outcome.status_texts) text += ": " + more;
  return text;
}

std::string ids(mav::Source source) {
  return fmt::format("{}/{}", source.system, source.component);
}

}  // namespace

FailureInjector::FailureInjector(mav::Source self, const VehicleCommander& commander,
                                 FailureHooks hooks)
    : encoder_(self), commander_(commander), hooks_(std::move(hooks)) {}

FailureInjector::Verdict FailureInjector::on_packet(const Origin& from,
                                                    const mav::PacketView& packet,
                                                    base::RunTime now) {
  if (packet.message_id == CommandAck::kId) on_ack(from, packet, now);
  const auto command = mav::services::failure_command(packet);
  if (!command) return Verdict::kNotOurs;
  const std::optional<FailureOrder>& order = command->order;
  const Addressee vehicle = addressee(command->target);
  const std::uint8_t system = vehicle.source.system;
  if (gone_.has(from.path.link)) {
    leave_line(
        fmt::format("{} MAV_CMD_INJECT_FAILURE vehicle {}: it came in the middle of a reload",
                    ids(packet.source), system),
        false, now);
    return Verdict::kRefused;
  }
  if (order && is_repetition(from, packet, system, *order)) return Verdict::kRefused;

  Request request = request_of(from, packet, order, vehicle.source);
  auto why = refusal(packet.source, from.path.link);
  if (!why && !order) why = refused(MavResult::kDenied, "unit, type or instance is no number");
  if (!why) why = vehicle.unknown;
  if (!why) why = refusal(system, hooks_.simulator(system));
  if (why) {
    end(request, *why, now);
    return Verdict::kRefused;
  }
  add(system, std::move(request), now);
  return Verdict::kTaken;
}

FailureInjector::Addressee FailureInjector::addressee(mav::Source target) const {
  const std::uint8_t component =
      target.component != 0 ? target.component : mav::services::kAutopilot;
  std::optional<std::uint8_t> asked;
  if (target.system != 0) asked = target.system;
  const auto resolved = commander_.resolve(asked);
  if (const auto* const system = std::get_if<std::uint8_t>(&resolved)) {
    return {.source = {*system, component}};
  }
  return {.source = {target.system, component},
          .unknown = refused(MavResult::kDenied, "there is no such vehicle",
                             std::get<Outcome>(resolved).message)};
}

FailureInjector::Request FailureInjector::request_of(const Origin& from,
                                                     const mav::PacketView& packet,
                                                     const std::optional<FailureOrder>& order,
                                                     mav::Source vehicle) {
  std::string line = fmt::format(
      "{} on link {} MAV_CMD_INJECT_FAILURE{} vehicle {}: ", ids(packet.source),
      hooks_.link_name(from.path.link), order ? " '" + to_words(*order) + "'" : "", vehicle.system);
  return {.order = order.value_or(FailureOrder{}),
          .answer = [this, to = from.path, asker = packet.source,
                     vehicle](const Outcome& outcome) { answer(to, asker, vehicle, outcome); },
          .line = std::move(line),
          .by = packet.source,
          .link = from.path.link,
          .peer = from.path.peer};
}

void FailureInjector::inject(std::uint8_t system, const VehicleCommand& command, base::RunTime now,
                             Done done) {
  const auto& params = command.params;
  const auto order = mav::services::failure_order(params[0], params[1], params[2]);
  if (!order) {
    return done(failure(OutcomeKind::kInvalid,
                        "unit, type and instance of a failure are whole numbers from 0 to 255"));
  }
  const Done told = [done = std::move(done)](const Outcome& outcome) {
    Outcome whole = outcome;
    if (!outcome.ok()) whole.message = sentence(outcome);
    whole.status_texts.clear();
    done(whole);
  };
  if (const auto why = refusal(system, hooks_.simulator(system))) return told(*why);
  add(system, {.order = *order, .answer = told}, now);
}

/// Why this station may not inject failures at all.
std::optional<Outcome> FailureInjector::refusal(mav::Source by, LinkId link) const {
  if (by == encoder_.source()) {
    return refused(MavResult::kDenied, "the sender has casd's own ids");
  }
  if (hooks_.permits(link)) return std::nullopt;
  return refused(MavResult::kDenied, "this link may not inject failures",
                 "inject_failures: true of the link permits it");
}

/// Why no failure can be injected into this vehicle.
std::optional<Outcome> FailureInjector::refusal(std::uint8_t system,
                                                const std::optional<Simulator>& simulator) const {
  if (const auto doubt = hooks_.hil_doubt(system)) {
    Outcome why = refused(MavResult::kDenied, "the vehicle is not known to be in HIL", *doubt);
    why.kind = OutcomeKind::kInterlock;
    return why;
  }
  if (!simulator || is_autopilot(simulator->source)) {
    return refused(MavResult::kUnsupported, "no simulator feeds this vehicle",
                   "no HIL_SENSOR, or that of several senders or links, comes to it through casd");
  }
  return std::nullopt;
}

/// Whether these ids are a vehicle's: it gets no failure, even if it sends HIL_SENSOR.
bool FailureInjector::is_autopilot(mav::Source source) const {
  const VehicleState* const vehicle = commander_.find(source.system);
  return source.component == mav::services::kAutopilot ||
         (vehicle != nullptr && vehicle->source() == source);
}

/// Whether it repeats a request that waits for its answer.
bool FailureInjector::is_repetition(const Origin& from, const mav::PacketView& packet,
                                    std::uint8_t system, const FailureOrder& order) const {
  const auto found = waiting_.find(system);
  return found != waiting_.end() && std::ranges::any_of(found->second, [&](const Request& request) {
           return request.by == packet.source && request.link == from.path.link &&
                  request.peer == from.path.peer && request.order == order;
         });
}

void FailureInjector::add(std::uint8_t system, Request request, base::RunTime now) {
  std::deque<Request>& waiting = waiting_[system];
  if (waiting.size() == kMostWaiting) {
    return end(request, refused(MavResult::kTemporarilyRejected, "too many failures wait"), now);
  }
  waiting.push_back(std::move(request));
  if (waiting.size() == 1) send_first(system, now);
}

void FailureInjector::send_first(std::uint8_t system, base::RunTime now) {
  // Permissions and simulator may have changed while it waited.
  Request& request = waiting_.at(system).front();
  const auto simulator = hooks_.simulator(system);
  auto why = refusal(system, simulator);
  if (request.link != kNoLink && !why) why = refusal(request.by, request.link);
  if (why) return finish(system, *why, now);
  request.simulator = *simulator;
  request.token = token_ = token_ % mav::services::kMostToken + 1;
  request.deadline = now + kPatience;
  auto command = mav::services::command_of(request.order, request.simulator.source);
  command.param7 = static_cast<float>(request.token);
  hooks_.send(encoder_(command), {&request.simulator.path, 1});
}

void FailureInjector::on_ack(const Origin& from, const mav::PacketView& packet, base::RunTime now) {
  const auto ack = mav::decode<CommandAck>(packet);
  if (!ack || ack->command != MavCmd::kInjectFailure) return;
  if (!mav::services::is_for(*ack, encoder_.source())) return;
  for (const auto& [system, waiting] : waiting_) {
    if (waiting.empty()) continue;
    const Request& request = waiting.front();
    if (request.token != ack->result_param2 || request.simulator.source != packet.source ||
        request.simulator.path.link != from.path.link) {
      continue;
    }
    return finish(system, outcome_of(*ack), now);
  }
}

void FailureInjector::tick(base::RunTime now) {
  for (auto& [system, waiting] : waiting_) {
    if (waiting.empty() || now < waiting.front().deadline) continue;
    finish(system,
           refused(MavResult::kFailed, "the simulator does not answer",
                   "it is paused, or not hilsim; a paused one acts when it goes on"),
           now);
  }
}

base::RunTime FailureInjector::due() const {
  base::RunTime due = base::RunTime::max();
  for (const auto& [system, waiting] : waiting_) {
    if (!waiting.empty()) due = std::min(due, waiting.front().deadline);
  }
  return due;
}

/// The request under way has ended; the next one is sent.
void FailureInjector::finish(std::uint8_t system, const Outcome& outcome, base::RunTime now) {
  std::deque<Request>& waiting = waiting_.at(system);
  const Request request = std::move(waiting.front());
  waiting.pop_front();
  end(request, outcome, now);
  if (!waiting.empty() && waiting.front().token == 0) send_first(system, now);
}

/// Leaves the audit's line, and answers.
void FailureInjector::end(const Request& request, const Outcome& outcome, base::RunTime now) {
  if (!request.line.empty()) {
    leave_line(request.line + (outcome.ok() ? "accepted" : sentence(outcome)), outcome.ok(), now);
  }
  if (request.answer) request.answer(outcome);
}

void FailureInjector::begin_reload(const LinkMask& gone, base::RunTime now) {
  gone_ = gone;
  for (auto& [system, waiting] : waiting_) {
    for (Request& request : waiting) {
      if (request.link == kNoLink || !gone.has(request.link)) continue;
      request.link = kNoLink;
      request.answer = nullptr;
    }
    std::erase_if(waiting, [&](const Request& request) {
      const bool dropped = request.token == 0 && !request.answer;
      if (dropped) end(request, refused(MavResult::kDenied, "its link is gone"), now);
      return dropped;
    });
  }
}

/// COMMAND_ACK, and for a refusal STATUSTEXT, from the vehicle's ids.
void FailureInjector::answer(const Path& to, mav::Source asker, mav::Source vehicle,
                             const Outcome& outcome) {
  if (!outcome.ok()) {
    Statustext text;
    text.severity = MavSeverity::kWarning;
    mav::set_text(text.text, std::string(kInjectorPrefix) + outcome.message);
    send_as(vehicle, text, to);
  }
  CommandAck ack = mav::services::addressed(CommandAck{}, asker);
  ack.command = MavCmd::kInjectFailure;
  ack.result = *outcome.result;
  send_as(vehicle, ack, to);
}

template <class M>
void FailureInjector::send_as(mav::Source source, const M& message, const Path& to) {
  mav::PacketBuffer packet;
  packet.size = mav::encode(message, source, sequence_++, packet.bytes);
  hooks_.send({packet.bytes.data(), packet.size}, {&to, 1});
}

/// A flood of refused commands leaves few lines.
void FailureInjector::leave_line(const std::string& line, bool accepted, base::RunTime now) {
  if (accepted || refusals_.take(now)) hooks_.audit(line);
}

}  // namespace cas::casd
