// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session.hpp"

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

}  // namespace

Session::Session(const Options& options) : options_(options), client_(options.address) {
  if (options.token_file.empty()) return;
  client_.call("authorise", json{{"token", first_line(options.token_file)}});
}

json Session::call(const std::string& method, json params) {
  return client_.call(method, params, base::from_seconds(options_.timeout_s));
}

json Session::vehicle_call(const std::string& method, json params) {
  if (options_.vehicle) params["vehicle"] = *options_.vehicle;
  return call(method, std::move(params));
}

json Session::wait_for(const std::string& what, const std::function<bool(const json&)>& reached) {
  const auto give_up =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(options_.timeout_s);
  for (;;) {
    json state = vehicle_call("vehicle.state");
    if (reached(state)) return state;
    if (std::chrono::steady_clock::now() > give_up) {
      throw WaitTimeout("acknowledged, but the vehicle was not " + what + " within " +
                        json(options_.timeout_s).dump() +
                        " s; look at `casctl status`, or give a longer --timeout");
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
