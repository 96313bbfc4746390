// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/report/run_plots.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// What is compared: of one scenario the ways to connect simulator and controller, an architecture
/// and a line where it has one; of several the scenarios, each as it is.
struct Variant {
  Architecture architecture = Architecture::kTcas;
  unsigned baud = 0;            ///< 0: no byte-clocked line
  std::size_t scenario = 0;     ///< its place in the plan
  std::string scenario_name{};  ///< of several; empty: the plan has one
  std::string name() const;     ///< "TCAS 460800", or the scenario's
};

/// Which runs a comparison is made of.
struct ComparisonPlan {
  std::vector<Scenario> scenarios;  ///< one or more
  std::vector<Variant> variants;
  std::vector<std::uint64_t> seeds;
  double warm_up_s = 10;
  double hold_s = 60;
  bool virtual_clock = false;  ///< but for stock firmware, which has a clock of its own

  bool has_several() const { return scenarios.size() > 1; }
};

/// The five architectures: those with a line once for each baud rate, the others once.
std::vector<Variant> make_variants(const std::vector<Architecture>& architectures,
                                   const std::vector<unsigned>& bauds);

/// A variant for each of several scenarios. @throws base::ConfigError for two of one name
std::vector<Variant> make_variants(const std::vector<Scenario>& scenarios);

/// The scenario with the times of the plan and the cross traffic that all variants get alike: a
/// ground station. @throws base::ConfigError when no hold precedes the measured one
Scenario comparison_scenario(const Scenario& scenario, const ComparisonPlan& plan);

/// Wake-up delay of threads on the virtual clock by default: measured with clock_nanosleep on a
/// shared two-core machine.
inline constexpr WakeUpFigures kUsualWakeUp{.p50_us = 100, .p99_us = 1000};

/// Figures and verdicts of a variant, run by run in the order of the seeds.
struct VariantResult {
  Variant variant;
  std::vector<Measurement> runs{};
  std::vector<Verdict> verdicts{};
  RunCurves curves{};  ///< of the first seed
};

/// All runs, interleaved: every variant with the first seed, then with the next. Runs leave their
/// files in OUT/runs; with `keep` also truth.csv and the flight log.
/// @throws RunStopped, base::ConfigError
std::vector<VariantResult> run_comparison(const ComparisonPlan& plan,
                                          const std::filesystem::path& out, bool keep);

/// Exit code of `hils compare`: kExitPassed if each variant has a valid run, else kExitInvalid.
int exit_code(const std::vector<VariantResult>& results);

}  // namespace cas::hils
