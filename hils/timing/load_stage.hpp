// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "base/time/rate_gate.hpp"
#include "hils/timing/echo_figures.hpp"
#include "hils/timing/line_demand.hpp"
#include "hils/timing/probe_stage.hpp"

namespace cas::hils {

/// Figures of a line under the load of one rate of HIL_SENSOR.
struct LoadFigures {
  double sensor_hz = 0;
  EchoFigures echoes{};
  double to_bytes_s = 0;       ///< offered
  double from_bytes_s = 0;     ///< that came
  double longest_gap_ms = 0;   ///< without a byte from the board
  double bytes_per_read = 0;   ///< that come together
  double late_median_ms = 0;   ///< of the round trips in the last quarter of the time
  double own_lateness_ms = 0;  ///< 99 % of the load was sent at most so late, by this machine
  bool overloaded = false;     ///< ended early: the oldest question was open for too long

  /// Whether the line kept up: hardly anything lost, and no queue that grew.
  bool kept() const;
};

/// The load of a HIL run, byte for byte, without its messages: at each sample's time it sends
/// padding and questions, together as long as a HIL_SENSOR, whose answers are as long as HIL's; the
/// same for HIL_GPS. Sent on time whether answers come or not, as a simulator does.
class LoadStage final : public ProbeStage {
 public:
  LoadStage(ProbeLine& line, const LineDemand& demand, QuestionKind kind, base::Duration length,
            base::RunTime begin);

  void turn(base::RunTime now) override;
  void on_answer(std::uint32_t number, base::RunTime now) override;
  void on_read(std::size_t bytes, base::RunTime now) override;
  base::RunTime wake() const override;
  bool done() const override { return done_; }

  LoadFigures figures() const;

 private:
  /// Ten times casd's age limit of HIL packets.
  static constexpr base::Duration kHopeless = std::chrono::milliseconds(250);
  /// Samples that are sent at once after a pause of this machine.
  static constexpr int kMostAtOnce = 20;

  base::RunTime tick_time(std::int64_t tick) const;
  void send_sample(base::RunTime now, base::Duration since_begin);
  void look_for_end(base::RunTime now);

  ProbeLine& line_;
  LineDemand demand_;
  QuestionKind kind_;
  base::RunTime begin_;
  base::RunTime end_;
  base::RateGate gps_;
  base::RateGate controls_;
  std::int64_t tick_ = 1;
  std::size_t asked_ = 0;
  std::size_t sent_bytes_ = 0;
  std::size_t read_bytes_ = 0;
  std::size_t reads_ = 0;
  std::optional<base::RunTime> last_read_;
  base::Duration longest_gap_{};
  std::vector<base::Duration> round_trips_;
  std::vector<base::Duration> late_round_trips_;
  std::vector<base::Duration> lateness_;
  base::RunTime stopped_at_{};
  bool overloaded_ = false;
  bool done_ = false;
};

}  // namespace cas::hils
