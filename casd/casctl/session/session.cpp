// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/session.hpp"

#include <fstream>
#include <iostream>
#include <thread>
#include <utility>

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr auto kPollPeriod = std::chrono::milliseconds(100);

std::string first_line(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) {
    throw std::runtime_error("cannot read a token from " + file + "; check the file's rights");
  }
  return line;
}

std::chrono::steady_clock::time_point deadline(const Options& options) {
  return std::chrono::steady_clock::now() +
         std::chrono::duration_cast<std::chrono::steady_clock::duration>(
             std::chrono::duration<double>(options.timeout_s));
}

}  // namespace

Session::Session(const Options& options)
    : options_(options), give_up_(deadline(options)), client_(connect()) {
  if (options.token_file.empty()) return;
  client_.call("authorise", json{{"token", first_line(options.token_file)}});
}

/// With --wait casd may be just starting.
base::rpc::Client Session::connect() {
  for (;;) {
    try {
      return base::rpc::Client(options_.address);
    } catch (const base::rpc::ConnectionError&) {
      if (!may_wait()) throw;
    }
    wait_because("casd does not answer at " + options_.address + " yet", kPollPeriod);
  }
}

bool Session::may_wait() const {
  return options_.wait && std::chrono::steady_clock::now() < give_up_;
}

void Session::wait_because(const std::string& reason, std::chrono::milliseconds period) {
  if (!options_.json && reason != told_) std::cerr << "casctl: waiting: " << reason << '\n';
  told_ = reason;
  std::this_thread::sleep_for(period);
}

json Session::call(const std::string& method, json params) {
  return client_.call(method, params, base::from_seconds(options_.timeout_s));
}

json Session::vehicle_call(const std::string& method, json params) {
  if (options_.vehicle) params["vehicle"] = *options_.vehicle;
  for (;;) {
    try {
      return call(method, params);
    } catch (const base::rpc::CallError& error) {
      if (error.code() != base::rpc::kNoSuchVehicle || !may_wait()) throw;
      wait_because(error.what(), kPollPeriod);
    }
  }
}

json Session::wait_for(const std::string& what, const std::function<bool(const json&)>& reached) {
  const auto give_up = deadline(options_);
  for (;;) {
    json state = vehicle_call("vehicle.state");
    if (reached(state)) return state;
    if (std::chrono::steady_clock::now() > give_up) {
      const bool disarmed = !state.value("armed", true);
      throw WaitTimeout("acknowledged, but the vehicle was not " + what + " within " +
                        json(options_.timeout_s).dump() + " s" +
                        (disarmed ? "; it is disarmed: arm it with `casctl arm --wait`"
                                  : "; look at `casctl status`, or give a longer --timeout"));
    }
    std::this_thread::sleep_for(kPollPeriod);
  }
}

void report(const Options& options, const json& result, const std::string& sentence) {
  if (options.json) {
    std::cout << result.dump(-1, ' ', false, json::error_handler_t::replace) << '\n';
  } else {
    std::cout << sentence << '\n';
  }
}

}  // namespace cas::casctl
