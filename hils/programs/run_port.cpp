// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/run_port.hpp"

#include <boost/asio/post.hpp>
#include <chrono>
#include <condition_variable>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/os/mutex.hpp"
#include "base/os/thread.hpp"
#include "base/rpc/io_thread.hpp"
#include "base/rpc/server.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {

namespace {

namespace asio = boost::asio;
using base::rpc::CallError;
using base::rpc::Reply;

constexpr auto kTellTime = std::chrono::seconds(2);
constexpr std::size_t kMostFaults = 16;  // that wait for the run
/// Longer than the longest command of a flight: after so long without a look the run hangs.
constexpr auto kHangs = std::chrono::seconds(30);
constexpr const char* kOver = "the flight is over: no fault begins";

}  // namespace

struct RunPort::Impl {
  void add_methods() {
    for (const char* method : {"run.reference", "run.status", "fault.list"}) {
      server.add_method(method, [this, method](const Json&, const Reply& reply) {
        const auto answer = answers.find(method);
        if (hangs()) throw CallError(base::rpc::kRefused, "the run hangs");
        if (answer == answers.end()) throw CallError(base::rpc::kRefused, "the run has not begun");
        reply.result(answer->second);
      });
    }
    server.add_method("run.told", [this](const Json&, const Reply& reply) {
      reply.result(true);
      end_tell();
    });
    server.add_method("fault.inject", [this](const Json& params, const Reply& reply) {
      const base::MutexLock lock(mutex);
      if (!takes_faults) throw CallError(base::rpc::kRefused, kOver);
      if (faults.size() >= kMostFaults) {
        throw CallError(base::rpc::kRefused, "16 faults wait already");
      }
      faults.push_back({params.dump(-1, ' ', false, Json::error_handler_t::replace), reply});
    });
    for (const char* topic : {"fault", "verdict"}) server.add_topic(topic);
  }

  /// While it flies it shows its status twice a second.
  bool hangs() {
    const base::MutexLock lock(mutex);
    return takes_faults && shown_at && base::steady_now() - *shown_at > kHangs;
  }

  void end_tell() {
    const base::MutexLock lock(mutex);
    told = true;
    wake.notify_all();
  }

  base::rpc::IoThread io;
  base::rpc::Server server{io.context()};
  // Used on the thread of `io` alone:
  std::map<std::string, Json, std::less<>> answers;  // by method
  std::optional<base::RunTime> shown_at;             // when the run last showed its status

  base::Mutex mutex;
  std::condition_variable_any wake;
  std::vector<FaultCall> faults CAS_GUARDED_BY(mutex);
  bool takes_faults CAS_GUARDED_BY(mutex) = true;
  bool told CAS_GUARDED_BY(mutex) = false;  // the verdict has been passed on
};

RunPort::RunPort(const std::filesystem::path& socket) : impl_(std::make_unique<Impl>()) {
  impl_->add_methods();
  impl_->server.listen_unix(socket);
  impl_->io.start([] { base::configure_this_thread("run port", {}); },
                  [impl = impl_.get()] { impl->server.start(); });
}

RunPort::~RunPort() {
  impl_->io.finish([this] { impl_->server.close(); });
}

void RunPort::show(const std::string& method, Json answer) {
  asio::post(impl_->io.context(), [this, method, answer = std::move(answer)] {
    impl_->answers.insert_or_assign(method, answer);
    if (method == "run.status") impl_->shown_at = base::steady_now();
  });
}

void RunPort::publish(const std::string& topic, Json params) {
  asio::post(impl_->io.context(),
             [this, topic, params = std::move(params)] { impl_->server.publish(topic, params); });
}

std::vector<RunPort::FaultCall> RunPort::take_faults() {
  const base::MutexLock lock(impl_->mutex);
  return std::exchange(impl_->faults, {});
}

void RunPort::answer(const FaultCall& call, Json result) {
  asio::post(impl_->io.context(),
             [reply = call.reply, result = std::move(result)] { reply.result(result); });
}

void RunPort::refuse(const FaultCall& call, int code, std::string sentence) {
  asio::post(impl_->io.context(), [reply = call.reply, code, sentence = std::move(sentence)] {
    reply.error(code, sentence, nullptr);
  });
}

void RunPort::end_faults() {
  {
    const base::MutexLock lock(impl_->mutex);
    impl_->takes_faults = false;
  }
  for (const FaultCall& call : take_faults()) refuse(call, base::rpc::kRefused, kOver);
}

void RunPort::tell_verdict(Json verdict) {
  asio::post(impl_->io.context(), [this, verdict = std::move(verdict)] {
    impl_->answers.insert_or_assign("run.status", verdict);
    impl_->shown_at.reset();
    if (!impl_->server.has_subscribers("verdict")) return impl_->end_tell();
    impl_->server.publish("verdict", verdict);
  });
  const auto deadline = std::chrono::steady_clock::now() + kTellTime;
  base::MutexLock lock(impl_->mutex);
  while (!impl_->told && impl_->wake.wait_until(lock, deadline) == std::cv_status::no_timeout) {
  }
}

}  // namespace cas::hils
