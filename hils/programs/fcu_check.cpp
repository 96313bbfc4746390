// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/fcu_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/config/frame_table.hpp"
#include "base/config/install_paths.hpp"

namespace cas::hils {

namespace {

using Findings = std::vector<FcuFinding>;

constexpr double kLeastControlsHz = 50;     ///< less than this is no control loop
constexpr double kLeastSensorShare = 0.95;  ///< of the nominal rate, over the port
constexpr double kControlsTolerance = 0.1;  ///< of the scenario's rate; casd's is of a few seconds

void good(Findings& all, std::string what) { all.push_back({.what = std::move(what)}); }

void warn(Findings& all, std::string what, std::string remedy) {
  all.push_back({.good = false, .what = std::move(what), .remedy = std::move(remedy)});
}

void fatal(Findings& all, std::string what, std::string remedy) {
  all.push_back(
      {.good = false, .fatal = true, .what = std::move(what), .remedy = std::move(remedy)});
}

void check_mode(const FcuFacts& facts, Findings& all) {
  if (facts.autopilot == "px4" && facts.sys_hitl && *facts.sys_hitl != 1) {
    fatal(all, fmt::format("parameter SYS_HITL is {:g}", *facts.sys_hitl),
          "casctl param set SYS_HITL 1, then reboot the board (step 3)");
  }
  if (facts.autopilot == "ardupilot") {
    fatal(all, "ArduPilot on a board has no HIL any more", "use PX4 or CAS's own controller");
  }
  if (!facts.hil) {
    fatal(all, "its HEARTBEAT does not say that it flies a simulation: the motors may be real",
          "take the propellers off, set SYS_HITL to 1 and reboot the board (step 3)");
  } else {
    good(all, "it says that it flies a simulation");
  }
  if (facts.armed) fatal(all, "it is armed already", "casctl disarm");
}

struct RotorPlace {
  bool forward;
  bool left;
  int spin;
};

// Rotors 1..4 of PX4's airframes "quad x".
constexpr std::array<RotorPlace, 4> kQuadX{{
    {true, false, 1},    // front right, counter-clockwise
    {false, true, 1},    // rear left, counter-clockwise
    {true, true, -1},    // front left, clockwise
    {false, false, -1},  // rear right, clockwise
}};

bool is_quad_x(const base::Vehicle& vehicle) {
  for (std::size_t i = 0; i < kQuadX.size(); ++i) {
    const base::Rotor& rotor = vehicle.rotors[i];
    const bool forward = rotor.position_B_m.x() > 0;
    const bool left = rotor.position_B_m.y() > 0;
    if (forward != kQuadX[i].forward || left != kQuadX[i].left) return false;
    if (rotor.spin != kQuadX[i].spin) return false;
  }
  return true;
}

/// Whether PX4 has an airframe of that order: a quad by its corners, whatever its arms' angles.
bool is_numbered_as_px4(const base::Vehicle& vehicle) {
  if (vehicle.rotors.size() == kQuadX.size()) return is_quad_x(vehicle);
  return std::ranges::any_of(
      base::load_frames(base::shipped_config("frames.yaml")),
      [&vehicle](const base::Frame& frame) { return frame.px4_airframe && frame.fits(vehicle); });
}

void check_rotors(const FcuFacts& facts, const base::Vehicle& vehicle, Findings& all) {
  // Controls for axes are mixed by the simulator, in whatever order the vehicle has.
  if (facts.autopilot != "px4" || !facts.by_rotor) return;
  if (is_numbered_as_px4(vehicle)) {
    good(all, fmt::format("the rotors of {} are numbered and spin as PX4's", vehicle.name));
  } else {
    fatal(all,
          fmt::format("the rotors of {} are not numbered or do not spin as PX4's: it would flip",
                      vehicle.name),
          "fly config/scenarios/pixhawk.yaml, or give the scenario the vehicle iris_px4 (step 4)");
  }
}

/// The report compares received and nominal rates, so they must describe the same message.
void check_controls(const FcuFacts& facts, const Rates& nominal, Findings& all) {
  if (facts.controls_hz < kLeastControlsHz) {
    return fatal(all, fmt::format("it answers with {:.0f} controls a second", facts.controls_hz),
                 "choose a HIL airframe (PX4: SYS_AUTOSTART 1001) and give the port a data rate "
                 "above 5000 B/s (step 4)");
  }
  const double apart = facts.controls_hz - nominal.controls_hz;
  if (std::abs(apart) <= kControlsTolerance * nominal.controls_hz) {
    return good(all, fmt::format("{:.0f} controls a second come back, as the scenario counts on",
                                 facts.controls_hz));
  }
  warn(all,
       fmt::format("it answers with {:.0f} controls a second; the scenario counts on {:g}: the "
                   "report would call {:.0f} a second {}",
                   facts.controls_hz, nominal.controls_hz, std::abs(apart),
                   apart < 0 ? "missing" : "too many"),
       facts.autopilot == "px4"
           ? "set rates.controls_hz of the scenario to what the firmware does: 200 for PX4 (step 5)"
           : fmt::format("set rates.controls_hz of the scenario to what the board does, about "
                         "{:.0f}, or the board's rate to the scenario's (step 5)",
                         facts.controls_hz));
}

void check_rates(const FcuFacts& facts, const Rates& nominal, Findings& all) {
  if (facts.sensor_hz < kLeastSensorShare * nominal.sensor_hz) {
    warn(all,
         fmt::format("only {:.0f} of {:g} HIL_SENSOR a second go over the port", facts.sensor_hz,
                     nominal.sensor_hz),
         "raise the baud rate at both ends, or lower rates.sensor_hz (step 5)");
  } else {
    good(all, fmt::format("{:.0f} HIL_SENSOR a second go to it", facts.sensor_hz));
  }
  check_controls(facts, nominal, all);
  if (facts.crc_errors > 0) {
    warn(all, fmt::format("{:.0f} packets came damaged", facts.crc_errors),
         "compare the baud rates of both ends; look at cable and ground (step 5)");
  }
}

}  // namespace

std::vector<FcuFinding> check_fcu(const FcuFacts& facts, const Rates& nominal,
                                  const base::Vehicle& vehicle) {
  Findings all;
  if (!facts.link_up) {
    fatal(all, facts.device + " cannot be opened: " + facts.link_words,
          "plug the board in, name it by /dev/serial/by-id, and join the group that owns it "
          "(step 1)");
    return all;
  }
  good(all, facts.link_words + " is open");
  if (!facts.heard && facts.system) {
    fatal(all, fmt::format("no HEARTBEAT of system {} came", *facts.system),
          fmt::format("of several vehicles the first has system 1, the next 2, and so on: set the "
                      "board's (PX4: MAV_SYS_ID {}), then reboot it; compare the baud rates "
                      "(step 2)",
                      *facts.system));
    return all;
  }
  if (!facts.heard) {
    fatal(all, "no HEARTBEAT came", "compare the baud rates; close other ground stations (step 2)");
    return all;
  }
  if (!facts.elsewhere.empty()) {
    fatal(all,
          fmt::format("system {} is heard on link {}, which is another vehicle's",
                      facts.system.value_or(0), facts.elsewhere),
          "the boards have each other's system ids: exchange the boards behind --fcu, or set their "
          "ids (PX4: MAV_SYS_ID) and reboot them (step 2)");
    return all;
  }
  good(all, "a vehicle with autopilot " + facts.autopilot + " is there");
  check_mode(facts, all);
  check_rotors(facts, vehicle, all);
  check_rates(facts, nominal, all);
  return all;
}

std::string findings_text(const std::vector<FcuFinding>& findings) {
  std::string text;
  for (const FcuFinding& finding : findings) {
    text += fmt::format("  {} {}\n",
                        finding.good    ? "ok  "
                        : finding.fatal ? "STOP"
                                        : "note",
                        finding.what);
    if (!finding.remedy.empty()) text += "       " + finding.remedy + "\n";
  }
  return text;
}

bool may_fly(const std::vector<FcuFinding>& findings) {
  return std::ranges::none_of(findings, [](const FcuFinding& finding) { return finding.fatal; });
}

}  // namespace cas::hils
