// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/command_exchange.hpp"

#include <algorithm>
#include <utility>

namespace cas::mav::services {
namespace {

using mavlink::common::CommandAck;
using mavlink::common::CommandInt;
using mavlink::common::CommandLong;
using mavlink::common::MavCmd;
using mavlink::common::MavFrame;
using mavlink::common::MavResult;

constexpr std::size_t kMaxWaiting = 64;
constexpr std::size_t kMaxTexts = 10;

bool newest_counts(MavCmd id) {
  return id == MavCmd::kComponentArmDisarm || id == MavCmd::kDoSetMode ||
         id == MavCmd::kDoReposition || id == MavCmd::kDoOrbit;
}

CommandLong long_form(const VehicleCommand& command, int sent) {
  CommandLong message;
  message.command = command.id;
  message.confirmation = static_cast<std::uint8_t>(std::min(sent, 255));
  message.param1 = command.params[0];
  message.param2 = command.params[1];
  message.param3 = command.params[2];
  message.param4 = command.params[3];
  message.param5 = command.params[4];
  message.param6 = command.params[5];
  message.param7 = command.params[6];
  return message;
}

CommandInt int_form(const VehicleCommand& command) {
  CommandInt message;
  message.frame = MavFrame::kGlobal;
  message.command = command.id;
  message.param1 = command.params[0];
  message.param2 = command.params[1];
  message.param3 = command.params[2];
  message.param4 = command.params[3];
  message.x = command.place->lat_deg_e7;
  message.y = command.place->lon_deg_e7;
  message.z = command.place->alt_m;
  return message;
}

std::string seconds_text(Duration d) {
  std::string text = std::to_string(std::chrono::duration<double>(d).count());
  return text.substr(0, text.find('.') + 2);
}

std::string effect_words(Duration within) { return " within " + seconds_text(within) + " s"; }

}  // namespace

void CommandExchange::start(const VehicleCommand& command, Time now, Done done, Objection objection,
                            Doubt doubt, Renewal renewal) {
  if (newest_counts(command.id)) replace(command.id, now);
  Request request;
  request.command = command;
  request.done = std::move(done);
  request.objection = std::move(objection);
  request.doubt = std::move(doubt);
  request.renewal = std::move(renewal);
  if (find(command.id) != active_.end()) {
    if (waiting_.size() >= kMaxWaiting) {
      request.done(failure(OutcomeKind::kRefused, "too many commands wait for this vehicle"));
      return;
    }
    waiting_.push_back(std::move(request));
    return;
  }
  active_.push_back(std::move(request));
  transmit(active_.back(), now);
}

/// Ends the active or waiting command of this id.
void CommandExchange::replace(MavCmd id, Time now) {
  const auto found = find(id);
  if (found == active_.end()) return;
  finish(found, failure(OutcomeKind::kRefused, describe(id) + " was replaced by a newer request"),
         now);
}

void CommandExchange::transmit(Request& request, Time now) {
  if (request.renewal) request.command = request.renewal();
  if (request.objection) request.objected = request.objection(now);
  if (request.objected) {
    request.deadline = now;
    return;
  }
  request.deadline = now + timing_.ack_timeout;
  const int sent = request.sent++;
  if (request.command.place) {
    send_(int_form(request.command));
  } else {
    send_(long_form(request.command, sent));
  }
}

bool CommandExchange::on_ack(const CommandAck& ack, Time now) {
  const auto request = find(ack.command);
  if (request == active_.end() || request->refused) return false;
  if (ack.result == MavResult::kInProgress) {
    if (request->accepted) return false;
    request->in_progress = true;
    request->deadline = now + timing_.in_progress_timeout;
    return false;
  }
  if (ack.result == MavResult::kAccepted && request->doubt) {
    if (request->accepted) return false;
    request->deadline = now + timing_.effect_timeout;
    request->accepted = true;
    return true;
  }
  if (ack.result == MavResult::kAccepted) {
    Outcome outcome;
    outcome.result = ack.result;
    finish(request, std::move(outcome), now);
    return false;
  }
  request->refused = ack.result;
  if (request->accepted) return true;  // a HEARTBEAT tells which of the two is true
  request->deadline = now + timing_.text_grace;
  if (timing_.text_grace == Duration::zero()) on_deadline(request, now);
  return false;
}

void CommandExchange::on_status_text(std::string_view text) {
  for (Request& request : active_) {
    if (request.texts.size() < kMaxTexts) request.texts.emplace_back(text);
  }
}

void CommandExchange::on_heartbeat(Time now) {
  for (Request& request : active_) request.heard = request.accepted;
  const auto decided = [](const Request& r) { return r.heard && (r.refused || !r.doubt()); };
  // end_doubt() calls back, which may start more: look again from the front.
  for (;;) {
    const auto found = std::find_if(active_.begin(), active_.end(), decided);
    if (found == active_.end()) return;
    end_doubt(found, now, effect_words(timing_.effect_timeout));
  }
}

/// Ends an accepted command by the state in the vehicle's HEARTBEATs; without any until the
/// deadline it has timed out.
void CommandExchange::end_doubt(std::list<Request>::iterator request, Time now,
                                const std::string& within) {
  // A state from before the acknowledgement is no answer.
  const std::optional<std::string> instead = request->heard ? request->doubt() : std::nullopt;
  const std::string what = describe(request->command.id) + " was accepted";
  Outcome outcome;
  outcome.result = MavResult::kAccepted;
  if (instead && request->refused) {
    outcome = failure(OutcomeKind::kRefused,
                      what + ", then " + describe(*request->refused) + ": " + *instead);
    outcome.result = request->refused;
  } else if (instead) {
    outcome =
        failure(OutcomeKind::kRefused, what + " and not carried out" + within + ": " + *instead);
  } else if (!request->heard) {
    outcome = failure(OutcomeKind::kTimeout, what + ", and no HEARTBEAT came" + within);
  }
  if (!outcome.ok() && !request->texts.empty()) {
    outcome.message += "; it says: " + request->texts.back();
  }
  finish(request, std::move(outcome), now);
}

void CommandExchange::tick(Time now) {
  if (now > ticked_at_) {
    for (Request& request : active_) request.wall_deadline.reset();  // time does not stand still
    ticked_at_ = now;
  }
  // finish() may start waiting commands and callbacks may add more: search again from the front.
  for (;;) {
    const auto due = std::find_if(active_.begin(), active_.end(),
                                  [now](const Request& r) { return now >= r.deadline; });
    if (due == active_.end()) return;
    on_deadline(due, now);
  }
}

std::optional<Time> CommandExchange::due() const {
  if (active_.empty()) return std::nullopt;
  return std::ranges::min_element(active_, {}, &Request::deadline)->deadline;
}

void CommandExchange::wall_tick(Time wall) {
  for (Request& request : active_) {
    if (request.accepted && !request.wall_deadline) {
      request.wall_deadline = wall + timing_.effect_patience;
    }
  }
  const auto is_over = [wall](const Request& r) {
    return r.wall_deadline && wall >= *r.wall_deadline;
  };
  // As in tick().
  for (;;) {
    const auto over = std::find_if(active_.begin(), active_.end(), is_over);
    if (over == active_.end()) return;
    // The next command starts at the vehicle's time, which is the last time of this request.
    end_doubt(
        over, over->deadline - timing_.effect_timeout,
        effect_words(timing_.effect_patience) + " of real time; the vehicle's time stood still");
  }
}

void CommandExchange::on_disarm(const std::string& by, Time now) {
  std::list<Request> ended;
  for (std::list<Request>* requests : {&waiting_, &active_}) {
    for (auto each = requests->begin(); each != requests->end();) {
      const auto request = each++;
      if (spins(request->command)) ended.splice(ended.end(), *requests, request);
    }
  }
  for (const Request& request : ended) {
    if (find(request.command.id) == active_.end()) start_waiting(request.command.id, now);
  }
  for (const Request& request : ended) {
    request.done(
        failure(OutcomeKind::kRefused, describe(request.command.id) + " was overtaken by " + by));
  }
}

void CommandExchange::give_up(const Outcome& outcome) {
  std::vector<Done> ended;
  for (Request& request : active_) ended.push_back(std::move(request.done));
  for (Request& request : waiting_) ended.push_back(std::move(request.done));
  active_.clear();
  waiting_.clear();
  for (const Done& done : ended) done(outcome);
}

void CommandExchange::on_deadline(std::list<Request>::iterator request, Time now) {
  const std::string what = describe(request->command.id);
  if (request->objected) {
    finish(request, *request->objected, now);
  } else if (request->accepted) {
    end_doubt(request, now, effect_words(timing_.effect_timeout));
  } else if (request->refused) {
    Outcome outcome = failure(OutcomeKind::kRefused, what + " was " + describe(*request->refused));
    if (*request->refused == MavResult::kFailed) outcome.message = what + " failed";
    if (!request->texts.empty()) outcome.message += ": " + request->texts.back();
    outcome.result = request->refused;
    finish(request, std::move(outcome), now);
  } else if (request->in_progress) {
    finish(request,
           failure(OutcomeKind::kTimeout, what + " was in progress, then nothing came for " +
                                              seconds_text(timing_.in_progress_timeout) + " s"),
           now);
  } else if (request->sent < timing_.tries) {
    transmit(*request, now);
  } else {
    finish(request,
           failure(OutcomeKind::kTimeout, what + " was sent " + std::to_string(request->sent) +
                                              " times and not acknowledged"),
           now);
  }
}

void CommandExchange::finish(std::list<Request>::iterator request, Outcome outcome, Time now) {
  outcome.status_texts = std::move(request->texts);
  const MavCmd id = request->command.id;
  const Done done = std::move(request->done);
  active_.erase(request);
  start_waiting(id, now);
  done(outcome);
}

void CommandExchange::start_waiting(MavCmd id, Time now) {
  const auto next = std::find_if(waiting_.begin(), waiting_.end(),
                                 [id](const Request& r) { return r.command.id == id; });
  if (next == waiting_.end()) return;
  active_.splice(active_.end(), waiting_, next);
  transmit(active_.back(), now);
}

std::list<CommandExchange::Request>::iterator CommandExchange::find(MavCmd id) {
  return std::find_if(active_.begin(), active_.end(),
                      [id](const Request& r) { return r.command.id == id; });
}

}  // namespace cas::mav::services
