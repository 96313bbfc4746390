// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fcu/support/emulator_fixture.hpp"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/earth/atmosphere.hpp"
#include "base/earth/magnetic_field.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/sys_status.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu::test {

using namespace mavlink::common;  // NOLINT

EmulatorFixture::EmulatorFixture(const std::string& config) : link_(folder_ / "fcu0") {
  folder_.write("fcu.yaml",
                "schema: 1\nvehicle: " + cas::test::source_dir() +
                    "/config/vehicles/iris_paper.yaml\n"
                    "home_hint: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}\n" +
                    config);
  start();
}

EmulatorFixture::~EmulatorFixture() {
  if (fd_ >= 0) ::close(fd_);
}

void EmulatorFixture::start() {
  process_ = std::make_unique<cas::test::ChildProcess>(std::vector<std::string>{
      cas::test::binary_dir() + "/bin/fcu_emulator", config_file().string(), "--link",
      link_.string(), "--control", control_socket().string(), "--params", params_file().string()});
  if (!process_->wait_ready()) throw std::runtime_error("no emulator: " + process_->output());
  open();
}

void EmulatorFixture::restart() {
  ::close(fd_);
  fd_ = -1;
  process_->signal(SIGTERM);
  if (process_->wait_exit() != 0) throw std::runtime_error(process_->output());
  stream_ = {};
  start();
}

void EmulatorFixture::open() {
  fd_ = ::open(link_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (fd_ < 0) throw std::runtime_error("cannot open " + link_.string());
  termios settings{};
  ::tcgetattr(fd_, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(fd_, TCSANOW, &settings);
  hung_up_ = false;
}

bool EmulatorFixture::reopen() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  if (!cas::test::wait_until([&] { return std::filesystem::exists(link_); })) return false;
  open();
  return true;
}

void EmulatorFixture::send_bytes(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t gone = ::write(fd_, bytes.data(), bytes.size());
    if (gone > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(gone));
      continue;
    }
    if (gone < 0 && errno != EAGAIN && errno != EINTR) throw std::runtime_error("line is gone");
    read();  // the other side must not wait for us either
    pollfd room{fd_, POLLOUT, 0};
    ::poll(&room, 1, 10);
  }
}

bool EmulatorFixture::read() {
  std::array<std::uint8_t, 4096> buffer;
  bool any = false;
  while (fd_ >= 0) {
    const ssize_t n = ::read(fd_, buffer.data(), buffer.size());
    if (n == 0 || (n < 0 && errno == EIO)) hung_up_ = true;
    if (n <= 0) break;
    stream_.feed(std::span(buffer).first(static_cast<std::size_t>(n)));
    any = true;
  }
  return any;
}

void EmulatorFixture::forget() {
  read();
  stream_.packets().clear();
}

CommandLong EmulatorFixture::command(MavCmd id, std::array<float, 7> p) const {
  CommandLong m;
  m.target_system = 1;
  m.target_component = 1;
  m.command = id;
  m.param1 = p[0];
  m.param2 = p[1];
  m.param3 = p[2];
  m.param4 = p[3];
  m.param5 = p[4];
  m.param6 = p[5];
  m.param7 = p[6];
  return m;
}

std::optional<MavResult> EmulatorFixture::result(MavCmd id, std::array<float, 7> params) {
  send(command(id, params));
  const auto ack = next<CommandAck>([&](const auto& m) { return m.command == id; });
  return ack ? std::optional(ack->result) : std::nullopt;
}

void EmulatorFixture::stand_still(double seconds) {
  constexpr std::uint64_t kPeriod_us = 2000;
  constexpr int kUnansweredSensors = 40;  // their 2 kB of answers fit into a terminal's 4 kB
  constexpr double kGravity_m_s2 = 9.80665;
  const mav::Source simulator{1, 200};
  const Eigen::Vector3d field_N = base::magnetic_field_N(home_, 2026.5);
  const auto noisy = [this](double value, double sigma) {
    return static_cast<float>(value + sigma * random_());
  };
  const auto steps = static_cast<int>(seconds * 1e6 / kPeriod_us);
  for (int i = 0; i < steps; ++i) {
    sensor_usec_ += kPeriod_us;
    HilSensor m;
    m.time_usec = sensor_usec_;
    m.xacc = noisy(0, 0.04);
    m.yacc = noisy(0, 0.06);
    m.zacc = noisy(-kGravity_m_s2, 0.07);
    m.xgyro = noisy(0, 0.012);
    m.ygyro = noisy(0, 0.014);
    m.zgyro = noisy(0, 0.002);
    m.xmag = noisy(field_N.x(), 0.004);
    m.ymag = noisy(field_N.y(), 0.004);
    m.zmag = noisy(field_N.z(), 0.004);
    m.abs_pressure = noisy(base::isa::pressure_pa(home_.alt_m) / 100, 0.01);
    m.temperature = 15;
    m.fields_updated = static_cast<HilSensorUpdatedFlags>(0x1FFF);
    send(m, 2, simulator);
    if (i % kUnansweredSensors == 0) keep_up();
    if (sensor_usec_ % 200'000 != 0) continue;
    HilGps fix;
    fix.time_usec = sensor_usec_;
    fix.fix_type = 3;
    fix.lat = static_cast<std::int32_t>(std::llround(home_.lat_deg * 1e7 + 27 * random_()));
    fix.lon = static_cast<std::int32_t>(std::llround(home_.lon_deg * 1e7 + 40 * random_()));
    fix.alt = static_cast<std::int32_t>(std::llround(home_.alt_m * 1e3 + 300 * random_()));
    fix.vn = static_cast<std::int16_t>(std::lround(10 * random_()));
    fix.ve = static_cast<std::int16_t>(std::lround(10 * random_()));
    fix.eph = 42;
    fix.epv = 30;
    fix.satellites_visible = 10;
    send(fix, 2, simulator);
  }
}

// Waits until all sent packets are handled and their answers read: if the terminal is full, the
// controller drops packets. The packets stay where next() finds them.
void EmulatorFixture::keep_up() {
  Ping ping;
  ping.seq = ++pings_;
  send(ping);
  const auto is_answer = [&](const cas::test::PacketStream::Packet& packet) {
    const auto answer = mav::decode<Ping>(packet.view());
    return answer && answer->seq == ping.seq;
  };
  const bool answered = cas::test::wait_until([&] {
    read();
    return std::erase_if(stream_.packets(), is_answer) > 0;
  });
  if (!answered) throw std::runtime_error("the controller answers no PING");
}

void EmulatorFixture::settle() {
  const auto ready = [](const SysStatus& m) {
    return has(m.onboard_control_sensors_health, MavSysStatusSensor::kPrearmCheck);
  };
  const base::RunTime deadline = base::steady_now() + cas::test::kPatience;
  while (base::steady_now() < deadline) {
    stand_still(3);
    send(command(MavCmd::kRequestMessage, {static_cast<float>(SysStatus::kId)}));
    const auto status = next<SysStatus>();
    if (status && ready(*status)) return;
  }
  throw std::runtime_error("never ready to arm");
}

base::rpc::Json EmulatorFixture::call(const std::string& method) {
  return call(method, base::rpc::Json::object());
}

base::rpc::Json EmulatorFixture::call(const std::string& method, const base::rpc::Json& params) {
  return base::rpc::Client("unix:" + control_socket().string()).call(method, params);
}

}  // namespace cas::fcu::test
