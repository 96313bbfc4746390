// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include "base/time/rate_gate.hpp"
#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

constexpr std::uint32_t kBatteryStatus = 147;
constexpr std::uint32_t kStatusText = 253;
constexpr double kRateHz = 10;

/// Sends declared, undeclared and oversized messages; reports figures whose names are unsafe in
/// HTML, file names or numbers.
class FakeSender final : public sim::Plugin {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode&) override {
    mavlink_ = context.mavlink();
    sine_ = context.figure("<script>alert(\"sine\")</script>", "\"&<b>");
    path_ = context.figure("../../etc/passwd", "\xC2\xB5V");
    sum_ = context.figure("sum & <i>total</i>", "", sim::FigureKind::kScalar);
    never_ = context.figure("never", "V", sim::FigureKind::kScalar);
  }

  void post_step(const sim::StepInfo& step, const sim::World&) override {
    if (!rate_.due(step.time)) return;
    publish(kBatteryStatus, 36);
    publish(114, 44);  // HIL_OPTICAL_FLOW
    publish(kStatusText, 51);
    publish(kBatteryStatus, 200);
    const double time_s = base::to_seconds(step.time);
    sine_.publish({step.time, std::sin(time_s)});
    path_.publish({step.time, time_s});
    path_.publish({step.time, std::numeric_limits<double>::quiet_NaN()});
    sum_.publish({step.time, total_ += 1});
  }

  void reset() override {
    rate_.reset();
    total_ = 0;
  }

 private:
  void publish(std::uint32_t id, std::size_t size) const {
    sim::MavlinkMessage message;
    message.id = id;
    message.size = size;
    message.payload.fill(1);
    mavlink_.publish(message);
  }

  base::RateGate rate_{kRateHz};
  double total_ = 0;
  sim::Publisher<sim::MavlinkMessage> mavlink_;
  sim::Publisher<sim::FigureSample> sine_, path_, sum_, never_;
};

}  // namespace

CAS_PLUGIN(FakeSender, "fake_sender")
CAS_PLUGIN_SENDS("147", "HIL_OPTICAL_FLOW", "OPTICAL_FLOW")
