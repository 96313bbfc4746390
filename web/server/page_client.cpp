// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/page_client.hpp"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "base/rpc/token.hpp"
#include "base/rpc/token_proof.hpp"
#include "web/server/page_hub.hpp"

namespace cas::web {
namespace {

using base::rpc::BadParams;
using base::rpc::CallError;
using base::rpc::Json;
using base::rpc::Reply;

constexpr int kProtocol = 2;
constexpr std::size_t kMaxHello = 4096;  // bytes
constexpr std::size_t kShortestNonce = 16;
constexpr std::size_t kLongestNonce = 256;
constexpr std::size_t kMaxCalls = 64;  // under way
constexpr double kMaxChanges_s = 16;
constexpr std::size_t kMaxPageFields = 24;
constexpr double kMaxValue_hz = 10;
constexpr double kLowest_hz = 0.01;
constexpr int kPolicyViolation = 1008;  // [RFC 6455] 7.4.1
constexpr int kTryAgainLater = 1013;

enum class Effect : std::uint8_t {
  kNone,
  kChange,
  kRescue,  ///< changes something, and must not wait behind other changes
};

enum class Program : std::uint8_t { kCasd, kHilsim, kHils };

struct Passed {
  const char* name;
  Program program;
  Effect effect;
};

// Calls that a page may make to casd, hilsim and hils. `vehicle.command` and `sim.quit` are left
// out: no button needs them.
constexpr Passed kPassed[] = {
    {"casd.status", Program::kCasd, Effect::kNone},
    {"link.list", Program::kCasd, Effect::kNone},
    {"link.routes", Program::kCasd, Effect::kNone},
    {"link.drops", Program::kCasd, Effect::kNone},
    {"link.latency", Program::kCasd, Effect::kNone},
    {"link.echo", Program::kCasd, Effect::kNone},
    {"message.list", Program::kCasd, Effect::kNone},
    {"message.value", Program::kCasd, Effect::kNone},
    {"vehicle.state", Program::kCasd, Effect::kNone},
    {"vehicle.telemetry", Program::kCasd, Effect::kNone},
    {"gain.get", Program::kCasd, Effect::kNone},
    {"gain.list", Program::kCasd, Effect::kNone},
    {"param.get", Program::kCasd, Effect::kNone},
    {"param.list", Program::kCasd, Effect::kNone},
    {"log.status", Program::kCasd, Effect::kNone},
    {"vehicle.arm", Program::kCasd, Effect::kChange},
    {"vehicle.disarm", Program::kCasd, Effect::kRescue},
    {"vehicle.takeoff", Program::kCasd, Effect::kChange},
    {"vehicle.land", Program::kCasd, Effect::kRescue},
    {"vehicle.hold", Program::kCasd, Effect::kRescue},
    {"vehicle.rtl", Program::kCasd, Effect::kChange},
    {"vehicle.reboot", Program::kCasd, Effect::kChange},
    {"vehicle.goto", Program::kCasd, Effect::kChange},
    {"vehicle.mode", Program::kCasd, Effect::kChange},
    {"vehicle.message_interval", Program::kCasd, Effect::kChange},
    {"gain.set", Program::kCasd, Effect::kChange},
    {"param.set", Program::kCasd, Effect::kChange},
    {"log.start", Program::kCasd, Effect::kChange},
    {"log.stop", Program::kCasd, Effect::kChange},
    {"sim.status", Program::kHilsim, Effect::kNone},
    {"sim.scene", Program::kHilsim, Effect::kNone},
    {"sim.pause", Program::kHilsim, Effect::kChange},
    {"sim.resume", Program::kHilsim, Effect::kChange},
    {"sim.step", Program::kHilsim, Effect::kChange},
    {"sim.reset", Program::kHilsim, Effect::kChange},
    {"fault.list", Program::kHils, Effect::kNone},
    {"fault.inject", Program::kHils, Effect::kChange},
};

std::uint64_t next_number() {
  static std::uint64_t number = 0;  // of one thread
  return ++number;
}

Upstream* upstream_of(PageHub& hub, Program program) {
  if (program == Program::kCasd) return &hub.casd();
  return program == Program::kHilsim ? &hub.hilsim() : hub.hils();
}

/// The text of that key; nullopt where there is none.
std::optional<std::string> text_of(const Json& params, const char* key) {
  if (!params.is_object()) return std::nullopt;
  const auto found = params.find(key);
  if (found == params.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

void refuse_unknown(const Json& params, const std::set<std::string>& known) {
  if (!params.is_object()) throw BadParams("parameters are named");
  for (const auto& [key, value] : params.items()) {
    if (!known.contains(key)) throw BadParams("there is no parameter '" + key + "'");
  }
}

}  // namespace

PageClient::PageClient(PageHub& hub, const PageAccess& access, const std::string& host,
                       Socket socket)
    : hub_(hub),
      access_(access),
      socket_(std::move(socket)),
      number_(next_number()),
      changes_(kMaxChanges_s, base::steady_now()) {
  authorised = false;
  proof.endpoint = host;
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
         {{"code", base::rpc::kNotAuthorised}, {"message", "call hello {\"nonce\": ...} first"}});
}

/// Before `hello` no text of a client reaches the dispatcher.
void PageClient::answer(const Json& request, const char* key, Json value) {
  Json id = request.is_object() ? request.value("id", Json()) : Json();
  if (id.is_structured()) id = nullptr;
  deliver(Json{{"jsonrpc", "2.0"}, {"id", std::move(id)}, {key, std::move(value)}}.dump(
      -1, ' ', false, Json::error_handler_t::replace));
}

/// First the nonces: casweb proves that it knows the token, then the page does. The token itself is
/// never sent, and a proof is valid for one connection.
void PageClient::hello(const Json& request) {
  const auto refuse = [&](int code, const std::string& why) {
    answer(request, "error", {{"code", code}, {"message", why}});
  };
  const Json params = request.value("params", Json());
  if (const auto nonce = text_of(params, "nonce")) {
    if (nonce->size() < kShortestNonce || nonce->size() > kLongestNonce) {
      return refuse(base::rpc::kInvalidParams, "nonce has 16 to 256 characters");
    }
    proof.client_nonce = *nonce;
    proof.server_nonce = base::rpc::make_nonce();
    return answer(
        request, "result",
        {{"nonce", proof.server_nonce},
         {"proof", base::rpc::token_proof(access_.token, base::rpc::Prover::kServer, proof)}});
  }
  const auto given = text_of(params, "proof");
  if (!given || proof.server_nonce.empty() ||
      !base::rpc::same_token(
          base::rpc::token_proof(access_.token, base::rpc::Prover::kClient, proof), *given)) {
    refused_ = true;
    refuse(base::rpc::kNotAuthorised,
           "the proof of the token is wrong: open the address that casweb printed");
    return socket_.refuse_token();
  }
  const auto protocol = params.find("protocol");
  if (protocol == params.end() || *protocol != kProtocol) {
    return refuse(base::rpc::kInvalidParams, "this casweb speaks protocol 2: reload the page");
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
  for (const auto& [method_name, server, effect] : kPassed) {
    if (effect != Effect::kNone && access_.read_only) {
      add_refused(method_name);
    } else {
      add_passed(method_name, upstream_of(hub_, server), effect == Effect::kChange);
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
    const Json& vehicle = params.at("vehicle");
    const std::int64_t system = vehicle.is_number_integer() ? vehicle.get<std::int64_t>() : 0;
    if (system < 1 || system > 255) {
      throw BadParams("vehicle is a whole number from 1 to 255");
    }
    if (!hub_.take_pilot(number_, static_cast<int>(system), base::steady_now())) {
      throw CallError(base::rpc::kRefused, "another page moves the sticks of this vehicle");
    }
    reply.result(true);
  });
}

void PageClient::add_refused(const char* method_name) {
  dispatcher_.add_method(method_name, [](const Json&, const Reply&) {
    throw CallError(base::rpc::kNotAuthorised, "this casweb is read-only");
  });
}

void PageClient::add_passed(const char* method_name, Upstream* to, bool is_limited) {
  methods_.emplace_back(method_name);
  dispatcher_.add_method(method_name, [this, method = std::string(method_name), to, is_limited](
                                          const Json& params, const Reply& reply) {
    if (to == nullptr) {
      throw CallError(base::rpc::kRefused, "no run of hils is shown here");
    }
    if (is_limited && !may_change()) {
      throw CallError(base::rpc::kRefused, "over 16 changes in a second: wait");
    }
    pass(method, *to, params, reply);
  });
}

/// A refused change costs nothing: a page that repeats it gets its next turn all the same.
bool PageClient::may_change() {
  base::rpc::LineRate after = changes_;
  if (after.take(base::steady_now()) > base::Duration::zero()) return false;
  changes_ = after;
  return true;
}

/// The programs check the calls; only casd's interlock must not be overridden from here.
void PageClient::pass(const std::string& method, Upstream& to, const Json& params,
                      const Reply& reply) {
  if (calls > kMaxCalls) {
    throw CallError(base::rpc::kRefused, "over 64 calls of this page are under way");
  }
  if (params.is_object() && params.contains("not_hil")) {
    throw CallError(base::rpc::kInterlock,
                    "a page does not overrule the interlock: use casctl --not-hil");
  }
  to.call(method, params, reply);
}

void PageClient::watch(const Json& params, const Reply& reply) {
  refuse_unknown(params, {"topics"});
  std::map<std::string, SnapshotFlow, std::less<>> flows;
  for (const auto& [topic, hz] : params.at("topics").get_ref<const Json::object_t&>()) {
    const auto most = hub_.rate_of(topic);
    if (!most) {
      throw BadParams("there is no topic '" + topic + "'");
    }
    const double wanted_hz = std::clamp(hz.get<double>(), kLowest_hz, *most);
    const auto before = flows_.find(topic);
    SnapshotFlow flow = before == flows_.end() ? SnapshotFlow(wanted_hz) : before->second;
    flow.set_rate(wanted_hz);  // keeps a continued topic's snapshots in flight
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
  refuse_unknown(params, {"link", "message", "system", "component", "fields", "hz"});
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
                      (watched_fields() + fields > kMaxPageFields || !hub_.has_room_for(fields)))) {
    throw CallError(base::rpc::kRefused,
                    "a page watches 1 to 24 fields, and all pages together 96");
  }
  values_.insert_or_assign(key, std::move(watch));
  reply.result({{"key", key}});
  hub_.on_wanted("value");
}

void PageClient::unwatch_message(const Json& params, const Reply& reply) {
  reply.result(values_.erase(params.at("key").get<std::string>()) > 0);
}

/// Sticks are repeated: they count as no change, and a page that stops sending them is no longer
/// the pilot.
void PageClient::move_sticks(const Json& params, const Reply& reply) {
  if (!hub_.is_pilot(number_, params.at("vehicle").get<int>(), base::steady_now())) {
    throw CallError(base::rpc::kRefused, "call pilot.take {\"vehicle\": ...} first");
  }
  pass("vehicle.manual_control", hub_.casd(), params, reply);
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
