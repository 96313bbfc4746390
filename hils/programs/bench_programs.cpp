// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/bench_programs.hpp"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/rpc/client.hpp"
#include "hils/programs/watch_line.hpp"

namespace cas::hils {

namespace {

constexpr base::Duration kStopPatience = std::chrono::seconds(10);

std::filesystem::path program_folder() { return own_program().parent_path(); }

}  // namespace

void BenchPrograms::start(bool paused) {
  for (std::size_t i = 0; i < places_.vehicles.size(); ++i) {
    if (request_.fcu_device(i) == nullptr) launch_emulator(places_.vehicles[i]);
  }
  if (paused) launch_hilsim(true);  // it sends nothing yet, so it may load while others do
  for (const ChildProcess* emulator : emulators_)
    supervisor_.wait_ready(*emulator, Supervisor::kReadyTimeout);
  start_casd();
  refuse_closed_station();
  if (request_.announced) tell_how_to_watch(places_.command_port, request_.station);
  if (!paused) launch_hilsim(false);
  supervisor_.wait_ready(*hilsim_, Supervisor::kReadyTimeout);
}

void BenchPrograms::launch_hilsim(bool paused) {
  std::vector<std::string> arguments{"--control", places_.simulator_control(), "--output",
                                     places_.out};
  if (paused) arguments.push_back("--paused");
  for (const std::filesystem::path& folder : base::plugin_dirs()) {
    arguments.insert(arguments.end(), {"--plugin-dir", folder});
  }
  hilsim_ = &supervisor_.launch(options("hilsim", "hilsim", places_.simulator_config(), arguments));
}

void BenchPrograms::refuse_closed_station() const {
  if (!request_.station) return;
  base::rpc::Client casd("unix:" + places_.command_port.string());
  for (const base::rpc::Json& link : casd.call("link.list", base::rpc::Json::object())) {
    if (link.value("name", "") != station_link(places_) || link.value("state", "") == "up")
      continue;
    throw base::ConfigError(fmt::format(
        "--gcs: {} cannot be opened; does another program have this port? {} has the reason",
        request_.station->address, (places_.run / "casd.log").string()));
  }
}

void BenchPrograms::launch_emulator(const VehiclePlaces& places) {
  const std::vector<std::string> arguments{"--link",    places.fcu_link(),
                                           "--ledger",  places.controller_ledger(),
                                           "--control", places.fcu_control()};
  emulators_.push_back(&supervisor_.launch(
      options(places.emulator(), "fcu_emulator", places.fcu_config(), arguments)));
}

void BenchPrograms::stop(bool nothing_under_way) {
  using Turn = std::vector<ChildProcess*>;
  const std::vector<Turn> turns = nothing_under_way
                                      ? std::vector<Turn>{{hilsim_, casd_}, emulators_}
                                      : std::vector<Turn>{{hilsim_}, {casd_}, emulators_};
  for (Turn turn : turns) {
    std::erase(turn, nullptr);
    const ChildProcess* bad = supervisor_.stop(turn, kStopPatience);
    if (bad == nullptr) continue;
    throw RunStopped(bad->name() + " did not end in good order; its last lines:" + bad->log_tail(),
                     false);
  }
  logs_.join();
}

void BenchPrograms::kill_casd() {
  if (casd_ != nullptr) supervisor_.kill(*casd_);
  casd_ = nullptr;
  logs_.set_aside();
}

void BenchPrograms::start_casd() {
  if (casd_ != nullptr) return;
  casd_ = &supervisor_.start(
      options("casd", "casd", places_.casd_config(),
              {"--ledger", places_.casd_ledger(), "--name", request_.scenario.name}),
      Supervisor::kReadyTimeout);
}

ChildProcess::Options BenchPrograms::options(const std::string& name, const std::string& program,
                                             const std::filesystem::path& config,
                                             const std::vector<std::string>& further) const {
  ChildProcess::Options options;
  options.name = name;
  options.arguments = {(program_folder() / program).string(), config.string(), "--stats",
                       (places_.run / (name + "_stats.json")).string()};
  options.arguments.insert(options.arguments.end(), further.begin(), further.end());
  options.log_file = places_.run / (name + ".log");
  options.notify_socket = places_.sockets / (name + ".notify");
  return options;
}

}  // namespace cas::hils
