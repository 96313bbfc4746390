// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/timing_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace cas::hils {

namespace {

std::string demand_words(const LineDemand& demand) {
  return fmt::format("{:g} Hz HIL_SENSOR (plus {:g} Hz HIL_GPS, {:g} Hz answers)", demand.sensor_hz,
                     demand.gps_hz, demand.controls_hz);
}

double used(const casd::LineBudget& budget) {
  return budget.capacity_bytes_s > 0 ? budget.load_bytes_s() / budget.capacity_bytes_s : 2;
}

std::string too_much(const casd::LineBudget& budget) {
  return fmt::format("{} it takes {:.1f} kB/s of {:.1f}", budget.link, budget.load_bytes_s() / 1e3,
                     budget.capacity_bytes_s / 1e3);
}

const LoadFigures* load_of(const LineFigures& figures, double sensor_hz) {
  const auto found = std::ranges::find(figures.loads, sensor_hz, &LoadFigures::sensor_hz);
  return found == figures.loads.end() ? nullptr : &*found;
}

double period_ms(double hz) { return 1e3 / hz; }

/// Advice if the wanted rate does not fit: a measured rate that does, else a faster line.
std::string remedy(const LineFigures& figures, const casd::LineBudget& fuller,
                   TimingVerdict& verdict) {
  std::string words;
  if (!figures.slower.empty() && figures.slower.back().kept()) {
    verdict.fitting_sensor_hz = figures.slower.back().sensor_hz;
    words = fmt::format("; {:g} Hz fits", *verdict.fitting_sensor_hz);
  } else {
    words = "; no usual rate fits";
  }
  if (!fuller.fits() && fuller.fitting_baud() > 0) {
    words += fmt::format("; {} baud would carry it", fuller.fitting_baud());
  }
  return words;
}

/// The line has room for the bytes, and yet did not keep up.
std::string failure_under(const LoadFigures& load) {
  if (load.overloaded) return fmt::format("at {:g} Hz answers came ever later", load.sensor_hz);
  if (load.echoes.lost() > 1) {
    return fmt::format("at {:g} Hz {} of {} questions had no answer", load.sensor_hz,
                       load.echoes.lost(), load.echoes.asked);
  }
  return fmt::format("at {:g} Hz a round trip took {:.0f} ms in the end", load.sensor_hz,
                     load.late_median_ms);
}

void add_notes(const LineFigures& figures, const LineDemand& demand, TimingVerdict& verdict) {
  const auto note = [&verdict](std::string sentence) {
    verdict.notes.push_back(std::move(sentence));
  };
  if (!figures.in_hil) {
    note("the board does not say that it is in HIL: it would not be flown (docs/use/pixhawk.md)");
  }
  if (figures.crc_errors > 0) {
    note(
        fmt::format("{} packets came damaged: compare the baud rates of both ends, look at cable "
                    "and ground",
                    figures.crc_errors));
  }
  const LoadFigures* load = load_of(figures, demand.sensor_hz);
  if (load == nullptr) return;
  if (load->longest_gap_ms > kMostStallMs) {
    note(
        fmt::format("for {:.0f} ms nothing came from the board: a flight with {:.0f} ms has no "
                    "verdict",
                    load->longest_gap_ms, kMostStallMs));
  }
  if (load->own_lateness_ms > period_ms(demand.sensor_hz)) {
    note(fmt::format("this machine was late itself, by {:.1f} ms: close what else runs on it",
                     load->own_lateness_ms));
  }
}

/// The direction that leaves less room.
casd::LineBudget fuller_of(const LineFigures& figures, const LineDemand& demand, double to_bytes_s,
                           double from_bytes_s) {
  casd::LineBudget to = budget_to(demand, to_bytes_s);
  casd::LineBudget from = budget_from(demand, figures.background_bytes_s, from_bytes_s);
  return used(to) >= used(from) ? to : from;
}

}  // namespace

TimingVerdict judge_line(const LineFigures& figures, const LineDemand& demand) {
  TimingVerdict verdict;
  const casd::LineBudget fuller =
      fuller_of(figures, demand, figures.to_bytes_s, figures.from_bytes_s);
  verdict.spare = 1 - used(fuller);
  add_notes(figures, demand, verdict);

  const auto failed = std::ranges::find_if(figures.loads, [&demand](const LoadFigures& load) {
    return !load.kept() && load.sensor_hz <= demand.sensor_hz;
  });
  if (fuller.fits() && failed == figures.loads.end()) {
    verdict.sentence =
        fmt::format("{} fits with {:.0f} % to spare", demand_words(demand), 100 * verdict.spare);
    return verdict;
  }
  const bool late_itself =
      failed != figures.loads.end() && failed->own_lateness_ms > period_ms(failed->sensor_hz);
  if (fuller.fits() && late_itself) {
    verdict.code = kExitInvalid;
    verdict.sentence = "no verdict: this machine was too busy to send the load in time";
    return verdict;
  }
  verdict.code = kExitLimitsMissed;
  const std::string why = fuller.fits() ? failure_under(*failed) : too_much(fuller);
  verdict.sentence = fmt::format("{} does not fit: {}", demand_words(demand), why) +
                     remedy(figures, fuller, verdict);
  return verdict;
}

std::string uart_note(const LineFigures& figures, const LineDemand& demand, unsigned baud) {
  constexpr double kBitsPerByte = 10;  // 8 data bits, start and stop bit
  const double bytes_s = baud / kBitsPerByte;
  const casd::LineBudget fuller = fuller_of(figures, demand, bytes_s, bytes_s);
  const std::string room =
      fuller.fits() ? fmt::format("would have {:.0f} % to spare", 100 * (1 - used(fuller)))
                    : "would not carry that: " + too_much(fuller);
  return fmt::format(
      "a pseudo-terminal has no baud rate: its throughput is that of the program behind it; a UART "
      "of {} baud carries {:.1f} kB/s, and {}",
      baud, bytes_s / 1e3, room);
}

}  // namespace cas::hils
