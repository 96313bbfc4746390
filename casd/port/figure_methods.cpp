// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/figure_methods.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/enum_words.hpp"
#include "casd/packet/signing_clock.hpp"
#include "casd/port/call_json.hpp"
#include "casd/port/daemon_methods.hpp"
#include "casd/port/port_description.hpp"
#include "casd/topology/rule_keys.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "mavlink_gen/runtime/signing.hpp"

namespace cas::casd {
namespace {

using base::rpc::Refusal;
using nlohmann::json;

constexpr std::pair<Refusal, const char*> kRefusals[] = {
    {Refusal::kNotJsonRpc, "not_json_rpc"},
    {Refusal::kWrongToken, "wrong_token"},
    {Refusal::kNoRequest, "no_request"},
    {Refusal::kNoPlace, "no_place"},
};

/// Rows of one answer. A flood of invented senders must not make one that takes long.
constexpr std::int64_t kMostMessages = 5000;
/// Rows of a notice, which goes once a second to each client that subscribed.
constexpr std::size_t kNoticeMessages = 2000;

double microseconds(base::Duration d) { return base::to_seconds(d) * 1e6; }

constexpr base::EnumWords<mav::SignatureVerdict::kTooNew> kSignatureWords{
    "accepted", "unsigned_allowed", "unsigned",   "bad",
    "replayed", "too_old",          "table_full", "too_new"};

json signatures_json(const LinkStatus& link) {
  json counts{{"setup_signing", link.rx.setup_signing}};
  for (std::size_t i = 0; i < link.rx.signatures.size(); ++i) {
    counts[std::string(kSignatureWords[static_cast<mav::SignatureVerdict>(i)])] =
        link.rx.signatures[i];
  }
  return counts;
}

/// How far a time of signatures is ahead of the clock; 0 when it is not.
double ahead_s(mav::SigningTime time, mav::SigningTime clock) {
  return time <= clock
             ? 0
             : static_cast<double>(time - clock) / static_cast<double>(mav::kSigningUnitsPerSecond);
}

/// The time of a link's key, and the newest signature from the future.
json signing_json(const LinkStatus& link, base::RunTime now, mav::SigningTime clock) {
  json entry{{"time_file", link.rx.signing_file},
             {"time_ahead_s", ahead_s(link.rx.signing_time, clock)},
             {"too_far_ahead", link.rx.signing_time > clock + kMaxPlausibleLead}};
  if (const auto& future = link.rx.future_signature) {
    entry["future"] = {
        {"system", future->source.system}, {"component", future->source.component},
        {"link_id", future->link_id},      {"ahead_s", ahead_s(future->time, clock)},
        {"refused", future->refused},      {"age_s", base::to_seconds(now - future->at)}};
  }
  return entry;
}

json reload_json(const ReloadReport& reload, base::RunTime now) {
  json entry{{"accepted", !reload.trouble}, {"age_s", base::to_seconds(now - reload.at)}};
  if (reload.trouble) entry["reason"] = *reload.trouble;
  return entry;
}

/// The counters of one block: "rx", "tx", or "" for the link's own.
json counters_json(const LinkStatus& link, std::string_view group) {
  json counters = json::object();
  for (const LinkCounterRow& row : link_counter_rows()) {
    if (row.words.group == group) counters[std::string(row.words.key)] = row.value(link);
  }
  return counters;
}

json rx_json(const LinkStatus& link) {
  json rx = counters_json(link, "rx");
  for (std::size_t i = 0; i < link.rx.decisions.size(); ++i) {
    rx["verdicts"][std::string(to_string(static_cast<Route::Decision>(i)))] = link.rx.decisions[i];
  }
  return rx;
}

json forwarding_json(const LinkStatus& link) {
  return {{"p50", microseconds(link.tx.forwarding_p50)},
          {"p99", microseconds(link.tx.forwarding_p99)},
          {"max", microseconds(link.tx.forwarding_max)}};
}

json tx_json(const LinkStatus& link) {
  json tx = counters_json(link, "tx");
  for (std::size_t i = 0; i < link.tx.dropped.size(); ++i) {
    tx["dropped"][std::string(to_string(static_cast<DropCause>(i)))] = link.tx.dropped[i];
  }
  tx["forwarding_us"] = forwarding_json(link);
  return tx;
}

json message_json(const MessageStatus& message, const std::string& name) {
  return json{{"link", message.link},
              {"direction", to_string(message.way)},
              {"id", message.id},
              {"name", name},
              {"system", message.source.system},
              {"component", message.source.component},
              {"count", message.count},
              {"hz", message.hz},
              {"age_s", message.age_s}};
}

json list_json(const std::vector<std::uint8_t>& ids) { return ids; }

json list_json(const std::vector<std::uint32_t>& messages) {
  json names = json::array();
  for (const std::uint32_t id : messages) {
    const mav::MessageInfo* info = mav::public_table().find(id);
    names.push_back(info == nullptr ? json(id) : json(info->name));
  }
  return names;
}

json list_json(const std::vector<RateRule>& rates) {
  constexpr RateRule kNone;
  json limits = json::array();
  for (const RateRule& rate : rates) {
    json limit{{"message", list_json(std::vector{rate.message_id})[0]}};
    base::for_each_key(kRateKeys, [&](const auto& key) {
      if (key.of(rate) != key.of(kNone)) limit[std::string(key.name)] = key.of(rate);
    });
    limits.push_back(std::move(limit));
  }
  return limits;
}

json rule_json(const RouteConfig& route) {
  json entry{{"from", route.from}, {"to", route.to}};
  for_each_filter(route.rule, [&entry](const auto& key, const auto& list) {
    entry[std::string(key.name)] = list_json(list);
  });
  return entry;
}

template <class Figures>
json times_json(const Figures& figures) {
  json times{{"p50", microseconds(figures.p50)},
             {"p99", microseconds(figures.p99)},
             {"max", microseconds(figures.max)}};
  if constexpr (requires { figures.count; }) times["count"] = figures.count;
  return times;
}

}  // namespace

FigureMethods::FigureMethods(base::rpc::Server& server, FiguresSource source)
    : server_(server), source_(std::move(source)) {
  server_.describe(port_description(CAS_VERSION));  // of all methods of the port
  const auto plain = [this](const std::string& name, json (FigureMethods::*make)() const) {
    add_look(server_, name, [this, make](CallParams& params) {
      params.finish();
      return (this->*make)();
    });
  };
  plain("casd.status", &FigureMethods::status);
  plain("link.list", &FigureMethods::links);
  plain("link.routes", &FigureMethods::routes);
  plain("link.latency", &FigureMethods::latency);
  plain("link.echo", &FigureMethods::echo);
  add_look(server_, "link.drops", [this](CallParams& params) { return drops(wish_of(params)); });
  add_look(server_, "message.list",
           [this](CallParams& params) { return messages(wish_of(params)); });
  if (source_.taps != nullptr) {
    add_look(server_, "message.value", [this](CallParams& params) { return value(params); });
  }
  server_.add_topic("links");
  server_.add_topic("messages");
  server_.add_topic("drops");
}

LinkId FigureMethods::require_link(const std::string& name) const {
  std::string known;
  for (const LinkStatus& link : source_.figures->links()) {
    if (link.name == name) return link.id;
    known += (known.empty() ? "" : ", ") + link.name;
  }
  throw BadParams("there is no link '" + name + "'; links: " + known);
}

json FigureMethods::status() const {
  const Topology& topology = source_.topology();
  json status{{"schema", 1},
              {"program", "casd"},
              {"version", CAS_VERSION},
              {"uptime_s", base::to_seconds(source_.now() - source_.started)},
              {"threads", to_string(topology.threads)},
              {"self", {{"system", topology.self.system}, {"component", topology.self.component}}},
              {"allow_not_hil", topology.commanding.allow_not_hil},
              {"clients", server_.clients()},
              {"links", links()},
              {"vehicles", source_.vehicles()}};
  if (!source_.name.empty()) status["name"] = source_.name;
  if (!source_.topology_file.empty()) status["topology"] = source_.topology_file.string();
  if (last_reload_) status["reload"] = reload_json(*last_reload_, source_.now());
  if (source_.recorder != nullptr) status["recording"] = recording_json(*source_.recorder);
  const auto logs = source_.autopilot_logs ? source_.autopilot_logs() : std::nullopt;
  if (logs) status["autopilot_logs"] = autopilot_logs_json(*logs);
  return status;
}

json FigureMethods::links() const {
  const Topology& topology = source_.topology();
  json all = json::array();
  for (const LinkStatus& link : source_.figures->links()) {
    json entry{{"name", link.name},
               {"type", to_string(link.type)},
               {"state", to_string(link.state)},
               {"endpoint", link.endpoint},
               {"rx", rx_json(link)},
               {"tx", tx_json(link)}};
    entry.update(counters_json(link, ""));
    if (source_.is_added && source_.is_added(link.name)) entry["added"] = true;
    if (const LinkConfig* const config = find_link(topology.links, link.name)) {
      const std::uint64_t baud = config->baud.size() == 1 ? config->baud.front() : link.baud;
      if (baud > 0) entry["baud"] = baud;
      if (!config->accept.read_only) {
        entry["to_not_hil"] = config->to_not_hil == ToNotHil::kStopsOnly ? "stops_only" : "all";
      }
      if (config->type == LinkType::kUdp && !config->remote.empty()) {
        entry["remote"] = config->remote;
      }
      if (config->sniffer) entry["sniffer"] = true;
      if (!config->group.empty()) entry["group"] = config->group;
      if (config->signing) {
        entry["rx"]["signatures"] = signatures_json(link);
        entry["signing"] = signing_json(link, source_.now(), signing_clock());
      }
    }
    all.push_back(std::move(entry));
  }
  return all;
}

/// {link?, limit?, offset?}.
FigureMethods::Wish FigureMethods::wish_of(CallParams& params) const {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 32;
  Wish wish;
  wish.link = params.optional_text("link");
  const auto limit = params.optional_integer("limit", 1, kMostMessages);
  const auto offset = params.optional_integer("offset", 0, kFarthest);
  params.finish();
  if (wish.link) require_link(*wish.link);
  wish.page.limit = static_cast<std::size_t>(limit.value_or(kMostMessages));
  wish.page.offset = static_cast<std::size_t>(offset.value_or(0));
  return wish;
}

json FigureMethods::messages(const Wish& wish) const {
  json all = json::array();
  for (const MessageStatus& message :
       source_.figures->messages(source_.now(), wish.link, wish.page)) {
    all.push_back(message_json(message, message_name(message.id)));
  }
  return all;
}

/// The newest packet of one message: from the tap that the first call opens, or a remembered one.
json FigureMethods::value(CallParams& params) const {
  MessageTaps::Key key;
  key.link = require_link(params.text("link"));
  key.message_id = asked_message(params.value("message"));
  key.source = {static_cast<std::uint8_t>(params.integer("system", 0, 255)),
                static_cast<std::uint8_t>(params.integer("component", 0, 255))};
  params.finish();
  const base::RunTime now = source_.now();
  json answer{{"id", key.message_id}, {"name", message_name(key.message_id)}, {"fields", nullptr}};
  std::optional<MessageTaps::Sample> sample = source_.taps->look(key, now);
  if (!sample && memory_) sample = memory_(key);
  if (sample) {
    answer["fields"] =
        source_.decoder->fields(key.message_id, std::span(sample->payload).first(sample->size));
    answer["age_s"] = base::to_seconds(now - sample->at);
    answer["count"] = sample->count;
  }
  return answer;
}

std::string FigureMethods::message_name(std::uint32_t id) const {
  if (std::string own = source_.decoder->name(id); !own.empty()) return own;
  const mav::MessageInfo* info = mav::public_table().find(id);
  return info == nullptr ? std::string() : std::string(info->name);
}

/// By name or id; names of the dialect that was read at run time go first.
std::uint32_t FigureMethods::asked_message(const json& message) const {
  if (message.is_string()) {
    if (const auto own = source_.decoder->find(message.get<std::string>())) return *own;
  }
  return message_id(message);
}

void FigureMethods::set_decoder(std::shared_ptr<const MessageDecoder> decoder) {
  source_.decoder = std::move(decoder);
}

json FigureMethods::routes() const {
  json all = json::array();
  for (const RouteConfig& route : source_.topology().routes) all.push_back(rule_json(route));
  return all;
}

/// Packets that were not sent on, by link and cause: `dropped` also by message, `unreadable` those
/// that never became a message.
json FigureMethods::drops(Wish wish) const {
  wish.page.drops_only = true;
  json dropped = json::array();
  for (const MessageStatus& message :
       source_.figures->messages(source_.now(), wish.link, wish.page)) {
    json entry = message_json(message, message_name(message.id));
    entry.erase("direction");
    entry["cause"] = to_string(message.way.cause);
    dropped.push_back(std::move(entry));
  }
  return json{{"unreadable", unreadable(wish.link)}, {"dropped", std::move(dropped)}};
}

json FigureMethods::unreadable(const std::optional<std::string>& only) const {
  json all = json::array();
  for (const LinkStatus& link : source_.figures->links()) {
    if (only && link.name != *only) continue;
    for (const LinkCounterRow& row : link_counter_rows()) {
      const std::uint64_t count = row.value(link);
      if (!row.words.cause || count == 0) continue;
      all.push_back(
          {{"link", link.name}, {"cause", to_string(*row.words.cause)}, {"count", count}});
    }
  }
  return all;
}

void FigureMethods::publish() {
  publish_link_changes();
  if (server_.has_subscribers("messages"))
    server_.publish("messages", messages({.page = {.limit = kNoticeMessages}}));
  publish_drops();
}

/// For a new subscriber also those before.
void FigureMethods::publish_drops() {
  if (!server_.has_subscribers("drops")) {
    last_dropped_ = 0;
    return;
  }
  std::uint64_t dropped = source_.figures->dropped();
  for (const json& entry : unreadable({})) dropped += entry.at("count").get<std::uint64_t>();
  if (std::exchange(last_dropped_, dropped) != dropped)
    server_.publish("drops", drops({.page = {.limit = kNoticeMessages}}));
}

void FigureMethods::publish_link_changes() {
  std::map<std::string, std::string> states;
  for (const LinkStatus& link : source_.figures->links()) {
    const std::string& state = states[link.name] = to_string(link.state);
    if (last_states_[link.name] == state) continue;
    server_.publish("links", json{{"link", link.name},
                                  {"state", state},
                                  {"endpoint", link.endpoint},
                                  {"reconnects", link.reconnects}});
  }
  last_states_ = std::move(states);  // without those of links that are gone
}

json FigureMethods::latency() const {
  json all = json::array();
  for (const LinkStatus& link : source_.figures->links()) {
    json entry = forwarding_json(link);
    entry["link"] = link.name;
    entry["routes"] = json::array();
    for (const RouteLatency::Figures& route : link.tx.routes) {
      const std::string name = link_name(route.from);
      if (name.empty()) continue;  // a packet of a link that is gone was sent only now
      json from = times_json(route);
      from["from"] = name;
      entry["routes"].push_back(std::move(from));
    }
    all.push_back(std::move(entry));
  }
  return all;
}

/// From a HIL_SENSOR in to the controls that echo its stamp.
json FigureMethods::echo() const {
  json all = json::array();
  if (source_.echo == nullptr) return all;
  for (const EchoLatency::Figures& vehicle : source_.echo->figures()) {
    json entry = times_json(vehicle);
    entry["vehicle"] = vehicle.system;
    entry["count"] = vehicle.matched;
    entry["unmatched"] = vehicle.unmatched;
    all.push_back(std::move(entry));
  }
  return all;
}

/// "casd" is its own station; empty: there is no such link.
std::string FigureMethods::link_name(LinkId id) const {
  return id == kLocalLink ? "casd" : source_.figures->name(id);
}

MetricsSource FigureMethods::metrics_source() const {
  constexpr auto kMost = static_cast<std::size_t>(kMostMessages);
  const base::RunTime now = source_.now();
  MetricsSource all{.uptime_s = base::to_seconds(now - source_.started),
                    .clients = server_.clients(),
                    .refused = {},
                    .links = source_.figures->links(),
                    .messages = source_.figures->messages(now, {}, {.limit = kMost + 1})};
  all.messages_cut = all.messages.size() > kMost;
  if (all.messages_cut) all.messages.pop_back();
  for (const json& vehicle : source_.vehicles()) {
    all.vehicles.push_back({.system = vehicle.at("system"),
                            .armed = vehicle.at("armed"),
                            .hil = vehicle.at("hil"),
                            .heartbeat_age_s = vehicle.at("heartbeat_age_s")});
  }
  if (source_.recorder != nullptr) all.recording = source_.recorder->status(source_.now());
  if (source_.autopilot_logs) all.autopilot_logs = source_.autopilot_logs();
  for (MessageStatus& message : all.messages) message.name = message_name(message.id);
  for (const auto& [why, reason] : kRefusals)
    all.refused.emplace_back(reason, server_.refused(why));
  return all;
}

}  // namespace cas::casd
