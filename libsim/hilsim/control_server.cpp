// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/control_server.hpp"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <exception>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/os/log.hpp"
#include "base/os/mutex.hpp"
#include "base/os/thread.hpp"
#include "base/rpc/base64.hpp"
#include "base/rpc/call_params.hpp"
#include "base/rpc/io_thread.hpp"
#include "base/rpc/server.hpp"
#include "base/time/unix_time.hpp"
#include "libsim/hilsim/control_description.hpp"
#include "libsim/hilsim/fault_injector.hpp"
#include "libsim/hilsim/motion_watch.hpp"
#include "libsim/hilsim/pace_watch.hpp"
#include "libsim/hilsim/run_journal.hpp"
#include "libsim/hilsim/scene.hpp"
#include "libsim/hilsim/sim_report.hpp"

namespace cas::sim {

namespace {

namespace asio = boost::asio;
using base::rpc::CallParams;
using base::rpc::Json;
using base::rpc::Reply;

constexpr std::int64_t kLongest = 1'000'000'000;  // seconds, steps, bytes
constexpr auto kPacePeriod = std::chrono::seconds(5);
/// Between two samples of the motion, a little less than 1/60 s: a client that asks 60 times a
/// second gets 60.
constexpr auto kWatchPeriod = std::chrono::milliseconds(16);
constexpr std::size_t kMeshPiece = 256 * 1024;  // bytes of one answer

/// Asks for a line with the state of the run. Not a constant: the C library keeps some for itself.
int status_signal() { return SIGRTMIN; }

std::string status_line(const LoopFigures& f) {
  return fmt::format("{:.3f} s, {}, {:.2f} x real time, {} late steps", base::to_seconds(f.time),
                     f.paused ? "paused" : "running", f.real_time_factor, f.late_steps);
}

}  // namespace

struct ControlServer::Impl {
  explicit Impl(SimLoop& loop_in) : loop(loop_in) {}

  /// Carries `order` to the loop's thread, and its answer back to this one.
  void carry(Reply reply, std::function<void(std::function<void()> done)> order) {
    loop.post([this, reply = std::move(reply), order = std::move(order)] {
      order([this, reply] { answer(reply, status_report(loop)); });
    });
  }

  void answer(const Reply& reply, Json result) {
    asio::post(io.context(), [reply, result = std::move(result)] { reply.result(result); });
  }

  /// On the loop's thread: notes a client's call for sim.journal.
  void note(const std::string& client, const std::string& method,
            const Json& params = Json::object()) {
    NotedCall call{.unix_us = base::unix_us(),
                   .time_s = base::to_seconds(loop.figures().time),
                   .client = client,
                   .method = method,
                   .params = params.is_null() ? "{}" : params.dump()};
    const base::MutexLock lock(journal_mutex);
    journal.note(std::move(call));
  }

  Json noted() {
    const base::MutexLock lock(journal_mutex);
    return journal.json();
  }

  /// A method that is done at once.
  void add_plain(const std::string& name, std::function<void()> order) {
    server.add_method(name, [this, order = std::move(order)](const Json& params, Reply reply) {
      CallParams(params).finish();
      carry(std::move(reply), [order](const std::function<void()>& done) {
        order();
        done();
      });
    });
  }

  /// The same for one that changes the run.
  void add_act(const std::string& name, std::function<void()> order) {
    server.add_method(name, [this, name, order = std::move(order)](const Json& params,
                                                                   const Reply& reply) {
      CallParams(params).finish();
      carry(reply, [this, name, order, client = reply.client](const std::function<void()>& done) {
        note(client, name);
        order();
        done();
      });
    });
  }

  void add_methods() {
    server.describe(control_description(CAS_VERSION));
    add_plain("sim.status", [] {});
    add_act("sim.pause", [this] { loop.pause(); });
    add_act("sim.resume", [this] { loop.resume(); });
    add_act("sim.reset", [this] { loop.reset(); });
    add_act("sim.quit", [this] { loop.stop(); });
    add_figure_methods();
    add_step_methods();
    add_fault_method();
    add_picture_methods();
  }

  void add_figure_methods() {
    server.add_method("sim.journal", [this](const Json& params, const Reply& reply) {
      CallParams(params).finish();
      reply.result(noted());
    });
    server.add_method("sim.stats", [this](const Json& params, Reply reply) {
      CallParams(params).finish();
      loop.post([this, reply = std::move(reply)] { answer(reply, stats_report(loop)); });
    });
  }

  void add_step_methods() {
    server.add_method("sim.step", [this](const Json& params, const Reply& reply) {
      CallParams reader(params);
      const std::int64_t n = reader.optional_integer("n", 1, kLongest).value_or(1);
      reader.finish();
      carry(reply, [this, n, params, client = reply.client](std::function<void()> done) {
        note(client, "sim.step", params);
        loop.step(static_cast<std::uint64_t>(n), std::move(done));
      });
    });
    server.add_method("sim.phase", [this](const Json& params, const Reply& reply) {
      CallParams reader(params);
      const std::string name = reader.text("name");
      reader.finish();
      carry(reply, [this, name](const std::function<void()>& done) {
        loop.set_flight_phase(name);
        done();
      });
    });
    server.add_method("sim.run_until", [this](const Json& params, const Reply& reply) {
      CallParams reader(params);
      const double t = reader.number("time_s", 0, kLongest);
      reader.finish();
      carry(reply, [this, t, params, client = reply.client](std::function<void()> done) {
        note(client, "sim.run_until", params);
        loop.run_until(base::SimTime(base::from_seconds(t)), std::move(done));
      });
    });
  }

  void add_fault_method() {
    server.add_method("sim.fault", [this](const Json& params, const Reply& reply) {
      CallParams reader(params);
      const std::string vehicle = reader.text("vehicle");
      const Json fault = reader.object("fault");
      reader.finish();
      loop.post([this, params, vehicle, fault, reply] {
        std::optional<std::string> refusal;
        try {
          faults.order(vehicle, fault);
          note(reply.client, "sim.fault", params);
        } catch (const base::ConfigError& error) {
          refusal = error.what();
        }
        asio::post(io.context(), [reply, refusal] {
          if (!refusal) return reply.result(true);
          reply.error(base::rpc::kRefused, *refusal, nullptr);
        });
      });
    });
  }

  void add_picture_methods() {
    server.add_method("sim.watch", [this](const Json& params, Reply reply) {
      CallParams(params).finish();
      watch(std::move(reply));
    });
    server.add_method("sim.clouds", [this](const Json& params, const Reply& reply) {
      CallParams(params).finish();
      loop.post([this, reply] {
        asio::post(io.context(), [reply, taken = motion.take()] {
          guarded({reply}, [&] { reply.result(MotionWatch::clouds_json(*taken)); });
        });
      });
    });
    server.add_method("sim.scene", [this](const Json& params, const Reply& reply) {
      CallParams(params).finish();
      with_scene(reply, [reply](const Scene& now) { reply.result(now.json()); });
    });
    server.add_method("sim.mesh", [this](const Json& params, const Reply& reply) {
      CallParams reader(params);
      const std::string hash = reader.text("hash");
      const auto offset =
          static_cast<std::size_t>(reader.optional_integer("offset", 0, kLongest).value_or(0));
      reader.finish();
      with_scene(reply, [reply, hash, offset](const Scene& now) {
        const std::string* bytes = now.mesh(hash);
        if (bytes == nullptr || offset > bytes->size()) {
          return reply.error(base::rpc::kInvalidParams, "there is no such mesh", nullptr);
        }
        reply.result({{"bytes", bytes->size()},
                      {"base64",
                       base::rpc::to_base64(std::string_view(*bytes).substr(offset, kMeshPiece))}});
      });
    });
  }

  /// Made once the runner has started: by the loop's first order.
  void with_scene(const Reply& reply, std::function<void(const Scene&)> use) {
    if (scene) return use(*scene);
    loop.post([this, reply, use = std::move(use)] {
      asio::post(io.context(), [this, reply, use] {
        guarded({reply}, [&] {
          if (!scene) scene = std::make_unique<Scene>(std::as_const(loop).runner());
          use(*scene);
        });
      });
    });
  }

  /// For work outside of the server's own call: an error is answered, and never ends the program.
  template <class Body>
  static void guarded(const std::vector<Reply>& waiting, Body&& body) {
    try {
      body();
    } catch (const std::exception& error) {
      for (const Reply& reply : waiting) {
        reply.error(base::rpc::kInternalError, error.what(), nullptr);
      }
    }
  }

  /// Answers with the present sample, or with the next one, which is taken once for all waiting
  /// clients.
  void watch(Reply reply) {
    if (base::steady_now() < sample_ends) return reply.result(sample);
    watchers.push_back(std::move(reply));
    if (watchers.size() > 1) return;
    loop.post([this] {
      asio::post(io.context(), [this, taken = motion.take()] {
        const std::vector<Reply> waiting = std::exchange(watchers, {});
        guarded(waiting, [&] {
          sample = motion.json(*taken);
          sample_ends = base::steady_now() + kWatchPeriod;
          for (const Reply& each : waiting) each.result(sample);
        });
      });
    });
  }

  /// Waits for all that may come: at first, and after a handler has lacked memory.
  void begin() {
    if (closing) return;
    wait_for_signal();
    if (loop.runner().config().pace.mode == PaceMode::kRealtime) watch_pace();
    server.start();
  }

  void wait_for_signal() {
    signals.cancel();
    signals.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      on_signal(signal);
      wait_for_signal();
    });
  }

  void on_signal(int signal) {
    switch (signal) {
      case SIGUSR1:
        return loop.post([this] {
          note("signal", "SIGUSR1");
          loop.figures().paused ? loop.resume() : loop.pause();
        });
      case SIGUSR2:
        return loop.post([this] {
          note("signal", "SIGUSR2");
          if (loop.figures().paused) loop.step(1, nullptr);
        });
      case SIGHUP:
        return loop.post([this] {
          note("signal", "SIGHUP");
          loop.reset();
        });
      case SIGINT:
      case SIGTERM:
        return loop.stop();
      default:  // status_signal()
        return loop.post([this] { base::log::info(status_line(loop.figures())); });
    }
  }

  /// A run that falls behind says so while it goes on.
  void watch_pace() {
    pace_timer.expires_after(kPacePeriod);
    pace_timer.async_wait([this](const boost::system::error_code& error) {
      if (error || closing) return;
      loop.post([this] {
        asio::post(io.context(), [this, figures = loop.figures()] {
          if (const auto trouble = pace.look(figures)) base::log::warn(*trouble);
        });
      });
      watch_pace();
    });
  }

  SimLoop& loop;
  MotionWatch motion{loop};
  FaultInjector faults{loop.runner()};
  base::Mutex journal_mutex;
  RunJournal journal CAS_GUARDED_BY(journal_mutex);
  std::unique_ptr<const Scene> scene;  // made at the first request
  Json sample;                         // newest of `motion`
  base::RunTime sample_ends{};         // until then it is new enough
  std::vector<Reply> watchers;         // wait for the next
  PaceWatch pace{loop.runner().config().pace.speed};
  base::rpc::IoThread io;
  asio::signal_set signals{io.context()};
  asio::steady_timer pace_timer{io.context()};
  bool closing = false;  // a timer that was due before its cancel is not armed again
  base::rpc::Server server{io.context()};
};

ControlServer::ControlServer(SimLoop& loop, const std::optional<std::filesystem::path>& unix_path)
    : impl_(std::make_unique<Impl>(loop)) {
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGHUP, status_signal()}) {
    impl_->signals.add(signal);
  }
  impl_->add_methods();
  if (unix_path) impl_->server.listen_unix(*unix_path);
  impl_->io.start([] { base::configure_this_thread("control", {}); },
                  [impl = impl_.get()] { impl->begin(); });
}

ControlServer::~ControlServer() {
  impl_->io.finish([this] {
    impl_->closing = true;
    impl_->signals.cancel();
    impl_->pace_timer.cancel();
    impl_->server.close();
  });
}

}  // namespace cas::sim
