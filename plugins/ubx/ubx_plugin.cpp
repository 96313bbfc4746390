// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/config/config_whole.hpp"
#include "base/config/sensor_names.hpp"
#include "base/earth/frames.hpp"
#include "base/os/log.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/gps_time.hpp"
#include "plugins/common/serial_wire.hpp"
#include "plugins/ubx/ubx_receiver.hpp"

namespace cas::sim {
namespace {

constexpr unsigned kUsualBaud = 115'200;

/// Hands the fixes of a receiver (topic `gps`, or `gps_2`) to an autopilot as a u-blox does: UBX on
/// a serial line.
///
///   pre_step: bytes of the driver --> answers      fixes --> epochs
///   post_step: as many bytes as the line takes --> line
class UbxPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& node) override {
    const auto baud = base::get_whole_in<unsigned>(node, "baud", kUsualBaud, 9'600, 4'000'000);
    wire_ = SerialWire::make(node, baud);
    receiver_.emplace(baud);
    vehicle_ = context.vehicle_id();
    gps_start_ns_ = gps_time_ns(context.decimal_year());
    if (node.has("baseline_B_m")) baseline_B_m_ = node.require<Eigen::Vector3d>("baseline_B_m");
    const int number = base::get_whole_in<int>(node, "receiver", 1, 1, base::most_sensors("gps"));
    fixes_ = context.bus().subscribe<GpsSample>(context.topic(base::sensor_name("gps", number)),
                                                [this](const GpsSample& fix) { fix_ = fix; });
  }

  void pre_step(const StepInfo&, World&) override {
    constexpr int kMostReads = 4;  // a sender that never pauses is not waited for
    for (int i = 0; i < kMostReads; ++i) {
      const auto bytes = wire_->read(base::steady_now());
      if (bytes.empty()) break;
      receiver_->receive(bytes);
    }
    if (receiver_->configured() && !told_) {
      told_ = true;
      base::log::info(wire_->endpoint() + ": the autopilot takes its fixes from this line");
    }
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (fix_) send_epoch(world.state(vehicle_));
    now_ = step.time;
    if (!wire_->is_up() || wire_->unread() > kReaderBytes || !wire_->ready()) return;
    wire_->write(receiver_->next(step.time));
  }

  void reset() override {
    epoch_ += now_.time_since_epoch();  // for an autopilot that goes on, time does not turn back
    now_ = {};
    fix_.reset();
    receiver_->reset();
  }

  std::string stats_json() const override {
    const UbxReceiver::Counts& counts = receiver_->counts();
    return nlohmann::ordered_json{{"endpoint", wire_->endpoint()},
                                  {"up", wire_->is_up()},
                                  {"configured", receiver_->configured()},
                                  {"baud", receiver_->baud()},
                                  {"wanted_period_ms", receiver_->wanted_period_ms()},
                                  {"epochs", counts.epochs},
                                  {"dropped", counts.dropped},
                                  {"bytes", counts.bytes},
                                  {"answers", counts.answers},
                                  {"frames_in", receiver_->input().frames},
                                  {"bad_checksums", receiver_->input().bad_checksums},
                                  {"garbage_bytes", receiver_->input().garbage_bytes},
                                  {"write_errors", wire_->counts().write_errors},
                                  {"lost_lines", wire_->counts().lost_lines}}
        .dump();
  }

 private:
  /// The pseudo-terminal's buffer is left some room; the line stands meanwhile.
  static constexpr std::size_t kReaderBytes = 2048;

  void send_epoch(const BodyState& body) {
    const base::Duration since_start = epoch_ + fix_->time.time_since_epoch();
    UbxEpoch epoch{.gps_ns = gps_start_ns_ + static_cast<std::uint64_t>(since_start.count()),
                   .fix = *fix_};
    if (baseline_B_m_) {
      constexpr double kHeadingAccuracy_rad = 0.005;
      epoch.baseline_N = base::swap_WN(body.q_WB * *baseline_B_m_);
      epoch.heading_accuracy_rad = kHeadingAccuracy_rad;
    }
    receiver_->on_epoch(epoch);
    fix_.reset();
  }

  std::unique_ptr<SerialWire> wire_;
  std::optional<UbxReceiver> receiver_;
  VehicleId vehicle_{};
  std::uint64_t gps_start_ns_ = 0;
  std::optional<Eigen::Vector3d> baseline_B_m_;  // from the first antenna to the second
  std::optional<GpsSample> fix_;                 // newest, not told yet
  base::SimTime now_{};
  base::Duration epoch_{};  // total time of earlier runs
  bool told_ = false;
  Subscription fixes_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::UbxPlugin, "ubx")
