// SPDX-License-Identifier: BSD-3-Clause
#include "tests/closed_loop/lockstep_fixture.hpp"

#include <signal.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "base/rpc/message.hpp"
#include "casd/tlog/tlog_files.hpp"
#include "hils/run/run_paths.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

namespace {

using base::rpc::Json;

const std::string kPrograms = cas::test::binary_dir() + "/bin/";
const std::string kConfig = cas::test::source_dir() + "/config/";

std::string endpoint(int port) { return "127.0.0.1:" + std::to_string(port); }

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void start(std::optional<ChildProcess>& program, const std::vector<std::string>& command) {
  program.emplace(command);
  if (!program->wait_ready()) {
    throw std::runtime_error(command.front() + " is not ready:\n" + program->output());
  }
}

}  // namespace

LockstepFixture::LockstepFixture(std::uint64_t seed, const std::string& vehicle) {
  const bool is_file = std::filesystem::path(vehicle).has_parent_path();
  const std::string vehicle_file =
      (is_file ? vehicle : kConfig + "vehicles/" + vehicle + ".yaml") + "\n";
  const auto ports = hils::free_udp_ports(2);
  const auto path = [this](const char* name) { return (folder_ / name).string(); };
  const std::string fcu =
      folder_.write("fcu.yaml", "schema: 1\npace: lockstep\nvehicle: " + vehicle_file).string();
  start(fcu_, {kPrograms + "fcu_emulator", fcu, "--link", path("fcu0")});
  start(casd_program_, {kPrograms + "casd", write_casd(ports[0], ports[1])});
  start(hilsim_, {kPrograms + "hilsim", write_simulator(seed, vehicle_file, ports[0], ports[1]),
                  "--paused", "--control", path("sim.sock"), "--output", folder_.path().string(),
                  "--plugin-dir", cas::test::binary_dir() + "/plugins"});
  simulator_.emplace("unix:" + path("sim.sock"));
  casd_.emplace("unix:" + path("casd.sock"));
  casd_->call("casd.status", Json::object());  // it ends clients that ask nothing for 10 s
}

std::string LockstepFixture::write_simulator(std::uint64_t seed, const std::string& vehicle_file,
                                             int port, int casd_port) {
  return folder_
      .write("sim.yaml",
             "schema: 1\nworld: {gravity_m_s2: 9.80665, ground: true}\n"
             "home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488}\n"
             "decimal_year: 2026.5\npace: lockstep\npacing: {lockstep_timeout_ms: 20000}\n"
             "seed: " +
                 std::to_string(seed) +
                 "\nvehicles:\n  - name: iris0\n    vehicle: " + vehicle_file +
                 "    pose: {yaw_deg: 90}\n    plugins:\n"
                 "      - {plugin: motor}\n      - {plugin: imu}\n      - {plugin: gps}\n"
                 "      - {plugin: magnetometer}\n      - {plugin: barometer}\n"
                 "      - {plugin: mavlink_interface, transport: udp, local: '" +
                 endpoint(port) + "', remote: '" + endpoint(casd_port) +
                 "'}\n      - {plugin: recorder, file: truth.csv, rate_hz: 100}\n")
      .string();
}

std::string LockstepFixture::write_casd(int port, int casd_port) {
  return folder_
      .write("casd.yaml",
             "schema: 1\npace: lockstep\ncommand_port: {port: 0, loopback_without_token: true, "
             "unix: " +
                 (folder_ / "casd.sock").string() +
                 "}\nlinks:\n  - {name: sim, type: udp, local: '" + endpoint(casd_port) +
                 "', remote: '" + endpoint(port) + "'}\n  - {name: fcu, type: serial, device: " +
                 (folder_ / "fcu0").string() + "}\nlog: {folder: " + folder_.path().string() +
                 ", tlog: flight.tlog, overwrite: true}\ngains: " + kConfig + "gains.yaml\n")
      .string();
}

Json LockstepFixture::run_until(double time_s) {
  return simulator_->call("sim.run_until", {{"time_s", time_s}}, std::chrono::seconds(60));
}

Json LockstepFixture::command(const std::string& method, const Json& params) {
  // A question first: its answer follows all that the vehicle has said.
  casd_->call("param.get", {{"name", "SYS_HITL"}});
  return casd_->call(method, params);
}

bool LockstepFixture::wait_heard() {
  return wait_until([this] {
    try {
      casd_->call("vehicle.state", Json::object());
      return true;
    } catch (const base::rpc::CallError& error) {
      if (error.code() != base::rpc::kNoSuchVehicle) throw;
      return false;
    }
  });
}

bool LockstepFixture::stop() {
  bool well = true;
  for (auto* program : {&hilsim_, &casd_program_, &fcu_}) {
    (*program)->signal(SIGTERM);
    well = (*program)->wait_exit() == 0 && well;
  }
  return well;
}

std::string LockstepFixture::truth() const { return content(folder_ / "truth.csv"); }

std::string LockstepFixture::recording() const { return content(folder_ / "flight.tlog"); }

std::map<int, std::string> LockstepFixture::streams() const {
  casd::TlogReader log;
  if (!log.open(folder_ / "flight.tlog")) throw std::runtime_error("there is no flight.tlog");
  std::map<int, std::string> streams;
  mav::PacketParser parser(mavlink::common::table());
  while (const auto record = log.next()) {
    parser.reset();
    parser.feed(record->packet, [&](const mav::PacketView& packet) {
      // The simulator speaks as component 200 of the vehicle's system.
      streams[256 * packet.source.system + packet.source.component].append(
          reinterpret_cast<const char*>(packet.bytes.data()), packet.bytes.size());
    });
  }
  return streams;
}

std::string LockstepFixture::outputs() const {
  std::string text;
  for (const auto* program : {&hilsim_, &casd_program_, &fcu_}) {
    if (*program) text += (*program)->output();
  }
  return text;
}

}  // namespace cas::test
