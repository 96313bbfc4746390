// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/page_hub.hpp"

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "base/os/log.hpp"
#include "base/rpc/base64.hpp"
#include "web/server/link_report.hpp"
#include "web/server/page_client.hpp"

namespace cas::web {
namespace {

namespace asio = boost::asio;
using base::rpc::Json;
using base::rpc::Reply;

constexpr std::size_t kMaxFields = 96;         // watched by all pages
constexpr std::size_t kMaxSamples = 50;        // of one value between two frames
constexpr std::size_t kMaxMeshes = 64U << 20;  // bytes kept, and as many under way
constexpr std::size_t kMaxRows = 2000;         // of messages; those that were heard first
constexpr std::size_t kMaxPages = 16;
constexpr auto kMaxClockAge = std::chrono::seconds(1);
constexpr auto kPilotSilence = std::chrono::milliseconds(500);
constexpr const char* kCasdTopics[] = {"links", "drops", "statustext"};
constexpr const char* kHilsTopics[] = {"fault", "verdict"};

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

PageClient::Text frame(const std::string& method, Json params) {
  return std::make_shared<const std::string>(
      text_of({{"jsonrpc", "2.0"}, {"method", method}, {"params", std::move(params)}}));
}

/// Passes a program's answer on; nullptr if it refuses.
Reply taker(std::function<void(const Json* answer)> take) {
  return {[take](const Json& answer) { take(&answer); },
          [take](int, const std::string&, const Json&) { take(nullptr); }};
}

struct Question {
  std::string method;
  Json params{};
};

/// The values of the watched fields, in their order; null for one that is not there.
Json sample_of(const ValueWatch& watch, const Json& fields, double t_s) {
  Json sample = Json::array({t_s});
  for (const std::string& wanted : watch.fields) {
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const Json& each) {
      return each.value("name", "") == wanted;
    });
    sample.push_back(field == fields.end() ? Json() : field->value("value", Json()));
  }
  return sample;
}

}  // namespace

struct PageHub::Impl : std::enable_shared_from_this<PageHub::Impl> {
  /// Takes a sample, now or later; nothing when there is no new one.
  using Take = std::function<void(const Json* params)>;

  struct Topic {
    Topic(asio::io_context& io, double rate_hz, std::function<void(const Take&)> ask_in)
        : hz(rate_hz), period(base::from_seconds(1 / rate_hz)), timer(io), ask(std::move(ask_in)) {}
    double hz;
    base::Duration period;
    asio::steady_timer timer;
    bool armed = false;    // the timer runs, or a sample is under way
    base::RunTime next{};  // earliest moment of the next question
    std::uint64_t seq = 0;
    std::function<void(const Take&)> ask;
  };

  struct Program {
    const char* name;
    std::shared_ptr<Upstream> upstream;
    Json version{};  // null while it is away
  };

  /// With each topic, and how often it is asked for at most, Hz.
  Impl(asio::io_context& io_in, Config config_in) : io(io_in), config(std::move(config_in)) {
    const auto add = [this](const char* name, double hz, void (Impl::*ask)(const Take&)) {
      topics.try_emplace(name, io, hz, [this, ask](const Take& take) { (this->*ask)(take); });
    };
    add("sim", 60, &Impl::ask_sim);
    add("clouds", 5, &Impl::ask_clouds);
    add("links", 2, &Impl::ask_links);
    add("loop", 1, &Impl::ask_loop);
    add("messages", 1, &Impl::ask_messages);
    add("value", 10, &Impl::ask_values);
    add("vehicle", 10, &Impl::ask_vehicles);
    if (!config.find_hils) return;
    add("ref", 20, &Impl::ask_reference);
    add("verdict", 2, &Impl::ask_verdict);
  }

  // ---- programs

  void start() {
    make_program(casd, "casd", config.find_casd);
    make_program(hilsim, "hilsim", config.find_hilsim);
    if (config.find_hils) make_program(hils, "hils", config.find_hils);
    casd.upstream->start();
    hilsim.upstream->start();
    if (hils.upstream) hils.upstream->start();
  }

  void make_program(Program& program, const char* name, const Upstream::Find& find) {
    program.name = name;
    const auto weak = weak_from_this();
    Upstream::Handlers handlers;
    handlers.on_up = [weak, &program] {
      if (const auto self = weak.lock()) self->on_up(program);
    };
    handlers.on_down = [weak, &program] {
      if (const auto self = weak.lock()) self->on_down(program);
    };
    handlers.on_notification = [weak](const std::string& topic, const Json& params) {
      if (const auto self = weak.lock()) self->on_notification(topic, params);
    };
    program.upstream = std::make_shared<Upstream>(io, name, find, std::move(handlers));
  }

  void on_up(Program& program) {
    const auto weak = weak_from_this();
    program.upstream->call("rpc.discover", Json(), taker([weak, &program](const Json* document) {
                             const auto self = weak.lock();
                             if (!self || document == nullptr) return;
                             program.version =
                                 document->value("info", Json::object()).value("version", "?");
                             self->tell_program(program);
                           }));
    if (&program == &casd) return subscribe(program, kCasdTopics);
    if (&program == &hils) return subscribe(program, kHilsTopics);
    look_at_scene();
  }

  static void subscribe(const Program& program, std::span<const char* const> topics_of_it) {
    for (const char* topic : topics_of_it) {
      program.upstream->call("subscribe", {{"topic", topic}}, taker([](const Json*) {}));
    }
  }

  void on_down(Program& program) {
    base::log::info(std::string(program.name) + ": " + program.upstream->reason());
    program.version = nullptr;
    if (&program == &hilsim) has_sim = false;
    tell_program(program);
  }

  Json program_json(const Program& program) const {
    const Upstream& upstream = *program.upstream;
    if (!upstream.up()) {
      return {{"name", program.name}, {"state", "down"}, {"reason", upstream.reason()}};
    }
    return {{"name", program.name},
            {"state", "up"},
            {"version", program.version},
            {"age_s", base::to_seconds(base::steady_now() - upstream.heard())}};
  }

  void tell_program(const Program& program) { tell("event.program", program_json(program)); }

  /// Another hilsim may simulate something else.
  void look_at_scene() {
    hilsim.upstream->call("sim.scene", Json(), taker([weak = weak_from_this()](const Json* scene) {
                            const auto self = weak.lock();
                            if (!self || scene == nullptr) return;
                            const std::string hash = scene->value("hash", "");
                            if (std::exchange(self->scene_hash, hash) == hash) return;
                            self->tell("event.scene", {{"hash", hash}});
                          }));
    ask_sim([](const Json*) {});  // for the clock of the greeting
  }

  // ---- events

  void on_notification(const std::string& topic, const Json& params) {
    if (topic == "links") return tell("event.link", params);
    if (topic == "drops") return tell("event.drops", params);
    if (topic == "statustext") return tell("event.statustext", params);
    if (topic == "fault") return tell("event.fault", params);
    if (topic != "verdict") return;
    tell("event.verdict", params);
    hils.upstream->call("run.told", Json(), taker([](const Json*) {}));
  }

  void tell(const std::string& method, Json params) {
    params["seq"] = ++events;
    const PageClient::Text text = frame(method, std::move(params));
    for (const auto& client : clients()) client->send(text);
  }

  std::vector<std::shared_ptr<PageClient>> clients() {
    std::vector<std::shared_ptr<PageClient>> there;
    std::erase_if(pages, [&](const std::weak_ptr<PageClient>& page) {
      const auto client = page.lock();
      if (client) there.push_back(client);
      return client == nullptr;
    });
    return there;
  }

  // ---- snapshots

  void on_wanted(const std::string& name) {
    const auto found = topics.find(name);
    if (found != topics.end() && !found->second.armed) arm(name, found->second);
  }

  void arm(const std::string& name, Topic& topic) {
    topic.armed = true;
    topic.timer.expires_after(std::max(topic.next - base::steady_now(), base::Duration::zero()));
    topic.timer.async_wait([weak = weak_from_this(), name, &topic](const auto& error) {
      const auto self = weak.lock();
      if (self && !error && !self->closed) self->question(name, topic);
    });
  }

  void question(const std::string& name, Topic& topic) {
    const auto pages_now = clients();
    const bool waited_for = std::any_of(pages_now.begin(), pages_now.end(),
                                        [&](const auto& page) { return page->waits(name); });
    if (!waited_for) {
      topic.armed = false;  // on_wanted() goes on
      return;
    }
    const base::RunTime now = base::steady_now();
    topic.next = std::max(topic.next + topic.period, now);
    const bool due = std::any_of(pages_now.begin(), pages_now.end(),
                                 [&](const auto& page) { return page->wants(name, now); });
    if (!due) return arm(name, topic);
    // The topic goes on when the last holder of the question releases it, also when a malformed
    // answer ends it with an exception.
    const std::shared_ptr<void> goes_on(nullptr, [weak = weak_from_this(), name, &topic](void*) {
      const auto self = weak.lock();
      if (self && !self->closed) self->arm(name, topic);
    });
    topic.ask([weak = weak_from_this(), name, &topic, goes_on](const Json* params) {
      const auto self = weak.lock();
      if (self && !self->closed && params != nullptr) self->spread(name, topic, *params);
    });
  }

  void spread(const std::string& name, Topic& topic, Json params) {
    params["seq"] = ++topic.seq;
    const PageClient::Text text = frame("snap." + name, std::move(params));
    const base::RunTime now = base::steady_now();
    for (const auto& client : clients()) {
      if (client->wants(name, now)) client->send_snapshot(name, topic.seq, text, now);
    }
  }

  void ask_reference(const Take& take) {
    hils.upstream->call("run.reference", Json(), taker(take));
  }
  void ask_verdict(const Take& take) { hils.upstream->call("run.status", Json(), taker(take)); }

  void ask_clouds(const Take& take) { hilsim.upstream->call("sim.clouds", Json(), taker(take)); }

  void ask_sim(const Take& take) {
    hilsim.upstream->call("sim.watch", Json(),
                          taker([weak = weak_from_this(), take](const Json* answer) {
                            const auto self = weak.lock();
                            if (!self || answer == nullptr) return take(nullptr);
                            self->keep_sim(*answer, take);
                          }));
  }

  void keep_sim(Json answer, const Take& take) {
    answer.erase("steps");
    has_sim = true;
    sim_t_s = answer.value("t_s", 0.0);
    sim_rate = answer.value("paused", false) ? 0 : answer.value("rate", 0.0);
    sim_paused = answer.value("paused", false);
    sim_at = base::steady_now();
    take(&answer);
  }

  /// Asks casd for several things; takes all answers, or nothing when one is refused.
  void ask_casd(const std::vector<Question>& questions,
                std::function<void(const std::vector<Json>* answers)> take) {
    struct Answers {
      std::vector<Json> list;
      std::size_t open = 0;
      bool failed = false;
    };
    const auto answers = std::make_shared<Answers>();
    answers->list.resize(questions.size());
    answers->open = questions.size();
    if (questions.empty()) return take(&answers->list);
    for (std::size_t i = 0; i < questions.size(); ++i) {
      casd.upstream->call(questions[i].method, questions[i].params,
                          taker([answers, take, i](const Json* answer) {
                            answers->failed |= answer == nullptr;
                            if (answer != nullptr) answers->list[i] = *answer;
                            if (--answers->open > 0) return;
                            take(answers->failed ? nullptr : &answers->list);
                          }));
    }
  }

  void ask_links(const Take& take) {
    ask_casd({Question{"link.list"}, Question{"message.list", {{"limit", kMaxRows}}},
              Question{"link.latency"}},
             [weak = weak_from_this(), take](const std::vector<Json>* answers) {
               const auto self = weak.lock();
               if (!self || answers == nullptr) return take(nullptr);
               const Json report = self->link_report.make((*answers)[0], (*answers)[1],
                                                          (*answers)[2], base::steady_now());
               take(&report);
             });
  }

  void ask_loop(const Take& take) {
    ask_casd({Question{"link.echo"}}, [take](const std::vector<Json>* answers) {
      if (answers == nullptr) return take(nullptr);
      Json vehicles = Json::array();
      for (const Json& echo : answers->front()) {
        const auto ms = [&](const char* key) { return 1e-3 * echo.value(key, 0.0); };
        vehicles.push_back({{"system", echo.value("vehicle", 0)},
                            {"ms", {{"p50", ms("p50")}, {"p99", ms("p99")}, {"max", ms("max")}}},
                            {"count", echo.value("count", 0)},
                            {"unmatched", echo.value("unmatched", 0)}});
      }
      const Json report{{"measured", "echo"}, {"vehicles", std::move(vehicles)}};
      take(&report);
    });
  }

  void ask_messages(const Take& take) {
    ask_casd({Question{"message.list", {{"limit", kMaxRows}}}},
             [take](const std::vector<Json>* answers) {
               if (answers == nullptr) return take(nullptr);
               const Json report{{"messages", answers->front()}};
               take(&report);
             });
  }

  /// Which vehicles there are changes seldom: it is asked once a second.
  void ask_vehicles(const Take& take) {
    const base::RunTime now = base::steady_now();
    if (now < systems_end) return ask_states(take);
    ask_casd({Question{"casd.status"}},
             [weak = weak_from_this(), take, now](const std::vector<Json>* answers) {
               const auto self = weak.lock();
               if (!self || answers == nullptr) return take(nullptr);
               self->systems.clear();
               for (const Json& vehicle : answers->front().value("vehicles", Json::array())) {
                 self->systems.insert(vehicle.value("system", 0));
               }
               self->systems_end = now + std::chrono::seconds(1);
               self->ask_states(take);
             });
  }

  void ask_states(const Take& take) {
    std::vector<Question> questions;
    for (const int system : systems) {
      questions.push_back(Question{"vehicle.state", {{"vehicle", system}}});
      questions.push_back(Question{"vehicle.telemetry", {{"vehicle", system}}});
    }
    ask_casd(questions, [take](const std::vector<Json>* answers) {
      if (answers == nullptr) return take(nullptr);
      Json vehicles = Json::array();
      for (std::size_t i = 0; i < answers->size(); i += 2) {
        vehicles.push_back({{"state", (*answers)[i]}, {"telemetry", (*answers)[i + 1]}});
      }
      const Json report{{"vehicles", std::move(vehicles)}};
      take(&report);
    });
  }

  // ---- values: each page has samples of its own

  using MessageKey = std::tuple<std::string, std::string, int, int>;

  static MessageKey key_of(const ValueWatch& watch) {
    return {watch.link, watch.message, watch.system, watch.component};
  }

  /// Samples have the simulated time, which is read off hilsim's clock at least once a second.
  void ask_values(const Take& take) {
    if (!hilsim.upstream->up() || has_fresh_clock()) return ask_due_values(take);
    ask_sim([weak = weak_from_this(), take](const Json*) {
      if (const auto self = weak.lock()) self->ask_due_values(take);
    });
  }

  /// Each message that is due for some page is asked for once.
  void ask_due_values(const Take& take) {
    const base::RunTime now = base::steady_now();
    std::set<MessageKey> due;
    for (const auto& client : clients()) {
      for (auto& [key, watch] : client->values()) {
        if (now + watch.period / 4 < watch.next) continue;
        watch.next = std::max(watch.next + watch.period, now);
        due.insert(key_of(watch));
      }
    }
    const auto open = std::make_shared<std::size_t>(due.size() + 1);
    const auto end_one = [weak = weak_from_this(), open, take] {
      if (--*open > 0) return;
      if (const auto self = weak.lock()) self->send_values();
      take(nullptr);  // each page gets its own values
    };
    for (const MessageKey& key : due) {
      const auto& [link, message, system, component] = key;
      casd.upstream->call(
          "message.value",
          {{"link", link}, {"message", message}, {"system", system}, {"component", component}},
          taker([weak = weak_from_this(), key, end_one](const Json* answer) {
            if (const auto self = weak.lock(); self && answer != nullptr) {
              self->keep_value(key, *answer);
            }
            end_one();
          }));
    }
    end_one();
  }

  void keep_value(const MessageKey& message, const Json& answer) {
    const std::uint64_t count = answer.value("count", std::uint64_t{0});
    const Json fields = answer.value("fields", Json());
    if (!fields.is_array()) return;
    const double age_s = answer.value("age_s", 0.0);
    const double t_s = time_s() - (has_sim ? sim_rate * age_s : age_s);
    for (const auto& client : clients()) {
      for (auto& [key, watch] : client->values()) {
        if (key_of(watch) != message || std::exchange(watch.seen, count + 1) == count + 1) continue;
        if (watch.samples.size() >= kMaxSamples) watch.samples.erase(watch.samples.begin());
        watch.samples.push_back(text_of(sample_of(watch, fields, t_s)));
      }
    }
  }

  void send_values() {
    const base::RunTime now = base::steady_now();
    for (const auto& client : clients()) {
      if (!client->wants("value", now)) continue;
      Json series = Json::array();
      for (auto& [key, watch] : client->values()) {
        if (watch.samples.empty()) continue;
        Json samples = Json::array();
        for (const std::string& sample : std::exchange(watch.samples, {})) {
          samples.push_back(Json::parse(sample));
        }
        series.push_back({{"key", key}, {"samples", std::move(samples)}});
      }
      if (series.empty()) continue;
      const std::uint64_t seq = ++topics.at("value").seq;
      client->send_snapshot(
          "value", seq, frame("snap.value", {{"seq", seq}, {"series", std::move(series)}}), now);
    }
  }

  bool has_fresh_clock() const { return has_sim && base::steady_now() - sim_at <= kMaxClockAge; }

  /// Simulated time while hilsim is there and looked at, else that of this program.
  double time_s() const {
    const base::RunTime now = base::steady_now();
    if (!has_sim) return base::to_seconds(now - started);
    return sim_t_s + sim_rate * base::to_seconds(now - sim_at);
  }

  // ---- meshes

  struct Fetch {
    std::shared_ptr<std::string> bytes = std::make_shared<std::string>();
    std::size_t whole = 0;  // as hilsim says
    std::vector<TakeMesh> takers{};
  };

  void fetch_mesh(const std::string& hash, TakeMesh take) {
    if (const auto known = meshes.find(hash); known != meshes.end()) return take(known->second);
    const auto [fetch, is_new] = fetches.try_emplace(hash);
    fetch->second.takers.push_back(std::move(take));
    if (is_new) fetch_piece(hash, 0);
  }

  void fetch_piece(const std::string& hash, std::size_t offset) {
    hilsim.upstream->call("sim.mesh", {{"hash", hash}, {"offset", offset}},
                          taker([weak = weak_from_this(), hash](const Json* piece) {
                            if (const auto self = weak.lock()) self->on_piece(hash, piece);
                          }));
  }

  void on_piece(const std::string& hash, const Json* piece) {
    const auto found = fetches.find(hash);
    if (found == fetches.end()) return;
    Fetch& fetch = found->second;
    if (piece == nullptr || !piece->is_object()) return end_fetch(hash, nullptr);
    const Json whole = piece->value("bytes", Json());
    const Json text = piece->value("base64", Json());
    if (!whole.is_number_unsigned() || !text.is_string()) return end_fetch(hash, nullptr);
    fetch.whole = whole.get<std::size_t>();
    std::size_t under_way = 0;
    for (const auto& [other, each] : fetches) under_way += each.whole;
    if (fetch.whole > kMaxMeshes || under_way > kMaxMeshes) return end_fetch(hash, nullptr);
    const std::string more = base::rpc::from_base64(text.get_ref<const std::string&>());
    *fetch.bytes += more;
    if (fetch.bytes->size() < fetch.whole && !more.empty()) {
      return fetch_piece(hash, fetch.bytes->size());
    }
    if (fetch.bytes->size() != fetch.whole) return end_fetch(hash, nullptr);
    keep_mesh(hash, fetch.bytes);
    end_fetch(hash, fetch.bytes);
  }

  void end_fetch(const std::string& hash, const Bytes& bytes) {
    const auto fetch = fetches.extract(hash);
    for (const TakeMesh& take : fetch.mapped().takers) take(bytes);
  }

  void keep_mesh(const std::string& hash, const Bytes& bytes) {
    if (mesh_bytes + bytes->size() > kMaxMeshes) {
      meshes.clear();
      mesh_bytes = 0;
    }
    mesh_bytes += bytes->size();
    meshes.emplace(hash, bytes);
  }

  struct Pilot {
    std::uint64_t client;
    base::RunTime until;
  };

  asio::io_context& io;
  Config config;
  bool closed = false;
  base::RunTime started = base::steady_now();
  Program casd{};
  Program hilsim{};
  Program hils{};  // without an upstream where no run is shown
  std::map<std::string, Topic> topics;
  std::vector<std::weak_ptr<PageClient>> pages;
  std::uint64_t events = 0;
  LinkReport link_report;
  std::string scene_hash;
  bool has_sim = false;  // since hilsim is there
  double sim_t_s = 0;
  double sim_rate = 0;
  bool sim_paused = false;
  base::RunTime sim_at{};
  std::set<int> systems;
  base::RunTime systems_end{};
  std::map<std::string, Bytes> meshes;   // by hash
  std::map<std::string, Fetch> fetches;  // by hash
  std::size_t mesh_bytes = 0;
  std::map<int, Pilot> pilots;  // by vehicle
};

PageHub::PageHub(asio::io_context& io, Config config)
    : impl_(std::make_shared<Impl>(io, std::move(config))) {}

PageHub::~PageHub() = default;

void PageHub::start() { impl_->start(); }

void PageHub::close() {
  impl_->closed = true;
  for (auto& [name, topic] : impl_->topics) topic.timer.cancel();
  impl_->casd.upstream->close();
  impl_->hilsim.upstream->close();
  if (impl_->hils.upstream) impl_->hils.upstream->close();
}

Upstream& PageHub::casd() { return *impl_->casd.upstream; }
Upstream& PageHub::hilsim() { return *impl_->hilsim.upstream; }
Upstream* PageHub::hils() { return impl_->hils.upstream.get(); }

void PageHub::add(const std::shared_ptr<PageClient>& client) { impl_->pages.push_back(client); }

bool PageHub::has_place() const { return impl_->clients().size() < kMaxPages; }

std::optional<double> PageHub::rate_of(const std::string& topic) const {
  const auto found = impl_->topics.find(topic);
  if (found == impl_->topics.end()) return std::nullopt;
  return found->second.hz;
}

void PageHub::on_wanted(const std::string& topic) { impl_->on_wanted(topic); }

Json PageHub::greeting() const {
  Json rates = Json::object();
  for (const auto& [name, topic] : impl_->topics) rates[name] = topic.hz;
  Json clock;
  if (impl_->has_fresh_clock()) {
    clock = {{"sim_s", impl_->time_s()}, {"rate", impl_->sim_rate}, {"paused", impl_->sim_paused}};
  }
  return {{"casweb", CAS_VERSION},       {"source", "live"},
          {"casd", impl_->casd.version}, {"hilsim", impl_->hilsim.version},
          {"clock", std::move(clock)},   {"topics", std::move(rates)}};
}

Json PageHub::bench_status() const {
  Json programs =
      Json::array({impl_->program_json(impl_->hilsim), impl_->program_json(impl_->casd)});
  if (impl_->hils.upstream) programs.push_back(impl_->program_json(impl_->hils));
  return {{"programs", std::move(programs)}};
}

void PageHub::fetch_mesh(const std::string& hash, TakeMesh take) {
  impl_->fetch_mesh(hash, std::move(take));
}

bool PageHub::has_room_for(std::size_t fields) const {
  for (const auto& client : impl_->clients()) fields += client->watched_fields();
  return fields <= kMaxFields;
}

bool PageHub::take_pilot(std::uint64_t client, int system, base::RunTime now) {
  const auto [pilot, is_new] =
      impl_->pilots.try_emplace(system, Impl::Pilot{client, now + kPilotSilence});
  if (!is_new && pilot->second.client != client && now < pilot->second.until) return false;
  pilot->second = {client, now + kPilotSilence};
  return true;
}

bool PageHub::is_pilot(std::uint64_t client, int system, base::RunTime now) {
  const auto pilot = impl_->pilots.find(system);
  if (pilot == impl_->pilots.end() || pilot->second.client != client ||
      now >= pilot->second.until) {
    return false;
  }
  pilot->second.until = now + kPilotSilence;
  return true;
}

}  // namespace cas::web
