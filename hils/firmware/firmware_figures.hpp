// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hils/firmware/fence_verdict.hpp"
#include "hils/firmware/setpoint_stream.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_plan.hpp"
#include "hils/measure/incident.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/measure/never_began.hpp"
#include "hils/measure/tracking.hpp"

namespace cas::hils {

/// The parameters of a vehicle before its first step.
struct ParamDigest {
  std::size_t count = 0;
  std::string sha256{};  ///< of "NAME VALUE" lines in the order of the names
};
/// @param list  `parameters` of param.list
ParamDigest digest_of(const nlohmann::json& list);

/// Figures of a flight of stock firmware.
struct FirmwareFigures {
  std::vector<Stage> stages;
  std::optional<Stage> under_way;             ///< the step that was not done when the flight ended
  std::optional<std::string> flight_failure;  ///< a sentence; nullopt when every step was done
  /// It failed because the vehicle was disarmed before it took off, where it stood upright.
  bool disarmed_on_ground = false;
  std::string version;                ///< of the firmware; empty: unknown
  std::optional<ParamDigest> params;  ///< nullopt: they could not be read
  /// Of the measured hold by the true flight; nullopt in a trajectory, too.
  std::optional<double> height_error_m;  ///< of its mean height
  std::optional<double> drift_m;         ///< farthest from where the hold began, horizontal
  /// Of the true position in the measured step: in a hold about its mean, in a trajectory about the
  /// reference.
  std::optional<RmsFigures> rms;
  std::optional<double> peak_error_m;  ///< farthest from there
  std::optional<double> rotor_activity_rad_s2;
  /// Of the estimate against the truth in the measured step, each relative to its value on the
  /// ground before takeoff.
  std::optional<RmsFigures> rms_estimate;
  std::optional<FenceFigures> fence;           ///< of a scenario that has one
  SetpointStream::Figures setpoints;           ///< that hils has sent; none: no trajectory
  std::map<std::string, double> rates_hz;      ///< of the vehicle's messages in the hold, simulated
  std::vector<BenchFaultScript::Span> faults;  ///< as they went
  std::vector<BenchFaultScript::Span> bench_faults;  ///< those of them that the bench played
  /// When its program ended by itself, or the last HEARTBEAT of one that fell silent.
  std::optional<base::SimTime> fell_silent;
  std::optional<Measurement> stream;  ///< of a flight in HITL: measure_hitl_stream()
  std::vector<FaultThatNeverBegan> never_began;
  double wall_s = 0;
  std::string messages = "[]";  ///< message.list of casd at the flight's end: rates, counts, gaps
  std::string hops = "[]";      ///< link.latency of casd: from one link's read to another's write
  double simulated_s = 0;
  double real_time_factor = 0;
  std::uint8_t system = 1;               ///< the vehicle's
  ClockMap log_clock;                    ///< clock of the flight log -> simulated time
  std::vector<Incident> incidents;       ///< by the true flight
  std::optional<std::string> unwatched;  ///< why incidents could not be looked for
  /// Steps reported as done that the true flight does not show: steps_not_flown().
  std::vector<std::string> not_flown;
  std::vector<std::string> remarks;   ///< of the verdict
  std::vector<std::string> warnings;  ///< of the simulator, about world and vehicle
  std::uint64_t dropped = 0;          ///< packets, by casd at all its links until the flight's end
  std::uint64_t lost = 0;  ///< packets, by the gaps in the sequence numbers that casd heard

  /// With the one under way.
  std::vector<Stage> flown_stages() const;
  /// What every flight has in the measured step, for the rows of figure_table().
  Measurement motion() const;
};

/// Reference of FirmwareFigures::rms: "the reference" or "its mean".
std::string_view measured_about(const std::vector<Stage>& stages);
/// Looks into the true flight, truth.csv: incidents, whether its steps were flown, and how still
/// the measured hold was.
void add_truth(const std::filesystem::path& truth, FirmwareFigures& figures);
/// Adds the figures of the estimate in the flight log; nothing where there is none to read.
void add_estimate(const std::filesystem::path& truth, const std::filesystem::path& tlog,
                  FirmwareFigures& figures);
/// How far the estimate was from the truth in the measured hold; nullopt without one of the two.
/// Places and height count from the last second before takeoff, because a stock estimator's origin
/// lies a little off; the heading counts as it is.
std::optional<RmsFigures> estimate_error(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth,
                                         std::span<const PoseSample> estimate);
/// The slowest way through casd for 99 % of its packets (link.latency), us; nullopt: none was
/// timed.
std::optional<double> slowest_hop_us(const nlohmann::json& hops);
/// Adds the losses by casd's counters (link.list).
void add_losses(const nlohmann::json& links, FirmwareFigures& figures);

}  // namespace cas::hils
