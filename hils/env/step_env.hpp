// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hils/sweep/study.hpp"

namespace cas::hils {

/// Meaning of an action: the stage of the controller of [HILS] Fig. 8 that the user replaces.
enum class ActionLevel {
  kMotors,    ///< below all loops: outputs of motors (0..1) and servos (-1..1)
  kRates,     ///< above the rate loop: body rates in D, rad/s, and thrust, a share of full
  kAttitude,  ///< above the attitude loop: roll, pitch, yaw, rad, and thrust, a share of full
  kVelocity   ///< above the velocity loop: north, east, down, m/s, and yaw rate, rad/s
};

/// Contents of an observation.
enum class View {
  kTruth,   ///< motion and rotor speeds as they are
  kSensors  ///< the newest sample of each sensor, with its noise and delay
};

/// @throws base::ConfigError for another word than motors, rates, attitude, velocity
ActionLevel parse_action_level(std::string_view word);
/// @throws base::ConfigError for another word than truth, sensors
View parse_view(std::string_view word);

struct StepEnvOptions {
  /// YAML: `vehicle`, and where wanted `sensors`, `home`, `pose`, `world`, `step_us`, `plugins`,
  /// `faults` (of plugin fault) and `params` (of the controller) as in a scenario.
  std::string setup;
  /// YAML list as `vary` of a study (docs/use/sweep.md); its keys lead into `setup`. Empty:
  /// nothing.
  std::string vary;
  ActionLevel action_level = ActionLevel::kMotors;
  View view = View::kTruth;
  int period_us = 2000;  ///< simulated time of a step: a control period
};

/// One vehicle in the simulator, moved by one control period a call.
///
/// The loops below the user are fcu's own, once a period. They read attitude and velocity as they
/// are: no estimator is in between. The rates they read are the gyro's with View::kSensors, else
/// the true ones. Nothing is armed or taken off; the vehicle starts at rest at its pose, its rotors
/// stopped. One episode at a time in a process, like SimRunner. Plugins write their files into the
/// working directory.
class StepEnv {
 public:
  /// @throws base::ConfigError; also while another one of this process is in an episode
  explicit StepEnv(StepEnvOptions options);
  ~StepEnv();
  StepEnv(const StepEnv&) = delete;
  StepEnv& operator=(const StepEnv&) = delete;

  /// Begins an episode. The seed draws the varied values and all noise: the same seed and actions
  /// give the same bytes.
  /// @throws base::ConfigError; also while another one of this process is in an episode
  void reset(std::uint64_t seed);
  /// Ends the episode, so that another one of this process may begin one.
  void close();
  /// Flies on for one period. @param action  action_names().size() numbers
  /// @throws base::ConfigError for another size, or when there is no episode
  /// @throws sim::LeftWorldError when the vehicle has fallen out of the world
  void step(std::span<const double> action);
  /// Writes the observation, observation_names().size() numbers. NaN: no sample has come yet.
  void observe(std::span<double> observation) const;

  /// Each number of an action and of an observation, with its unit.
  const std::vector<std::string>& action_names() const { return action_names_; }
  const std::vector<std::string>& observation_names() const { return observation_names_; }
  /// Least and greatest value of each number of an action; infinite where there is none.
  const std::vector<std::pair<double, double>>& action_limits() const { return action_limits_; }

  double time_s() const;
  bool in_contact() const;  ///< with the ground, or with anything
  /// Values drawn by this episode's seed, by the names of the parameters.
  const std::vector<std::pair<std::string, std::string>>& drawn() const { return drawn_; }

 private:
  class Episode;

  void name_numbers();
  void name_actions();
  std::unique_ptr<Episode> begin(std::uint64_t seed);

  StepEnvOptions options_;
  Study study_;  ///< parameters that an episode draws
  std::vector<std::string> action_names_;
  std::vector<std::pair<double, double>> action_limits_;
  std::vector<std::string> observation_names_;
  std::vector<std::pair<std::string, std::string>> drawn_;
  std::unique_ptr<Episode> episode_;
};

}  // namespace cas::hils
