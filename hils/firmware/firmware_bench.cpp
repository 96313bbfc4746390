// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_bench.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "base/config/install_paths.hpp"
#include "base/os/result_file.hpp"
#include "hils/programs/watch_line.hpp"

namespace cas::hils {
namespace {

constexpr base::Duration kStopPatience = std::chrono::seconds(5);

std::filesystem::path program(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

/// A world's home as ArduPilot's --home takes it: "LAT,LON,ALT,HEADING".
std::string home_text(const base::Geodetic& home) {
  return fmt::format("{:.7f},{:.7f},{},0", home.lat_deg, home.lon_deg, home.alt_m);
}

}  // namespace

FirmwareBench::FirmwareBench(const RunRequest& request, const RunPlaces& places)
    : request_(request),
      scenario_(request.scenario),
      places_(places),
      logs_(places.flight_tlog(), places.run) {
  for (std::size_t i = 0; i < scenario_.vehicles.size(); ++i) {
    firmware_options_.push_back(firmware_options(i));
    check_program(firmware_options_.back());
  }
  if (scenario_.firmware->on_serial_line) cable_.emplace(places.casd_tty(), places.firmware_tty());
}

void FirmwareBench::start() {
  for (const auto& options : firmware_options_) prepare_folder(options.cwd);
  const std::filesystem::path simulator_ledger = places_.vehicles.front().simulator_ledger();
  for (const auto& ledger : {simulator_ledger, places_.casd_ledger()}) {
    std::filesystem::remove(ledger);  // of an earlier flight
  }
  start_casd();
  if (request_.announced) tell_how_to_watch(places_.command_port, request_.station);
  std::vector<std::string> hilsim{program("hilsim"), places_.simulator_config(),
                                  "--control",       places_.simulator_control(),
                                  "--output",        places_.out,
                                  "--stats",         places_.simulator_stats()};
  if (keeps_ledgers()) {
    hilsim.insert(hilsim.end(), {"--ledger", simulator_ledger.lexically_relative(places_.out)});
  }
  for (const std::filesystem::path& folder : base::plugin_dirs()) {
    hilsim.insert(hilsim.end(), {"--plugin-dir", folder});
  }
  hilsim_ = &supervisor_.start(options("hilsim", hilsim), Supervisor::kReadyTimeout);
  for (const auto& options : firmware_options_) {
    firmware_.push_back(&supervisor_.start(options, Supervisor::kReadyTimeout));
  }
}

void FirmwareBench::stop() {
  for (ChildProcess* firmware : firmware_) supervisor_.stop(*firmware, kStopPatience);
  supervisor_.stop(*hilsim_, kStopPatience);
  if (casd_ != nullptr) supervisor_.stop(*casd_, kStopPatience);
  logs_.join();
}

void FirmwareBench::reboot(std::size_t vehicle) {
  supervisor_.stop(*firmware_[vehicle], kStopPatience);
  ChildProcess::Options options = firmware_options_[vehicle];
  options.appends = true;
  firmware_[vehicle] = &supervisor_.start(std::move(options), Supervisor::kReadyTimeout);
}

std::optional<std::string> FirmwareBench::own_end(std::size_t vehicle, std::size_t lines) {
  ChildProcess& firmware = *firmware_[vehicle];
  const auto words = supervisor_.own_end(firmware);
  if (!words) return std::nullopt;
  return firmware.name() + " " + *words + "; its last lines:" + firmware.log_tail(lines);
}

std::uintmax_t FirmwareBench::output_bytes(std::size_t vehicle) const {
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(firmware_options_[vehicle].log_file, none);
  return none ? 0 : size;
}

/// hils, casd and hilsim would start first, and the firmware fail after them.
void FirmwareBench::check_program(const ChildProcess::Options& options) const {
  const std::filesystem::path program = options.cwd / options.arguments.front();
  const bool is_file = !std::filesystem::is_directory(program);
  if (::access(program.c_str(), X_OK) == 0 && is_file) return;
  const int error = is_file ? errno : EISDIR;
  scenario_.firmware->node.at("command").fail("cannot start '" + program.string() +
                                              "': " + std::strerror(error) + " (errno " +
                                              std::to_string(error) + ")");
}

void FirmwareBench::prepare_folder(const std::filesystem::path& folder) {
  if (scenario_.firmware->cwd.empty()) {
    base::remove_result_folder({places_.out, folder});
    base::make_result_folder({places_.out, folder});
  } else if (std::filesystem::exists(folder) && !std::filesystem::is_empty(folder)) {
    remarks_.push_back("the firmware's folder " + folder.string() +
                       " was not empty: parameters of earlier flights may have been in force");
  }
  std::filesystem::create_directories(folder);
}

void FirmwareBench::kill_casd() {
  if (casd_ == nullptr) return;
  supervisor_.kill(*casd_);
  casd_ = nullptr;
  logs_.set_aside();
}

void FirmwareBench::start_casd() {
  if (casd_ != nullptr) return;
  std::vector<std::string> casd{program("casd"), places_.casd_config(), "--name", scenario_.name};
  if (keeps_ledgers()) casd.insert(casd.end(), {"--ledger", places_.casd_ledger()});
  casd_ = &supervisor_.start(options("casd", std::move(casd)), Supervisor::kReadyTimeout);
}

ChildProcess::Options FirmwareBench::options(const std::string& name,
                                             std::vector<std::string> arguments) const {
  ChildProcess::Options options;
  options.name = name;
  options.arguments = std::move(arguments);
  options.log_file = places_.run / (name + ".log");
  options.notify_socket = places_.sockets / (name + ".notify");
  return options;
}

ChildProcess::Options FirmwareBench::firmware_options(std::size_t instance) const {
  const auto config = base::shipped_config("firmware/quad_x.parm").parent_path().parent_path();
  std::map<std::string, std::string> own{
      {"CAS_FCU_TTY", places_.firmware_tty().string()},
      {"CAS_CONFIG", config.string()},
      {"CAS_INSTANCE", std::to_string(instance)},
      {"CAS_SYSTEM", std::to_string(system_of_instance(instance))}};
  if (scenario_.home) own["CAS_HOME"] = home_text(*scenario_.home);
  const auto text = [&own](const std::string& written) { return with_variables(written, own); };
  std::vector<std::string> arguments;
  for (const std::string& word : scenario_.firmware->command) arguments.push_back(text(word));
  ChildProcess::Options options =
      this->options("firmware" + scenario_.suffix_of(instance), arguments);
  options.says_ready = false;
  options.ends_run = false;
  options.cwd = scenario_.firmware->cwd.empty()
                    ? places_.run / options.name
                    : std::filesystem::path(text(scenario_.firmware->cwd));
  for (const auto& [name, value] : scenario_.firmware->environment) {
    options.environment.push_back(name + "=" + text(value));
  }
  return options;
}

}  // namespace cas::hils
