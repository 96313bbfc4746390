// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/param_exchange.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "base/suggestion.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::mav::services {
namespace {

using mavlink::common::MavParamType;
using mavlink::common::ParamRequestList;
using mavlink::common::ParamRequestRead;
using mavlink::common::ParamSet;
using mavlink::common::ParamValue;

constexpr std::size_t kMaxKnown = 8192;
constexpr std::size_t kMaxActive = 64;
/// A vehicle that still starts may add parameters while it lists them, but not without end.
constexpr std::size_t kMaxNews = 2 * kMaxKnown;
constexpr std::size_t kNameBytes = 16;
constexpr std::size_t kMaxTexts = 5;
/// A value that is not the asked one may be an older answer still on its way: asked again once.
constexpr int kMismatchesBelieved = 2;
/// param_index of answers that belong to no list (PX4's _HASH_CHECK among them).
constexpr std::uint16_t kNoIndex = 65535;

ParamRequestRead read_by_name(const std::string& name) {
  ParamRequestRead message;
  set_text(message.param_id, name);
  message.param_index = -1;
  return message;
}

ParamRequestRead read_by_index(std::size_t index) {
  ParamRequestRead message;
  message.param_index = static_cast<std::int16_t>(index);
  return message;
}

std::string because(const std::vector<std::string>& texts) {
  return texts.empty() ? std::string() : ": " + texts.back();
}

struct IntegerType {
  MavParamType type;
  double low;
  double high;
};

constexpr IntegerType kIntegers[] = {
    {MavParamType::kUint8, 0, 255},           {MavParamType::kInt8, -128, 127},
    {MavParamType::kUint16, 0, 65535},        {MavParamType::kInt16, -32768, 32767},
    {MavParamType::kUint32, 0, 4294967295.0}, {MavParamType::kInt32, -2147483648.0, 2147483647.0},
};

const IntegerType* integer(MavParamType type) {
  for (const IntegerType& entry : kIntegers) {
    if (entry.type == type) return &entry;
  }
  return nullptr;
}

/// The low bytes of the float field, read as the type they were written as.
double integer_from_bytes(MavParamType type, float wire) {
  const auto bits = std::bit_cast<std::uint32_t>(wire);
  switch (type) {
    case MavParamType::kUint8:
      return static_cast<std::uint8_t>(bits);
    case MavParamType::kInt8:
      return static_cast<std::int8_t>(bits);
    case MavParamType::kUint16:
      return static_cast<std::uint16_t>(bits);
    case MavParamType::kInt16:
      return static_cast<std::int16_t>(bits);
    case MavParamType::kUint32:
      return bits;
    default:
      return static_cast<std::int32_t>(bits);
  }
}

}  // namespace

void ParamExchange::read(const std::string& name, Time now, Done done) {
  Request request;
  request.name = name;
  request.done = std::move(done);
  start(std::move(request), now);
}

void ParamExchange::set(const std::string& name, double value, Time now, Done done,
                        Objection objection) {
  Request request;
  request.name = name;
  request.value = value;
  request.done = std::move(done);
  request.objection = std::move(objection);
  start(std::move(request), now);
}

void ParamExchange::start(Request request, Time now) {
  if (request.name.empty() || request.name.size() > kNameBytes) {
    request.done(failure(OutcomeKind::kInvalid,
                         "'" + request.name + "' is no parameter name: it has 1 to 16 characters"));
    return;
  }
  if (active_.size() >= kMaxActive) {
    request.done(
        failure(OutcomeKind::kRefused, "too many parameter requests wait for this vehicle"));
    return;
  }
  request.type_known = known_.contains(request.name);
  if (request.value && request.type_known && !fits(request)) {
    request.done(unfit(request));
    return;
  }
  active_.push_back(std::move(request));
  transmit(std::prev(active_.end()), now);
}

bool ParamExchange::fits(const Request& request) const {
  return to_wire(encoding_, known_.at(request.name).type, *request.value).has_value();
}

Outcome ParamExchange::unfit(const Request& request) const {
  const std::string_view type = name(known_.at(request.name).type);
  return failure(OutcomeKind::kInvalid, request.name + " is " + std::string(type) +
                                            " and cannot hold " + number_text(*request.value));
}

void ParamExchange::transmit(std::list<Request>::iterator request, Time now) {
  const bool sets = request->value && request->type_known;
  if (sets && request->objection) {
    if (std::optional<Outcome> why = request->objection(now)) {
      return finish(request, std::move(*why));
    }
  }
  request->deadline = now + timing_.answer_timeout;
  ++request->sent;
  if (sets) {
    send_set(*request);
  } else {
    send_(read_by_name(request->name));
  }
}

void ParamExchange::send_set(Request& request) {
  const auto& [value, type] = known_.at(request.name);
  if (!request.before) request.before = value;
  ParamSet message;
  set_text(message.param_id, request.name);
  message.param_type = type;
  message.param_value = to_wire(encoding_, type, *request.value).value_or(0.0F);
  send_(message);
}

void ParamExchange::on_value(const ParamValue& message, ParamEncoding encoding, Time now) {
  const std::string name(text(message.param_id));
  const Parameter in_force{from_wire(encoding, message.param_type, message.param_value),
                           message.param_type};
  encoding_ = encoding;
  if (known_.size() < kMaxKnown || known_.contains(name)) known_[name] = in_force;
  if (listing_) on_listed(message, name, in_force.value, now);
  // Every request of this name gets the answer; a callback may start more, so they are collected
  // first.
  std::vector<std::list<Request>::iterator> asked;
  for (auto request = active_.begin(); request != active_.end(); ++request) {
    if (request->name == name) asked.push_back(request);
  }
  for (const auto& request : asked) on_answer(request, in_force, now);
}

void ParamExchange::on_answer(std::list<Request>::iterator request, const Parameter& in_force,
                              Time now) {
  if (!request->value) {
    Outcome outcome;
    outcome.parameters[request->name] = in_force.value;
    finish(request, std::move(outcome));
    return;
  }
  if (request->type_known) {
    on_set_answer(request, in_force, now);
    return;
  }
  if (!known_.contains(request->name)) {
    finish(request,
           failure(OutcomeKind::kRefused, "the vehicle has more parameters than are held here"));
    return;
  }
  if (!fits(*request)) {
    finish(request, unfit(*request));
    return;
  }
  request->type_known = true;
  request->sent = 0;
  transmit(request, now);
}

void ParamExchange::on_set_answer(std::list<Request>::iterator request, const Parameter& in_force,
                                  Time now) {
  Outcome outcome;
  outcome.parameters[request->name] = in_force.value;
  if (request->before) outcome.before[request->name] = *request->before;
  if (!same_value(in_force.type, *request->value, in_force.value)) {
    if (++request->mismatches < kMismatchesBelieved) {
      transmit(request, now);
      return;
    }
    outcome.kind = OutcomeKind::kRefused;
    outcome.message = "the vehicle keeps " + request->name + " = " + number_text(in_force.value) +
                      " (asked: " + number_text(*request->value) + ")" + because(request->texts);
  }
  finish(request, std::move(outcome));
}

void ParamExchange::on_status_text(std::string_view text) {
  for (Request& request : active_) {
    if (request.texts.size() < kMaxTexts) request.texts.emplace_back(text);
  }
}

void ParamExchange::give_up(const Outcome& outcome) {
  std::vector<Done> ended;
  for (Request& request : active_) ended.push_back(std::move(request.done));
  if (listing_) std::move(listing_->done.begin(), listing_->done.end(), std::back_inserter(ended));
  active_.clear();
  listing_.reset();
  for (const Done& done : ended) done(outcome);
}

void ParamExchange::finish(std::list<Request>::iterator request, Outcome outcome) {
  outcome.status_texts = std::move(request->texts);
  const Done done = std::move(request->done);
  active_.erase(request);
  done(outcome);
}

void ParamExchange::tick(Time now) {
  for (;;) {
    const auto due = std::find_if(active_.begin(), active_.end(),
                                  [now](const Request& r) { return now >= r.deadline; });
    if (due == active_.end()) break;
    if (due->sent < timing_.tries) {
      transmit(due, now);
      continue;
    }
    const bool reading = !due->value || !due->type_known;
    std::string sentence = due->name + (reading ? " was asked for " : " was sent ") +
                           std::to_string(due->sent) + " times without an answer";
    if (reading) {
      const std::string meant = base::did_you_mean(due->name, known_names());
      sentence += meant.empty() ? "; this vehicle may not have it" : meant;
    }
    finish(due, failure(OutcomeKind::kTimeout, sentence + because(due->texts)));
  }
  if (listing_ && now >= listing_->deadline) tick_listing(now);
}

std::optional<Time> ParamExchange::due() const {
  std::optional<Time> due;
  if (listing_) due = listing_->deadline;
  for (const Request& request : active_)
    due = std::min(due.value_or(request.deadline), request.deadline);
  return due;
}

std::vector<std::string_view> ParamExchange::known_names() const {
  std::vector<std::string_view> names;
  for (const auto& [name, parameter] : known_) names.push_back(name);
  return names;
}

void ParamExchange::list(Time now, Done done) {
  if (listing_) {
    if (listing_->done.size() >= kMaxActive) {
      done(failure(OutcomeKind::kRefused, "too many parameter requests wait for this vehicle"));
      return;
    }
    listing_->done.push_back(std::move(done));
    return;
  }
  listing_ = Listing{};
  listing_->done.push_back(std::move(done));
  listing_->deadline = now + timing_.answer_timeout;
  send_(ParamRequestList{});
}

void ParamExchange::on_listed(const ParamValue& message, const std::string& name, double value,
                              Time now) {
  Listing& listing = *listing_;
  if (message.param_index == kNoIndex || message.param_index >= message.param_count) return;
  // Names may come without end too, under the same few indices.
  const bool too_many = listing.values.size() >= kMaxKnown && !listing.values.contains(name);
  if (message.param_count > kMaxKnown || too_many) {
    const std::size_t claimed = std::max<std::size_t>(message.param_count, kMaxKnown + 1);
    give_up_listing(OutcomeKind::kRefused, "the vehicle claims to have " + std::to_string(claimed) +
                                               " parameters or more; the most that is held is " +
                                               std::to_string(kMaxKnown));
    return;
  }
  if (listing.have.size() != message.param_count) listing.have.resize(message.param_count, false);
  listing.values[name] = value;
  if (listing.have[message.param_index]) return;
  if (++listing.news > kMaxNews) {
    give_up_listing(OutcomeKind::kRefused,
                    "the vehicle changes the number of its parameters while "
                    "it lists them, without end");
    return;
  }
  listing.have[message.param_index] = true;
  listing.received =
      static_cast<std::size_t>(std::count(listing.have.begin(), listing.have.end(), true));
  listing.idle_rounds = 0;
  listing.deadline = now + timing_.answer_timeout;
  if (listing.received < listing.have.size()) return;
  Outcome outcome;
  outcome.parameters = listing.values;
  finish_listing(std::move(outcome));
}

/// Nothing new for a while: asks again for the list or for the missing ones.
void ParamExchange::tick_listing(Time now) {
  Listing& listing = *listing_;
  const std::string sent = "the vehicle sent " + std::to_string(listing.received) + " of " +
                           std::to_string(listing.have.size()) + " parameters";
  if (++listing.idle_rounds >= timing_.tries) {
    give_up_listing(OutcomeKind::kTimeout, sent + ", then no more");
    return;
  }
  if (listing.have.empty()) {
    listing.deadline = now + timing_.answer_timeout;
    send_(ParamRequestList{});
    return;
  }
  listing.deadline = now + (listing.idle_rounds + 1) * timing_.answer_timeout;
  std::size_t asked = 0;
  for (std::size_t index = 0; index < listing.have.size(); ++index) {
    if (listing.have[index] || asked == timing_.missing_at_once) continue;
    ++asked;
    send_(read_by_index(index));
  }
}

std::optional<ListProgress> ParamExchange::list_progress() const {
  if (!listing_) return std::nullopt;
  return ListProgress{listing_->received, listing_->have.size()};
}

void ParamExchange::give_up_listing(OutcomeKind kind, const std::string& why) {
  Outcome outcome = failure(kind, why);
  outcome.parameters = listing_->values;
  finish_listing(std::move(outcome));
}

void ParamExchange::finish_listing(Outcome outcome) {
  const std::vector<Done> done = std::move(listing_->done);
  listing_.reset();
  for (const Done& each : done) each(outcome);
}

double from_wire(ParamEncoding encoding, MavParamType type, float wire) {
  if (encoding == ParamEncoding::kCast || integer(type) == nullptr) return wire;
  return integer_from_bytes(type, wire);
}

std::optional<float> to_wire(ParamEncoding encoding, MavParamType type, double value) {
  if (!std::isfinite(value)) return std::nullopt;
  const IntegerType* range = integer(type);
  if (range == nullptr) {
    if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
      return std::nullopt;
    }
    return static_cast<float>(value);
  }
  if (value < range->low || value > range->high || value != std::floor(value)) {
    return std::nullopt;
  }
  if (encoding == ParamEncoding::kCast) return static_cast<float>(value);
  return std::bit_cast<float>(static_cast<std::uint32_t>(static_cast<std::int64_t>(value)));
}

bool same_value(MavParamType type, double asked, double in_force) {
  if (integer(type) != nullptr) return asked == in_force;
  return static_cast<float>(asked) == static_cast<float>(in_force);
}

std::string_view name(MavParamType type) {
  switch (type) {
    case MavParamType::kUint8:
      return "UINT8";
    case MavParamType::kInt8:
      return "INT8";
    case MavParamType::kUint16:
      return "UINT16";
    case MavParamType::kInt16:
      return "INT16";
    case MavParamType::kUint32:
      return "UINT32";
    case MavParamType::kInt32:
      return "INT32";
    case MavParamType::kReal32:
      return "REAL32";
    default:
      return "unknown";
  }
}

std::string number_text(double value) {
  char text[48];
  const bool whole = std::floor(value) == value && std::abs(value) < 1e15;
  const auto end = whole ? std::to_chars(text, text + sizeof text, value, std::chars_format::fixed)
                         : std::to_chars(text, text + sizeof text, static_cast<float>(value));
  return std::string(text, end.ptr);
}

}  // namespace cas::mav::services
