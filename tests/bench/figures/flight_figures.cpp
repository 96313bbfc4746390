// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/figures/flight_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "base/config/config.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"
#include "base/earth/frames.hpp"
#include "base/random.hpp"
#include "fcu/estimation/sensor_figures.hpp"
#include "hils/measure/judgement.hpp"
#include "tests/bench/estimation_bound/estimation_bound.hpp"
#include "tests/bench/figures/direct_flight.hpp"
#include "tests/bench/figures/flight_batch.hpp"

namespace cas::hils {

namespace {

constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
constexpr double kHoverHeight_m = 2.5;
constexpr double kLightTurbulence_m_s = 15 * 0.514444;  // W20 of MIL-F-8785C, 15 knots
const Eigen::Vector3d kHoverPlace_N(0, 0, -kHoverHeight_m);

/// Takes off, goes to the place of the hover, nose to the north, and waits.
bool begin_hover(DirectFlight& flight, double settle_s) {
  if (!flight.take_off(kHoverHeight_m)) return false;
  flight.go_to(0, 0, kHoverHeight_m, 0);
  flight.run(settle_s);
  return true;
}

// Hover.

/// Sums of squares of one flight.
struct HoverSums {
  std::array<double, 4> truth{};     ///< truth minus reference: x, y, z in m, yaw in rad
  std::array<double, 4> estimate{};  ///< estimate minus truth
  double samples = 0;

  void add(const DirectFlight& flight) {
    const auto truth_now = flight.truth();
    const auto& status = flight.status();
    const double yaw = base::euler_rpy(status.q_ND).z();
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      truth[i] += std::pow(truth_now.p_N[axis] - kHoverPlace_N[axis], 2);
      estimate[i] += std::pow(status.p_N[axis] - truth_now.p_N[axis], 2);
    }
    truth[3] += std::pow(base::wrap_angle(truth_now.yaw_rad), 2);
    estimate[3] += std::pow(base::wrap_angle(yaw - truth_now.yaw_rad), 2);
    samples += 1;
  }
  void add(const HoverSums& other) {
    for (std::size_t i = 0; i < truth.size(); ++i) {
      truth[i] += other.truth[i];
      estimate[i] += other.estimate[i];
    }
    samples += other.samples;
  }
  double rms_truth(std::size_t i) const { return std::sqrt(truth[i] / samples); }
  double rms_estimate(std::size_t i) const { return std::sqrt(estimate[i] / samples); }
};

HoverSums pooled_hover(const std::string& sensors, const FlightBatch& batch) {
  constexpr double kSettle_s = 20;
  constexpr double kCounted_s = 40;
  const auto flights = fly_batch<HoverSums>(batch, [&](std::uint64_t seed) {
    DirectFlight flight({.sensors = sensors, .seed = seed});
    HoverSums sums;
    if (!begin_hover(flight, kSettle_s)) {
      sums.samples = NAN;  // shows in every figure
      return sums;
    }
    flight.run(kCounted_s, [&] { sums.add(flight); });
    return sums;
  });
  HoverSums all;
  for (const HoverSums& sums : flights) all.add(sums);
  return all;
}

fcu::EstimationBound best_possible(const std::string& sensors) {
  const auto node = base::ConfigNode::parse("sensors: " + sensors, "flight").at("sensors");
  return fcu::flight_bound(fcu::sensor_figures(base::sensor_set(node)));
}

std::optional<double> times(double factor, double value) {
  return factor > 0 ? std::optional(factor * value) : std::nullopt;
}

// Flights that have but one question: did it stay up?

struct Survival {
  bool up = false;
  double worst_m = 0;
};

/// Hovers for a minute; far away or on the ground is a crash.
Survival survive(DirectFlight& flight, double settle_s) {
  constexpr double kFlight_s = 60;
  Survival out;
  if (!begin_hover(flight, settle_s)) return out;
  flight.run(kFlight_s - settle_s, [&] {
    out.worst_m = std::max(out.worst_m, (flight.truth().p_N - kHoverPlace_N).norm());
  });
  constexpr double kFarthest_m = 2;
  out.up = flight.status().armed && flight.status().landed == fcu::LandedState::kInAir &&
           out.worst_m < kFarthest_m;
  return out;
}

double crashes(const std::vector<Survival>& flights) {
  return static_cast<double>(
      std::count_if(flights.begin(), flights.end(), [](const Survival& s) { return !s.up; }));
}

double worst(const std::vector<Survival>& flights) {
  double out = 0;
  for (const Survival& s : flights) out = std::max(out, s.worst_m);
  return out;
}

}  // namespace

std::vector<FlightFigure> hover_figures(const std::string& sensors, double estimate_factor,
                                        double tracking_factor, const FlightBatch& batch) {
  const HoverSums all = pooled_hover(sensors, batch);
  const fcu::EstimationBound best = best_possible(sensors);
  std::vector<FlightFigure> out;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    out.push_back({fmt::format("hover, {}: estimate {} against truth", sensors, kAxes[i]),
                   all.rms_estimate(i), times(estimate_factor, best.position_m[axis]), "m",
                   fmt::format("best possible {:.4f}", best.position_m[axis])});
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    constexpr std::array<double, 3> kPaper{0.0068, 0.0050, 0.0449};
    out.push_back({fmt::format("hover, {}: truth {} against reference", sensors, kAxes[i]),
                   all.rms_truth(i), times(tracking_factor, best.position_m[axis]), "m",
                   fmt::format("best possible {:.4f}; [HILS] SITL {:.4f}", best.position_m[axis],
                               kPaper[i])});
  }
  out.push_back({fmt::format("hover, {}: truth yaw against reference", sensors), all.rms_truth(3),
                 std::nullopt, "rad",
                 fmt::format("best possible {:.4f}; [HILS] SITL 0.0342", best.attitude_rad.z())});
  return out;
}

std::vector<FlightFigure> rtk_hover_figures(const FlightBatch& batch) {
  const HoverSums all = pooled_hover("rtk", batch);
  const fcu::EstimationBound best = best_possible("rtk");
  constexpr std::array<double, 4> kMost{0.02, 0.02, 0.045, 0.034};
  std::vector<FlightFigure> out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.push_back({fmt::format("hover, rtk: truth {} against reference", kAxes[i]),
                   all.rms_truth(i), kMost[i], "m",
                   fmt::format("best possible {:.4f}; estimate {:.4f}",
                               best.position_m[static_cast<int>(i)], all.rms_estimate(i))});
  }
  out.push_back({"hover, rtk: truth yaw against reference", all.rms_truth(3), kMost[3], "rad",
                 fmt::format("best possible {:.4f}", best.attitude_rad.z())});
  return out;
}

std::vector<FlightFigure> step_figures(const FlightBatch& batch) {
  struct Step {
    double settled_s = 1e9;
    double overshoot = 1e9;
  };
  const auto steps = fly_batch<Step>(batch, [](std::uint64_t seed) {
    constexpr double kHold_s = 6;  // between steps
    DirectFlight flight({.sensors = "rtk", .seed = seed});
    Step out;
    if (!begin_hover(flight, 10)) return out;
    flight.set_param("CAS_TRJ_SIZE", 1);
    flight.set_param("CAS_TRJ_PERIOD", kHold_s);
    flight.set_param("CAS_TRJ_SHAPE", 3);
    // The reference jumps from 0 to 1 m and back; the first whole step up counts.
    const auto reference = [&] { return flight.status().reference_N.x(); };
    flight.run_until([&] { return reference() < 0.5; }, 3 * kHold_s);
    if (!flight.run_until([&] { return reference() > 0.5; }, 3 * kHold_s)) return out;
    const double begin = flight.time_s();
    out = {0, 0};
    flight.run(kHold_s - 0.1, [&] {
      const double x = flight.truth().p_N.x();
      if (std::abs(x - 1) > 0.05) out.settled_s = flight.time_s() - begin;
      out.overshoot = std::max(out.overshoot, x - 1);
    });
    return out;
  });
  double slowest = 0, highest = 0;
  for (const Step& step : steps) {
    slowest = std::max(slowest, step.settled_s);
    highest = std::max(highest, step.overshoot);
  }
  return {{"step of 1 m, rtk: settled into 5 %, slowest", slowest, 3.0, "s", ""},
          {"step of 1 m, rtk: overshoot, largest", 100 * highest, 10.0, "%", ""}};
}

/// How far a vehicle is from where it should be, over its samples.
struct Deviation {
  double square = NAN;  ///< their sum, m^2; NaN: it did not get there
  double samples = 0;
  double peak = 0;  ///< of another quantity that the figure tells

  void add(double off_squared, double value) {
    square = (samples == 0 ? 0 : square) + off_squared;
    samples += 1;
    peak = std::max(peak, value);
  }
};

Deviation sum(const std::vector<Deviation>& flights) {
  Deviation all{.square = 0};
  for (const Deviation& flight : flights) {
    all.square += flight.square;
    all.samples += flight.samples;
    all.peak = std::max(all.peak, flight.peak);
  }
  return all;
}

std::vector<FlightFigure> figure_eight_figures(const FlightBatch& batch) {
  const auto flights = fly_batch<Deviation>(batch, [](std::uint64_t seed) {
    DirectFlight flight({.sensors = "rtk", .seed = seed});
    Deviation out;
    if (!begin_hover(flight, 10)) return out;
    flight.set_param("CAS_TRJ_SIZE", 4);
    flight.set_param("CAS_TRJ_SPEED", 2);
    flight.set_param("CAS_TRJ_SHAPE", 2);
    flight.run(10);
    flight.run(40, [&] {
      const auto truth = flight.truth();
      out.add((truth.p_N - flight.status().reference_N).squaredNorm(), truth.v_N.norm());
    });
    return out;
  });
  const Deviation all = sum(flights);
  return {{"figure eight at 2 m/s, rtk: truth against reference",
           std::sqrt(all.square / all.samples), 0.15, "m",
           fmt::format("fastest {:.2f} m/s", all.peak)}};
}

std::vector<FlightFigure> wind_figures(const FlightBatch& batch) {
  const auto flights = fly_batch<Deviation>(batch, [](std::uint64_t seed) {
    DirectFlight flight({.sensors = "rtk",
                         .seed = seed,
                         .wind_m_s = 8,
                         .turbulence_w20_m_s = kLightTurbulence_m_s});
    Deviation out;
    if (!begin_hover(flight, 10)) return out;
    flight.run(50, [&] {
      const double off = (flight.truth().p_N - kHoverPlace_N).squaredNorm();
      out.add(off, std::sqrt(off));
    });
    return out;
  });
  const Deviation all = sum(flights);
  return {{"8 m/s wind, light turbulence, rtk: truth against reference",
           std::sqrt(all.square / all.samples), 0.5, "m", fmt::format("worst {:.2f} m", all.peak)}};
}

std::vector<FlightFigure> poor_line_figures(const FlightBatch& batch) {
  struct Line {
    const char* name;
    double packet_loss;
    int delay_ms;
  };
  std::vector<FlightFigure> out;
  for (const Line& line :
       {Line{"1 packet in 10 lost each way", 0.1, 0}, Line{"10 ms more delay each way", 0, 10}}) {
    const auto flights = fly_batch<Survival>(batch, [&](std::uint64_t seed) {
      DirectFlightOptions options{.seed = seed};
      options.line.packet_loss = line.packet_loss;
      options.line.extra_delay = std::chrono::milliseconds(line.delay_ms);
      DirectFlight flight(options);
      return survive(flight, 10);
    });
    out.push_back({fmt::format("{}: flights that did not stay up, of {}", line.name, batch.flights),
                   crashes(flights), 0.0, "",
                   fmt::format("farthest off {:.2f} m", worst(flights))});
  }
  return out;
}

std::vector<FlightFigure> crash_figures(const FlightBatch& batch) {
  const auto flights = fly_batch<Survival>(batch, [](std::uint64_t seed) {
    base::NormalRandom random(base::derive_seed(seed, "vary"));
    DirectFlightOptions options{.seed = seed};
    options.mass_factor = 0.8 + 0.4 * random.uniform();
    options.wind_m_s = 6 * random.uniform();
    options.turbulence_w20_m_s = kLightTurbulence_m_s * random.uniform();
    options.yaw_rad = 2 * M_PI * random.uniform();
    DirectFlight flight(options);
    return survive(flight, 10);
  });
  return {{fmt::format("60 s, mass +-20 %, wind to 6 m/s: crashed, of {}", batch.flights),
           crashes(flights), 0.0, "", fmt::format("farthest off {:.2f} m", worst(flights))}};
}

int exit_code(const std::vector<FlightFigure>& figures) {
  return std::ranges::any_of(figures, &FlightFigure::missed) ? kExitLimitsMissed : kExitPassed;
}

}  // namespace cas::hils
