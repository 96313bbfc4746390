// SPDX-License-Identifier: BSD-3-Clause
// Flights that have but one question: did it stay up?
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/random.hpp"
#include "hils/figures/flight_batch.hpp"
#include "hils/figures/flight_figures.hpp"
#include "hils/figures/flight_hover.hpp"
#include "hils/virtual/direct_flight.hpp"

namespace cas::hils {

namespace {

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

}  // namespace cas::hils
