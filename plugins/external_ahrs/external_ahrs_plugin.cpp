// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/config/config_whole.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"
#include "base/enum_words.hpp"
#include "base/os/log.hpp"
#include "base/text.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/gps_time.hpp"
#include "plugins/common/serial_wire.hpp"
#include "plugins/external_ahrs/attitude_solution.hpp"
#include "plugins/external_ahrs/vector_nav.hpp"

namespace cas::sim {
namespace {

constexpr base::EnumWords<UnitModel::kVn300> kModels{"VN-100", "VN-200", "VN-300"};
constexpr unsigned kUsualBaud = 921'600;
/// Input buffer of ArduPilot's driver: a board loses what goes beyond it.
constexpr std::size_t kReaderBytes = 1024;

enum class SolutionSource : std::uint8_t { kTruth, kSensors };
constexpr base::EnumWords<SolutionSource::kSensors> kSources{"truth", "sensors"};

template <auto kLast>
auto word_of(const base::ConfigNode& node, const char* key, const base::EnumWords<kLast>& words,
             decltype(kLast) fallback) {
  const auto child = node.find(key);
  if (!child) return fallback;
  const auto found = words.find(child->as<std::string>());
  if (found) return *found;
  child->fail("is one of " + base::joined(words.words, ", "));
}

/// GPS_FIX_TYPE as VectorNav numbers its fixes.
std::uint8_t unit_fix_type(std::uint8_t fix_type) {
  constexpr std::array<std::uint8_t, 7> kTypes{0, 0, 2, 3, 4, 7, 8};
  return fix_type < kTypes.size() ? kTypes[fix_type] : std::uint8_t{3};
}

/// Gives a stock ArduPilot its sensors: a VectorNav on a serial line of its own (ArduPilot's
/// "External AHRS"). Motors come back over MAVLink.
///
///   pre_step: lines of the driver --> answers      samples --> readings
///   post_step: packets that are due --> line
class ExternalAhrsPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& node) override {
    const UnitModel model = word_of(node, "model", kModels, UnitModel::kVn200);
    const auto baud = base::get_whole_in<unsigned>(node, "baud", kUsualBaud, 9'600, 4'000'000);
    source_ = word_of(node, "solution", kSources, SolutionSource::kTruth);
    wire_ = SerialWire::make(node, baud);
    unit_.emplace(model, baud);
    readings_.has_second_receiver = model == UnitModel::kVn300;
    vehicle_ = context.vehicle_id();
    projection_ = context.projection();
    gps_start_ns_ = gps_time_ns(context.decimal_year());
    declination_rad_ = base::magnetic_declination(projection_.home(), context.decimal_year());
    solution_.emplace(declination_rad_);
    subscribe(context);
  }

  void pre_step(const StepInfo& step, World&) override {
    for (auto bytes = wire_->read(base::steady_now()); !bytes.empty();
         bytes = wire_->read(base::steady_now())) {
      if (!is_cut_) unit_->receive(bytes);
      if (bytes.size() < kReaderBytes) break;  // a sender that never pauses is not waited for
    }
    tell_changes();
    if (wire_->ready()) wire_->write(bytes_of(unit_->take_answers(step.time)));
  }

  void post_step(const StepInfo& step, const World& world) override {
    unit_->advance(step.time);
    unit_->on_unsent(step.time, wire_->unsent());
    if (wire_->unread() > kReaderBytes) {
      ++reader_full_;
      return;
    }
    while (wire_->ready()) {
      take_readings(step.time, world);
      const auto packet = unit_->next(step.time, readings_, fresh_);
      if (packet.empty()) return;
      if (is_cut_) {
        ++cut_off_;
        continue;
      }
      wire_->write(packet);
      note_gap();
    }
  }

  void reset() override {
    epoch_ += newest_.time_since_epoch();  // for a board that goes on, time does not turn back
    newest_ = {};
    unit_->reset();
    solution_.emplace(declination_rad_);
    last_inertial_.reset();
    fresh_ = {};
    has_ = {};
    is_cut_ = false;
  }

  std::string stats_json() const override {
    const UnitRegisters::Counts& lines = unit_->registers().counts();
    const VectorNav::Counts& packets = unit_->counts();
    nlohmann::ordered_json rates = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < UnitRegisters::kOutputs; ++i) rates.push_back(unit_->rate_hz(i));
    return nlohmann::ordered_json{{"endpoint", wire_->endpoint()},
                                  {"up", wire_->is_up()},
                                  {"asked", unit_->registers().asked()},
                                  {"running", unit_->registers().running()},
                                  {"rates_hz", rates},
                                  {"packets", packets.sent[0] + packets.sent[1] + packets.sent[2]},
                                  {"sent", packets.sent},
                                  {"bytes", packets.bytes},
                                  {"dropped", packets.dropped},
                                  {"late", packets.late},
                                  {"without_sample", packets.without_sample},
                                  {"reader_full", reader_full_},
                                  {"cut_off", cut_off_},
                                  {"longest_wait_us", packets.longest_wait.count() / 1000},
                                  {"longest_gap_ms", 1e3 * base::to_seconds(longest_gap_)},
                                  {"lines", lines.lines},
                                  {"refused", lines.refused},
                                  {"crc_errors", lines.bad_checksums},
                                  {"garbage_bytes", lines.garbage_bytes},
                                  {"write_errors", wire_->counts().write_errors},
                                  {"lost_lines", wire_->counts().lost_lines}}
        .dump();
  }

 private:
  /// Samples that have come at least once.
  struct Has {
    bool field = false;
    bool air = false;
  };

  static std::span<const std::uint8_t> bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  }

  void subscribe(PluginContext& context) {
    imu_ = context.bus().subscribe<ImuSample>(
        context.topic("imu"), [this](const ImuSample& sample) { on_inertial(sample); });
    magnetometer_ = context.bus().subscribe<MagnetometerSample>(
        context.topic("magnetometer"), [this](const MagnetometerSample& sample) {
          readings_.field_D = base::swap_BD(sample.field_B_gauss);
          solution_->on_field(readings_.field_D);
          has_.field = true;
        });
    barometer_ = context.bus().subscribe<BarometerSample>(
        context.topic("barometer"), [this](const BarometerSample& sample) {
          readings_.pressure_pa = sample.pressure_pa;
          readings_.temperature_degc = sample.temperature_degc;
          has_.air = true;
        });
    gps_ = context.bus().subscribe<GpsSample>(context.topic("gps"),
                                              [this](const GpsSample& sample) { on_fix(sample); });
    line_cut_ = context.bus().subscribe<LineCut>(
        context.topic("line_cut"), [this](const LineCut& line) { on_cut(line.cut); },
        Need::kOptional);
  }

  /// A gap by a fault is none of the machine's.
  void on_cut(bool cut) {
    is_cut_ = cut;
    last_sent_.reset();
  }

  /// The packet of an inertial sample carries field and air as well: without them it waits.
  void on_inertial(const ImuSample& sample) {
    readings_.accel_D = base::swap_BD(sample.specific_force_B);
    readings_.gyro_D = base::swap_BD(sample.angular_rate_B);
    if (last_inertial_) {
      solution_->on_inertial(readings_.accel_D, readings_.gyro_D,
                             base::to_seconds(sample.time - *last_inertial_));
    }
    last_inertial_ = sample.time;
    fresh_.inertial = has_.field && has_.air;
  }

  void on_fix(const GpsSample& sample) {
    const bool has_place =
        sample.velocity_N.allFinite() && std::isfinite(sample.position.lat_deg) &&
        std::isfinite(sample.position.lon_deg) && std::isfinite(sample.position.alt_m);
    UnitFix fix;
    fix.satellites = sample.satellites;
    fix.horizontal_sigma_m = sample.eph_m;
    fix.vertical_sigma_m = sample.epv_m;
    if (has_place) {
      fix.type = unit_fix_type(sample.fix_type);
      fix.position = sample.position;
      fix.velocity_N = sample.velocity_N;
      fix.velocity_sigma_m_s = kVelocitySigma_m_s;
    }
    readings_.fix = fix;
    fix_time_ = sample.time;
    fresh_.fix = true;
  }

  void take_readings(base::SimTime now, const World& world) {
    newest_ = now;
    const base::Duration since_start = epoch_ + now.time_since_epoch();
    readings_.startup_ns = static_cast<std::uint64_t>(since_start.count());
    readings_.gps_ns = gps_start_ns_ + readings_.startup_ns;
    if (source_ == SolutionSource::kTruth) {
      take_truth(world.state(vehicle_));
    } else {
      take_sensors(now);
    }
  }

  void take_truth(const BodyState& body) {
    UnitSolution& solution = readings_.solution;
    solution.q_ND = base::q_ND_from_q_WB(body.q_WB);
    solution.position = projection_.to_geodetic(base::swap_WN(body.p_WB));
    solution.velocity_N = base::swap_WN(body.v_WB);
    solution.attitude_sigma_deg = 0.1;
    solution.position_sigma_m = 0.1;
    solution.velocity_sigma_m_s = 0.05;
  }

  /// Place and velocity are the receiver's, carried on by the velocity since the fix.
  void take_sensors(base::SimTime now) {
    UnitSolution& solution = readings_.solution;
    const UnitFix& fix = readings_.fix;
    solution.q_ND = solution_->q_ND();
    const Eigen::Vector3d p_N =
        projection_.to_local(fix.position) + fix.velocity_N * base::to_seconds(now - fix_time_);
    solution.position = projection_.to_geodetic(p_N);
    solution.velocity_N = fix.velocity_N;
    solution.attitude_sigma_deg = 1;
    solution.position_sigma_m = fix.horizontal_sigma_m;
    solution.velocity_sigma_m_s = fix.velocity_sigma_m_s;
  }

  /// By the wall clock: ArduPilot stamps a sample when it arrives.
  void note_gap() {
    const base::RunTime now = base::steady_now();
    if (unit_->counts().sent == sent_before_) return;
    sent_before_ = unit_->counts().sent;
    if (last_sent_) longest_gap_ = std::max(longest_gap_, now - *last_sent_);
    last_sent_ = now;
  }

  /// Once for each change.
  void tell_changes() {
    const UnitRegisters& registers = unit_->registers();
    if (registers.running() != was_running_) {
      was_running_ = registers.running();
      last_sent_.reset();
      base::log::info(wire_->endpoint() + (was_running_
                                               ? ": the board takes its sensors from this line"
                                               : ": the board has paused this line"));
    }
    if (registers.refusal() != told_refusal_) {
      told_refusal_ = registers.refusal();
      base::log::warn(wire_->endpoint() + ": refused: " + told_refusal_);
    }
  }

  static constexpr double kVelocitySigma_m_s = 0.1;  // a receiver's usual claim

  std::unique_ptr<SerialWire> wire_;
  std::optional<VectorNav> unit_;
  SolutionSource source_ = SolutionSource::kTruth;
  VehicleId vehicle_{};
  base::LocalProjection projection_;
  std::uint64_t gps_start_ns_ = 0;
  double declination_rad_ = 0;
  std::optional<AttitudeSolution> solution_;
  UnitReadings readings_;
  FreshSamples fresh_;
  Has has_;
  std::optional<base::SimTime> last_inertial_;
  base::SimTime fix_time_{};
  base::SimTime newest_{};
  base::Duration epoch_{};  // total time of earlier runs of this board
  bool was_running_ = false;
  std::string told_refusal_;
  std::uint64_t reader_full_ = 0;
  bool is_cut_ = false;        // by a fault
  std::uint64_t cut_off_ = 0;  // packets that left while it was
  std::array<std::uint64_t, UnitRegisters::kOutputs> sent_before_{};
  std::optional<base::RunTime> last_sent_;
  base::Duration longest_gap_{};  // between two packets, by the wall clock
  Subscription imu_;
  Subscription gps_;
  Subscription magnetometer_;
  Subscription barometer_;
  Subscription line_cut_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::ExternalAhrsPlugin, "external_ahrs")
