// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/os/pty_lock.hpp"
#include "base/os/write_file.hpp"
#include "casd/transport/serial_device.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_flags.hpp"
#include "hils/boards/flight_boards.hpp"
#include "hils/run/verbs.hpp"
#include "hils/timing/line_probe.hpp"
#include "hils/timing/timing_report.hpp"

namespace cas::hils {

namespace {

struct Flags {
  std::string fcu;
  std::optional<unsigned> baud;
  BoardFlags boards;
  std::string json;
  LineDemand demand;
  double seconds = 1.5;
};

constexpr double kMostSeconds = 600;
constexpr double kMostHz = 2000;

base::Descriptor open_line(const FcuDevice& device) {
  casd::SerialRefusal refusal;
  base::Descriptor line = casd::open_serial(
      device.path, {.baud = device.baud, .flow_control = false, .unlocked_pty = true}, refusal);
  if (line) return line;
  throw BoardError(refusal.in_use ? kExitBoardBusy : kExitBoardAbsent, refusal.sentence);
}

constexpr std::size_t kReadBytes = 4096;

bool is_passing(int error) { return error == EAGAIN || error == EINTR; }

bool write_unsent(int line, LineProbe& probe) {
  const std::span<const std::uint8_t> bytes = probe.unsent();
  if (bytes.empty()) return true;
  const ssize_t count = ::write(line, bytes.data(), bytes.size());
  if (count < 0) return is_passing(errno);
  probe.sent(static_cast<std::size_t>(count));
  return true;
}

/// @return false: hung up
bool read_line(int line, LineProbe& probe) {
  std::array<std::uint8_t, kReadBytes> buffer;
  const ssize_t count = ::read(line, buffer.data(), buffer.size());
  if (count < 0) return is_passing(errno);
  if (count == 0) return false;
  probe.take(std::span(buffer).first(static_cast<std::size_t>(count)), base::steady_now());
  return true;
}

/// @return whether there is something to read
bool wait(int line, const LineProbe& probe) {
  pollfd entry{line, static_cast<short>(POLLIN | (probe.unsent().empty() ? 0 : POLLOUT)), 0};
  const auto left = std::max(probe.wake() - base::steady_now(), base::Duration{}).count();
  const timespec timeout{static_cast<time_t>(left / 1'000'000'000), left % 1'000'000'000};
  return ::ppoll(&entry, 1, &timeout, nullptr) > 0 &&
         (entry.revents & (POLLIN | POLLHUP | POLLERR)) != 0;
}

/// Measures an open serial line. @return false: it was closed during the measurement
bool run_probe(const base::Descriptor& line, LineProbe& probe) {
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // ns: no wake-up is up to 50 us late
  while (!probe.done()) {
    probe.turn(base::steady_now());
    if (!write_unsent(line.get(), probe)) return false;
    if (probe.done()) break;
    if (wait(line.get(), probe) && !read_line(line.get(), probe)) return false;
  }
  return true;
}

/// @param is_pty  set: whether the device is a pseudo-terminal
LineFigures measure(const FcuDevice& device, const ProbePlan& plan, bool& is_pty) {
  const base::Descriptor line = open_line(device);
  is_pty = base::identify_pty(line.get()).has_value();
  LineProbe probe(plan, base::steady_now());
  if (!run_probe(line, probe)) {
    throw BoardError(kExitBoardAbsent, device.path + " went away during the measurement");
  }
  switch (probe.figures().end) {
    case ProbeEnd::kSilent:
      throw BoardError(kExitInvalid, fmt::format("no HEARTBEAT came from {} at {} baud: compare "
                                                 "the baud rates (docs/use/pixhawk.md)",
                                                 device.path, device.baud));
    case ProbeEnd::kArmed:
      throw BoardError(kExitBoardFailed,
                       device.path + ": a vehicle there is armed, and its line is not loaded");
    case ProbeEnd::kNoAnswers:
      throw BoardError(kExitInvalid, device.path + " answers neither PING nor TIMESYNC");
    case ProbeEnd::kWhole:
      break;
  }
  return probe.figures();
}

/// Measures and reports. @return exit code
int run(const Flags& flags) {
  const std::vector<FcuChoice> only{FcuChoice{.vehicle = 0, .controller = flags.fcu}};
  const FlightBoards boards(only, flags.boards.file(), "hils timing", flags.boards.patience());
  const FcuDevice device = boards.device(0, flags.baud);
  const ProbePlan plan{.demand = flags.demand,
                       .length = base::from_seconds(flags.seconds),
                       .seed = std::random_device{}()};
  TimingReport report{.device = device.path, .baud = device.baud, .demand = flags.demand};
  report.figures = measure(device, plan, report.is_pty);
  report.verdict = judge_line(report.figures, flags.demand);
  if (report.is_pty) {
    report.verdict.notes.push_back(uart_note(report.figures, flags.demand, device.baud));
  }
  if (!flags.json.empty()) {
    base::write_file(flags.json, timing_json(report), base::Durability::kCache);
  }
  fmt::print("{}", write_text(timing_report(report)));
  return report.verdict.code;
}

}  // namespace

base::cli::Verb add_timing(CLI::App& app) {
  const auto kept = std::make_shared<Flags>();
  Flags& flags = *kept;
  CLI::App* command = app.add_subcommand(
      "timing",
      "Measure the line to a controller that does not fly: what it carries, and how fast");
  command
      ->add_option("--fcu", flags.fcu,
                   "The controller: a board of boards.yaml, or the path of a serial port")
      ->required();
  command->add_option("--baud", flags.baud, "Baud rate of that port (the board's, or 921600)");
  add_board_flags(*command, flags.boards);
  command->add_option("--sensor-hz", flags.demand.sensor_hz, "HIL_SENSOR a second, wanted (500)")
      ->check(CLI::Range(10.0, kMostHz));
  command->add_option("--gps-hz", flags.demand.gps_hz, "HIL_GPS a second (5)")
      ->check(CLI::Range(0.0, kMostHz));
  command->add_option("--controls-hz", flags.demand.controls_hz, "Answers a second (400)")
      ->check(CLI::Range(10.0, kMostHz));
  command->add_flag("--stock", flags.demand.by_rotor,
                    "Answers are HIL_ACTUATOR_CONTROLS, as those of PX4, instead of HIL_CONTROLS");
  command
      ->add_option("--seconds", flags.seconds,
                   "Length of each of the 6 to 17 parts of the measurement (1.5)")
      ->check(CLI::Range(0.5, kMostSeconds));
  command->add_option("--json", flags.json, "File for the figures as JSON");
  return {command, [kept] { return run(*kept); }};
}

}  // namespace cas::hils
