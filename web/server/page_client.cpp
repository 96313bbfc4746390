// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/page_client.hpp"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/rpc/token.hpp"
#include "web/server/page_hub.hpp"

namespace cas::web {
namespace {

using base::rpc::Json;
using base::rpc::Reply;

constexpr int kProtocol = 1;
constexpr std::size_t kMaxHello = 4096;  // bytes
constexpr std::size_t kMaxCalls = 64;    // under way
constexpr double kMaxChanges_s = 16;
constexpr std::size_t kMaxFields = 24;
constexpr double kMaxValue_hz = 10;
constexpr double kLowest_hz = 0.01;
constexpr int kPolicyViolation = 1008;  // [RFC 6455] 7.4.1
constexpr int kTryAgainLater = 1013;

enum class Effect : std::uint8_t {
  kNone,
  kChange,
  kRescue,  ///< changes something, and must not wait behind other changes
};

struct Passed {
  const char* name;
  bool to_casd;
  Effect effect;
};

// What a page may ask of casd and hilsim. `vehicle.command` and `sim.quit` are left out: no button
// needs them.
constexpr Passed kPassed[] = {
    {"casd.status", true, Effect::kNone},
    {"link.list", true, Effect::kNone},
    {"link.routes", true, Effect::kNone},
    {"link.drops", true, Effect::kNone},
    {"link.latency", true, Effect::kNone},
    {"link.echo", true, Effect::kNone},
    {"message.list", true, Effect::kNone},
    {"message.value", true, Effect::kNone},
    {"vehicle.state", true, Effect::kNone},
    {"vehicle.telemetry", true, Effect::kNone},
    {"gain.get", true, Effect::kNone},
    {"gain.list", true, Effect::kNone},
    {"param.get", true, Effect::kNone},
    {"param.list", true, Effect::kNone},
    {"log.status", true, Effect::kNone},
    {"vehicle.arm", true, Effect::kChange},
    {"vehicle.disarm", true, Effect::kRescue},
    {"vehicle.takeoff", true, Effect::kChange},
    {"vehicle.land", true, Effect::kRescue},
    {"vehicle.hold", true, Effect::kRescue},
    {"vehicle.rtl", true, Effect::kChange},
    {"vehicle.reboot", true, Effect::kChange},
    {"vehicle.goto", true, Effect::kChange},
    {"vehicle.mode", true, Effect::kChange},
    {"vehicle.message_interval", true, Effect::kChange},
    {"gain.set", true, Effect::kChange},
    {"param.set", true, Effect::kChange},
    {"log.start", true, Effect::kChange},
    {"log.stop", true, Effect::kChange},
    {"sim.status", false, Effect::kNone},
    {"sim.scene", false, Effect::kNone},
    {"sim.pause", false, Effect::kChange},
    {"sim.resume", false, Effect::kChange},
    {"sim.step", false, Effect::kChange},
    {"sim.reset", false, Effect::kChange},
};

std::uint64_t next_number() {
  static std::uint64_t number = 0;  // of one thread
  return ++number;
}

/// What is wrong with the names of parameters; empty: nothing.
std::string unknown_key(const Json& params, const std::set<std::string>& known) {
  if (!params.is_object()) return "parameters are named";
  for (const auto& [key, value] : params.items()) {
    if (!known.contains(key)) return "there is no parameter '" + key + "'";
  }
  return {};
}

}  // namespace

PageClient::PageClient(PageHub& hub, const PageAccess& access, Socket socket)
    : hub_(hub),
      access_(access),
      socket_(std::move(socket)),
      number_(next_number()),
      changes_(kMaxChanges_s, base::steady_now()) {
  authorised = false;
  add_methods();
}

PageClient::~PageClient() = default;

void PageClient::on_text(std::string_view text) {
  if (authorised) {
    dispatcher_.handle(text, shared_from_this());
    return;
  }
  if (refused_) return;
  // A stranger's text must not nest so deep that a copy of it takes the whole stack.
  const Json request = text.size() > kMaxHello ? Json() : Json::parse(text, nullptr, false);
  const auto method = request.find("method");
  if (method != request.end() && *method == "hello") return hello(request);
  answer(request, "error",
         {{"code", base::rpc::kNotAuthorised}, {"message", "call hello {\"token\": ...} first"}});
}

/// Before `hello` nothing of what a stranger sends is given to the dispatcher.
void PageClient::answer(const Json& request, const char* key, Json value) {
  Json id = request.is_object() ? request.value("id", Json()) : Json();
  if (id.is_structured()) id = nullptr;
  deliver(Json{{"jsonrpc", "2.0"}, {"id", std::move(id)}, {key, std::move(value)}}.dump(
      -1, ' ', false, Json::error_handler_t::replace));
}

void PageClient::hello(const Json& request) {
  const auto refuse = [&](int code, const std::string& why) {
    answer(request, "error", {{"code", code}, {"message", why}});
  };
  const Json params = request.value("params", Json::object());
  const auto token = params.find("token");
  if (!params.is_object() || token == params.end() || !token->is_string() ||
      !base::rpc::same_token(access_.token, token->get_ref<const std::string&>())) {
    refused_ = true;
    refuse(base::rpc::kNotAuthorised, "the token is wrong: open the address that casweb printed");
    return socket_.refuse_token();
  }
  const auto protocol = params.find("protocol");
  if (protocol == params.end() || *protocol != kProtocol) {
    return refuse(base::rpc::kInvalidParams, "this casweb speaks protocol 1: reload the page");
  }
  if (!hub_.has_place()) {
    refused_ = true;
    refuse(base::rpc::kRefused, "16 pages are open: close one");
    return socket_.close(kTryAgainLater, "16 pages are open");
  }
  authorised = true;
  Json greeting = hub_.greeting();
  greeting["protocol"] = kProtocol;
  greeting["read_only"] = access_.read_only;
  greeting["methods"] = methods_;
  answer(request, "result", std::move(greeting));
  hub_.add(shared_from_this());
}

void PageClient::add_methods() {
  add_own_methods();
  for (const auto& [method_name, to_casd, effect] : kPassed) {
    if (effect != Effect::kNone && access_.read_only) {
      add_refused(method_name);
    } else {
      add_passed(method_name, to_casd, effect == Effect::kChange);
    }
  }
  for (const char* method_name :
       {"ack", "watch", "unwatch", "bench.status", "message.watch", "message.unwatch"}) {
    methods_.emplace_back(method_name);
  }
  if (!access_.read_only) {
    methods_.emplace_back("pilot.take");
    methods_.emplace_back("vehicle.manual_control");
  }
  std::sort(methods_.begin(), methods_.end());
}

void PageClient::add_own_methods() {
  const auto add = [this](const char* method_name,
                          void (PageClient::*method)(const Json&, const Reply&)) {
    dispatcher_.add_method(method_name, [this, method](const Json& params, const Reply& reply) {
      (this->*method)(params, reply);
    });
  };
  add("ack", &PageClient::on_ack);
  add("watch", &PageClient::watch);
  add("message.watch", &PageClient::watch_message);
  add("message.unwatch", &PageClient::unwatch_message);
  dispatcher_.add_method("unwatch", [this](const Json&, const Reply& reply) {
    flows_.clear();
    reply.result(true);
  });
  dispatcher_.add_method("bench.status", [this](const Json&, const Reply& reply) {
    reply.result(hub_.bench_status());
  });
  if (access_.read_only) {
    add_refused("pilot.take");
    return add_refused("vehicle.manual_control");
  }
  add("vehicle.manual_control", &PageClient::move_sticks);
  dispatcher_.add_method("pilot.take", [this](const Json& params, const Reply& reply) {
    const auto system = params.at("vehicle").get<std::uint8_t>();
    if (hub_.take_pilot(number_, system, base::steady_now())) return reply.result(true);
    reply.error(base::rpc::kRefused, "another page moves the sticks of this vehicle", nullptr);
  });
}

void PageClient::add_refused(const char* method_name) {
  dispatcher_.add_method(method_name, [](const Json&, const Reply& reply) {
    reply.error(base::rpc::kNotAuthorised, "this casweb is read-only", nullptr);
  });
}

void PageClient::add_passed(const char* method_name, bool to_casd, bool is_limited) {
  methods_.emplace_back(method_name);
  dispatcher_.add_method(method_name, [this, method = std::string(method_name), to_casd,
                                       is_limited](const Json& params, const Reply& reply) {
    if (is_limited && !may_change()) {
      return reply.error(base::rpc::kRefused, "over 16 changes in a second: wait", nullptr);
    }
    pass(method, to_casd, params, reply);
  });
}

/// A refused change costs nothing: a page that repeats it gets its next turn all the same.
bool PageClient::may_change() {
  base::rpc::LineRate after = changes_;
  if (after.take(base::steady_now()) > base::Duration::zero()) return false;
  changes_ = after;
  return true;
}

/// casd and hilsim judge what is asked; only their interlock is not to be overruled from here.
void PageClient::pass(const std::string& method, bool to_casd, const Json& params,
                      const Reply& reply) {
  if (calls > kMaxCalls) {
    return reply.error(base::rpc::kRefused, "over 64 calls of this page are under way", nullptr);
  }
  if (params.is_object() && params.contains("not_hil")) {
    return reply.error(base::rpc::kInterlock,
                       "a page does not overrule the interlock: use casctl --not-hil", nullptr);
  }
  (to_casd ? hub_.casd() : hub_.hilsim()).call(method, params, reply);
}

void PageClient::watch(const Json& params, const Reply& reply) {
  if (const std::string fault = unknown_key(params, {"topics"}); !fault.empty()) {
    return reply.error(base::rpc::kInvalidParams, fault, nullptr);
  }
  std::map<std::string, SnapshotFlow, std::less<>> flows;
  for (const auto& [topic, hz] : params.at("topics").get_ref<const Json::object_t&>()) {
    const auto most = hub_.rate_of(topic);
    if (!most) {
      return reply.error(base::rpc::kInvalidParams, "there is no topic '" + topic + "'", nullptr);
    }
    const double wanted_hz = std::clamp(hz.get<double>(), kLowest_hz, *most);
    const auto before = flows_.find(topic);
    SnapshotFlow flow = before == flows_.end() ? SnapshotFlow(wanted_hz) : before->second;
    flow.set_rate(wanted_hz);  // a topic that goes on keeps what is in flight
    flows.emplace(topic, flow);
  }
  flows_ = std::move(flows);
  reply.result(true);
  for (const auto& [topic, flow] : flows_) hub_.on_wanted(topic);
}

void PageClient::on_ack(const Json& params, const Reply& reply) {
  const std::string topic = params.at("topic").get<std::string>();
  const auto flow = flows_.find(topic);
  if (flow != flows_.end() && flow->second.on_ack(params.at("seq").get<std::uint64_t>())) {
    hub_.on_wanted(topic);
  }
  reply.result(true);
}

void PageClient::watch_message(const Json& params, const Reply& reply) {
  if (const std::string fault =
          unknown_key(params, {"link", "message", "system", "component", "fields", "hz"});
      !fault.empty()) {
    return reply.error(base::rpc::kInvalidParams, fault, nullptr);
  }
  ValueWatch watch{.link = params.at("link"),
                   .message = params.at("message"),
                   .system = params.at("system"),
                   .component = params.at("component"),
                   .fields = params.at("fields")};
  watch.period = base::from_seconds(
      1 / std::clamp(params.value("hz", kMaxValue_hz), kLowest_hz, kMaxValue_hz));
  std::string key = watch.link + "/" + watch.message + "/" + std::to_string(watch.system) + "/" +
                    std::to_string(watch.component) + "/";
  for (const std::string& field : watch.fields) key += (key.back() == '/' ? "" : ",") + field;
  const std::size_t fields = watch.fields.size();
  if (fields == 0 || (!values_.contains(key) &&
                      (watched_fields() + fields > kMaxFields || !hub_.has_room_for(fields)))) {
    return reply.error(base::rpc::kRefused,
                       "a page watches 1 to 24 fields, and all pages together 96", nullptr);
  }
  values_.insert_or_assign(key, std::move(watch));
  reply.result({{"key", key}});
  hub_.on_wanted("value");
}

void PageClient::unwatch_message(const Json& params, const Reply& reply) {
  reply.result(values_.erase(params.at("key").get<std::string>()) > 0);
}

/// Sticks are repeated: they count as no change, and who lets go of them is no pilot any longer.
void PageClient::move_sticks(const Json& params, const Reply& reply) {
  if (!hub_.is_pilot(number_, params.at("vehicle").get<int>(), base::steady_now())) {
    return reply.error(base::rpc::kRefused, "call pilot.take {\"vehicle\": ...} first", nullptr);
  }
  pass("vehicle.manual_control", true, params, reply);
}

void PageClient::deliver(std::string line) {
  socket_.send(std::make_shared<const std::string>(std::move(line)));
}

void PageClient::on_refused() { socket_.close(kPolicyViolation, "no JSON-RPC"); }

bool PageClient::wants(const std::string& topic, base::RunTime now) const {
  const auto flow = flows_.find(topic);
  return flow != flows_.end() && flow->second.wants(now);
}

bool PageClient::waits(const std::string& topic) const {
  const auto flow = flows_.find(topic);
  return flow != flows_.end() && flow->second.waits();
}

void PageClient::send_snapshot(const std::string& topic, std::uint64_t seq, const Text& text,
                               base::RunTime now) {
  flows_.find(topic)->second.on_sent(seq, now);
  socket_.send(text);
}

std::size_t PageClient::watched_fields() const {
  std::size_t fields = 0;
  for (const auto& [key, watch] : values_) fields += watch.fields.size();
  return fields;
}

}  // namespace cas::web
