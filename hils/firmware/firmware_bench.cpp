// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_bench.hpp"

#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "base/config/install_paths.hpp"
#include "hils/programs/watch_line.hpp"

namespace cas::hils {
namespace {

constexpr base::Duration kStopPatience = std::chrono::seconds(5);

std::filesystem::path program(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

}  // namespace

FirmwareBench::FirmwareBench(const FirmwareScenario& scenario, const FirmwarePlaces& places)
    : scenario_(scenario), places_(places), logs_(places.flight_tlog(), places.run) {
  if (scenario.firmware.on_serial_line) cable_.emplace(places.casd_tty(), places.firmware_tty());
}

void FirmwareBench::start() {
  start_casd();
  tell_how_to_watch(places_.command_port, std::nullopt);
  std::vector<std::string> hilsim{program("hilsim"), places_.simulator_config(),
                                  "--control",       places_.simulator_control(),
                                  "--output",        places_.out,
                                  "--stats",         places_.simulator_stats()};
  for (const std::filesystem::path& folder : base::plugin_dirs()) {
    hilsim.insert(hilsim.end(), {"--plugin-dir", folder});
  }
  hilsim_ = &supervisor_.start(options("hilsim", hilsim), Supervisor::kReadyTimeout);
  for (std::size_t i = 0; i < scenario_.vehicles.size(); ++i) {
    firmware_.push_back(&supervisor_.start(firmware_options(i), Supervisor::kReadyTimeout));
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
  ChildProcess::Options options = firmware_options(vehicle);
  options.appends = true;
  firmware_[vehicle] = &supervisor_.start(std::move(options), Supervisor::kReadyTimeout);
}

void FirmwareBench::kill_casd() {
  if (casd_ == nullptr) return;
  supervisor_.kill(*casd_);
  casd_ = nullptr;
  logs_.set_aside();
}

void FirmwareBench::start_casd() {
  if (casd_ != nullptr) return;
  casd_ = &supervisor_.start(
      options("casd", {program("casd"), places_.casd_config(), "--name", scenario_.name}),
      Supervisor::kReadyTimeout);
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
  const auto config = base::find_config("firmware/quad_x.parm").parent_path().parent_path();
  const std::map<std::string, std::string> own{
      {"CAS_FCU_TTY", places_.firmware_tty().string()},
      {"CAS_CONFIG", config.string()},
      {"CAS_INSTANCE", std::to_string(instance)},
      {"CAS_SYSTEM", std::to_string(system_of_instance(instance))}};
  const auto text = [&own](const std::string& written) { return with_variables(written, own); };
  std::vector<std::string> arguments;
  for (const std::string& word : scenario_.firmware.command) arguments.push_back(text(word));
  ChildProcess::Options options =
      this->options("firmware" + scenario_.suffix_of(instance), arguments);
  options.says_ready = false;
  options.cwd = scenario_.firmware.cwd.empty()
                    ? places_.run / options.name
                    : std::filesystem::path(text(scenario_.firmware.cwd));
  std::filesystem::create_directories(options.cwd);
  for (const auto& [name, value] : scenario_.firmware.environment) {
    options.environment.push_back(name + "=" + text(value));
  }
  return options;
}

}  // namespace cas::hils
