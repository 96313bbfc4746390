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

namespace cas::hils {
namespace {

constexpr base::Duration kStopPatience = std::chrono::seconds(5);

/// A world's home as ArduPilot's --home takes it: "LAT,LON,ALT,HEADING".
std::string home_text(const base::Geodetic& home) {
  return fmt::format("{:.7f},{:.7f},{},0", home.lat_deg, home.lon_deg, home.alt_m);
}

}  // namespace

FirmwareBench::FirmwareBench(const RunRequest& request, const RunPaths& paths)
    : scenario_(request.scenario),
      paths_(paths),
      programs_(supervisor_, paths, request, {.casd_ledger = keeps_ledgers()}),
      is_board_(!request.fcu_devices.empty()) {
  if (is_board_) return;
  for (std::size_t i = 0; i < scenario_.vehicles.size(); ++i) {
    firmware_options_.push_back(firmware_options(i));
    check_program(firmware_options_.back());
  }
  if (scenario_.firmware->on_serial_line) cable_.emplace(paths.casd_tty(), paths.firmware_tty());
}

void FirmwareBench::start() {
  for (const auto& options : firmware_options_) prepare_folder(options.cwd);
  const std::filesystem::path simulator_ledger = paths_.vehicles.front().simulator_ledger();
  for (const auto& ledger : {simulator_ledger, paths_.casd_ledger()}) {
    std::filesystem::remove(ledger);  // of an earlier flight
  }
  programs_.start_first_casd();
  std::vector<std::string> ledger;
  if (keeps_ledgers()) {
    ledger = {"--ledger", simulator_ledger.lexically_relative(paths_.out)};
  }
  supervisor_.wait_ready(programs_.launch_hilsim(ledger), Supervisor::kReadyTimeout);
  for (const auto& options : firmware_options_) {
    firmware_.push_back(&supervisor_.start(options, Supervisor::kReadyTimeout));
  }
}

void FirmwareBench::stop() {
  for (ChildProcess* firmware : firmware_) supervisor_.stop(*firmware, kStopPatience);
  supervisor_.stop(*programs_.hilsim(), kStopPatience);
  if (programs_.casd() != nullptr) supervisor_.stop(*programs_.casd(), kStopPatience);
  programs_.join_logs();
}

void FirmwareBench::reboot(std::size_t vehicle) {
  supervisor_.stop(*firmware_[vehicle], kStopPatience);
  ChildProcess::Options options = firmware_options_[vehicle];
  options.appends = true;
  firmware_[vehicle] = &supervisor_.start(std::move(options), Supervisor::kReadyTimeout);
}

std::optional<std::string> FirmwareBench::own_end(std::size_t vehicle, std::size_t lines) {
  if (is_board_) return std::nullopt;
  ChildProcess& firmware = *firmware_[vehicle];
  const auto words = supervisor_.own_end(firmware);
  if (!words) return std::nullopt;
  return firmware.name() + " " + *words + "; its last lines:" + firmware.log_tail(lines);
}

std::string FirmwareBench::last_lines(std::size_t vehicle) const {
  return is_board_ ? "" : firmware_[vehicle]->log_tail();
}

std::uintmax_t FirmwareBench::output_bytes(std::size_t vehicle) const {
  if (is_board_) return 0;
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
  scenario_.firmware->node.at("command").fail(fmt::format(
      "cannot start '{}': {} (errno {})", program.string(), std::strerror(error), error));
}

void FirmwareBench::prepare_folder(const std::filesystem::path& folder) {
  if (scenario_.firmware->cwd.empty()) {
    base::remove_result_folder({paths_.out, folder});
    base::make_result_folder({paths_.out, folder});
  } else if (std::filesystem::exists(folder) && !std::filesystem::is_empty(folder)) {
    remarks_.push_back("the firmware's folder " + folder.string() +
                       " was not empty: parameters of earlier flights may have been in force");
  }
  std::filesystem::create_directories(folder);
}

ChildProcess::Options FirmwareBench::firmware_options(std::size_t instance) const {
  const auto config = base::shipped_config("firmware/quad_x.parm").parent_path().parent_path();
  std::map<std::string, std::string> own{
      {"CAS_FCU_TTY", paths_.firmware_tty().string()},
      {"CAS_AHRS_TTY", paths_.ahrs_tty().string()},
      {"CAS_GPS_TTY", paths_.gps_tty().string()},
      {"CAS_CONFIG", config.string()},
      {"CAS_INSTANCE", std::to_string(instance)},
      {"CAS_SYSTEM", std::to_string(system_of_instance(instance))}};
  if (scenario_.home) own["CAS_HOME"] = home_text(*scenario_.home);
  const auto text = [&own](const std::string& written) { return with_variables(written, own); };
  std::vector<std::string> arguments;
  for (const std::string& word : scenario_.firmware->command) arguments.push_back(text(word));
  ChildProcess::Options options =
      programs_.options("firmware" + scenario_.suffix_of(instance), arguments);
  options.says_ready = false;
  options.ends_run = false;
  options.cwd = scenario_.firmware->cwd.empty()
                    ? paths_.run / options.name
                    : std::filesystem::path(text(scenario_.firmware->cwd));
  for (const auto& [name, value] : scenario_.firmware->environment) {
    options.environment.push_back(name + "=" + text(value));
  }
  return options;
}

}  // namespace cas::hils
