// SPDX-License-Identifier: BSD-3-Clause
#include "tests/loopback/flight_fixture.hpp"

#include <cmath>
#include <stdexcept>

#include "tests/support/free_port.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

const std::string kPrograms = cas::test::binary_dir() + "/bin/";
const std::string kConfig = cas::test::source_dir() + "/config/";

std::string replaced(std::string text, const std::string& word, const std::string& by) {
  for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + by.size())) {
    text.replace(at, word.size(), by);
  }
  return text;
}

const char* const kWorld = R"(schema: 1
world: {gravity_m_s2: 9.80665, ground: true}
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
decimal_year: 2026.5
step_us: 1000
pace: realtime
seed: 1
vehicles:
  - name: iris0
    vehicle: $CONFIG/vehicles/iris_paper.yaml
    plugins:
      - {plugin: motor}
      - {plugin: imu}
      - {plugin: gps}
      - {plugin: magnetometer}
      - {plugin: barometer}
      - {plugin: mavlink_interface, transport: udp, local: "127.0.0.1:$SIM", remote: "127.0.0.1:$CASD"}
)";

const char* const kTopology = R"(schema: 1
command_port: {port: 0, loopback_without_token: true}
gains: $CONFIG/gains.yaml
links:
  - {name: sim, type: udp, local: "127.0.0.1:$CASD", remote: "127.0.0.1:$SIM"}
  - {name: fcu, type: serial, device: $DIR/fcu0, baud: 921600}
  - {name: gcs, type: udp_server, local: "127.0.0.1:0"}
routes:
  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]}
  - {from: fcu, to: sim, allow: [HEARTBEAT, HIL_CONTROLS]}
  - {from: gcs, to: fcu}
  - {from: fcu, to: gcs, block: [HIL_CONTROLS]}
)";

}  // namespace

FlightFixture::FlightFixture(const std::string& more) {
  const auto filled = [&, sim = std::to_string(free_port()),
                       casd = std::to_string(free_port())](std::string text) {
    text = replaced(replaced(std::move(text), "$SIM", sim), "$CASD", casd);
    return replaced(replaced(std::move(text), "$CONFIG/", kConfig), "$DIR", folder.path().string());
  };
  topology_ = folder.write("casd.yaml", filled(kTopology + more));
  folder.write("world.yaml", filled(kWorld));
}

void FlightFixture::start_controller() {
  fcu_ = std::make_unique<ChildProcess>(
      std::vector<std::string>{kPrograms + "fcu_emulator", kConfig + "fcu/iris_paper.yaml",
                               "--link", (folder / "fcu0").string()});
  if (!fcu_->wait_ready()) throw std::runtime_error(fcu_->output());
}

void FlightFixture::start_simulator() {
  hilsim_ = std::make_unique<ChildProcess>(
      std::vector<std::string>{kPrograms + "hilsim", (folder / "world.yaml").string()});
  if (!hilsim_->wait_ready()) throw std::runtime_error(hilsim_->output());
}

void FlightFixture::start_vehicle() {
  start_controller();
  start_simulator();
}

void FlightFixture::start_casd() {
  casd_ = std::make_unique<Supervisor>(
      UnitFile::load(kConfig + "systemd/casd.service"),
      std::map<std::string, std::string>{{"/usr/bin/casd", kPrograms + "casd"},
                                         {"/etc/cas/casd.yaml", topology_.string()}});
  connect();
}

void FlightFixture::connect() {
  client_.reset();
  const auto status = casd_->wait_ready();
  if (!status) throw std::runtime_error(casd_->output());
  status_ = *status;
  client_.emplace(word_after(status_, "command_port"));
}

json FlightFixture::call(const std::string& method, const json& params) {
  return client_->call(method, params);
}

bool FlightFixture::command(const std::string& method, const json& params) {
  return wait_until(
      [&] {
        try {
          call(method, params);
          return true;
        } catch (const base::rpc::CallError&) {
          return false;
        }
      },
      std::chrono::seconds(60));
}

bool FlightFixture::fly_to(double altitude_m) {
  if (!command("vehicle.arm") || !command("vehicle.takeoff", {{"altitude_m", altitude_m}})) {
    return false;
  }
  return wait_until([&] { return std::abs(state().value("altitude_m", 0.0) - altitude_m) < 0.3; },
                    std::chrono::seconds(60));
}

bool FlightFixture::land() {
  return command("vehicle.land") &&
         wait_until([&] { return state().value("landed", "") == "on_ground"; },
                    std::chrono::seconds(60));
}

}  // namespace cas::test
