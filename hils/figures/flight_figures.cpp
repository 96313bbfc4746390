// SPDX-License-Identifier: BSD-3-Clause
#include "hils/figures/flight_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/config/config.hpp"
#include "base/config/sensor_set.hpp"
#include "base/config/vehicle.hpp"
#include "base/earth/frames.hpp"
#include "fcu/estimation/sensor_figures.hpp"
#include "fcu/estimation_bound/estimation_bound.hpp"
#include "hils/figures/flight_batch.hpp"
#include "hils/figures/flight_hover.hpp"
#include "hils/virtual/direct_flight.hpp"

namespace cas::hils {

namespace {

using Eigen::Vector3d;

constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};

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

std::vector<FlightFigure> figure_eight_figures(const FlightBatch& batch) {
  struct Eight {
    double square = NAN;
    double samples = 0;
    double fastest = 0;
  };
  const auto flights = fly_batch<Eight>(batch, [](std::uint64_t seed) {
    DirectFlight flight({.sensors = "rtk", .seed = seed});
    Eight out;
    if (!begin_hover(flight, 10)) return out;
    flight.set_param("CAS_TRJ_SIZE", 4);
    flight.set_param("CAS_TRJ_SPEED", 2);
    flight.set_param("CAS_TRJ_SHAPE", 2);
    flight.run(10);
    out.square = 0;
    flight.run(40, [&] {
      const auto truth = flight.truth();
      out.square += (truth.p_N - flight.status().reference_N).squaredNorm();
      out.samples += 1;
      out.fastest = std::max(out.fastest, truth.v_N.norm());
    });
    return out;
  });
  Eight all{0, 0, 0};
  for (const Eight& eight : flights) {
    all.square += eight.square;
    all.samples += eight.samples;
    all.fastest = std::max(all.fastest, eight.fastest);
  }
  return {{"figure eight at 2 m/s, rtk: truth against reference",
           std::sqrt(all.square / all.samples), 0.15, "m",
           fmt::format("fastest {:.2f} m/s", all.fastest)}};
}

std::vector<FlightFigure> wind_figures(const FlightBatch& batch) {
  struct Wind {
    double square = NAN;
    double samples = 0;
    double worst = 0;
  };
  const auto flights = fly_batch<Wind>(batch, [](std::uint64_t seed) {
    DirectFlight flight({.sensors = "rtk",
                         .seed = seed,
                         .wind_m_s = 8,
                         .turbulence_w20_m_s = kLightTurbulence_m_s});
    Wind out;
    if (!begin_hover(flight, 10)) return out;
    out.square = 0;
    flight.run(50, [&] {
      const double off = (flight.truth().p_N - kHoverPlace_N).squaredNorm();
      out.square += off;
      out.samples += 1;
      out.worst = std::max(out.worst, std::sqrt(off));
    });
    return out;
  });
  Wind all{0, 0, 0};
  for (const Wind& wind : flights) {
    all.square += wind.square;
    all.samples += wind.samples;
    all.worst = std::max(all.worst, wind.worst);
  }
  return {{"8 m/s wind, light turbulence, rtk: truth against reference",
           std::sqrt(all.square / all.samples), 0.5, "m",
           fmt::format("worst {:.2f} m", all.worst)}};
}

}  // namespace cas::hils
