// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/run_programs.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/read_file.hpp"
#include "base/rpc/client.hpp"
#include "hils/programs/composed_parts.hpp"
#include "hils/programs/watch_line.hpp"

namespace cas::hils {

RunPrograms::RunPrograms(Supervisor& supervisor, const RunPaths& paths, const RunRequest& request,
                         Records records)
    : supervisor_(supervisor),
      paths_(paths),
      request_(request),
      records_(records),
      logs_(paths.flight_tlog(), paths.run) {}

void RunPrograms::start_casd() {
  if (casd_ != nullptr) return;
  std::vector<std::string> arguments{
      sibling_program("casd"), paths_.casd_config(), "--stats", paths_.casd_stats(), "--name",
      request_.scenario.name};
  if (records_.casd_ledger) arguments.insert(arguments.end(), {"--ledger", paths_.casd_ledger()});
  casd_ = &supervisor_.start(options("casd", std::move(arguments)), Supervisor::kReadyTimeout);
}

void RunPrograms::start_first_casd() {
  start_casd();
  refuse_closed_station();
  if (request_.announced) tell_how_to_watch(paths_.command_port, request_.station);
}

void RunPrograms::kill_casd() {
  if (casd_ == nullptr) return;
  supervisor_.kill(*casd_);
  casd_ = nullptr;
  logs_.set_aside();
}

ChildProcess& RunPrograms::launch_hilsim(const std::vector<std::string>& further) {
  std::vector<std::string> arguments{sibling_program("hilsim"),
                                     paths_.simulator_config(),
                                     "--control",
                                     paths_.simulator_control(),
                                     "--output",
                                     paths_.out,
                                     "--stats",
                                     paths_.simulator_stats()};
  for (const std::filesystem::path& folder : base::plugin_dirs()) {
    arguments.insert(arguments.end(), {"--plugin-dir", folder});
  }
  arguments.insert(arguments.end(), further.begin(), further.end());
  hilsim_ = &supervisor_.launch(options("hilsim", std::move(arguments)));
  return *hilsim_;
}

void RunPrograms::refuse_closed_station() const {
  if (!request_.station) return;
  base::rpc::Client casd("unix:" + paths_.command_port.string());
  for (const base::rpc::Json& link : casd.call("link.list", base::rpc::Json::object())) {
    if (link.value("name", "") != kStationLink || link.value("state", "") == "up") continue;
    throw base::ConfigError(fmt::format(
        "--gcs: {} cannot be opened; does another program have this port? {} has the reason",
        request_.station->address, (paths_.run / "casd.log").string()));
  }
}

ChildProcess::Options RunPrograms::options(const std::string& name,
                                           std::vector<std::string> arguments) const {
  ChildProcess::Options options;
  options.name = name;
  options.arguments = std::move(arguments);
  options.log_file = paths_.run / (name + ".log");
  options.notify_socket = paths_.sockets / (name + ".notify");
  return options;
}

void FlightLogs::set_aside() {
  earlier_.push_back(folder_ / fmt::format("flight_{}.tlog", earlier_.size() + 1));
  std::filesystem::rename(log_, earlier_.back());
}

void FlightLogs::join() {
  if (earlier_.empty()) return;
  const std::filesystem::path last = folder_ / "flight_last.tlog";
  std::filesystem::rename(log_, last);
  earlier_.push_back(last);
  const base::ResultPlace place{log_.parent_path(), log_.filename()};
  base::OpenFile whole = base::open_result(place);
  for (const std::filesystem::path& part : earlier_) {
    const std::optional<std::string> text = base::read_file(part);
    if (!text) throw base::ConfigError(part.string() + ": a part of the flight log cannot be read");
    std::fwrite(text->data(), 1, text->size(), whole.get());
  }
  base::close_result(std::move(whole), place);
}

}  // namespace cas::hils
