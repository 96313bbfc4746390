// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/config/config.hpp"
#include "base/config/vehicle.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/fault/expression.hpp"

namespace cas::sim {

enum class SensorTopic : std::uint8_t {
  kImu,
  kGps,
  kMagnetometer,
  kBarometer,
  kRangefinder,
  kAirspeed,
  kOpticalFlow,
  kOdometry,
  kLandingTarget,
};

/// The part of a sample that a fault changes.
enum class SampleField : std::uint8_t {
  kSpecificForce,
  kAngularRate,
  kPosition,  ///< north, east, down; of odometry in the axes of its frame
  kVelocity,  ///< of odometry in the axes of D
  kAttitude,  ///< roll, pitch, yaw
  kField,
  kPressure,
  kTemperature,
  kDistance,
  kDifferentialPressure,
  kFlow,
  kAngles,  ///< to the right, to the back
};

enum class SensorEffect : std::uint8_t {
  kFreeze,
  kDrop,
  kDelay,
  kBias,
  kScale,
  kNoise,
  kClip,       ///< no component is larger than `value`
  kTurn,       ///< all vectors of the sample are turned
  kFix,        ///< the receiver's report of its fix
  kJam,        ///< noise covers the receiver's satellites
  kSpoof,      ///< the position goes away at the speed `value`, and the velocity says so
  kMultipath,  ///< error of the deviation `value`, correlated in time
  kBlind,      ///< the camera sees nothing
  kRelocate,   ///< the frame moves and turns at once, and the reset counter says so
};

/// Factor of a bias.
enum class BiasDriver : std::uint8_t {
  kOne,
  kTime,             ///< seconds since the fault began: a drift
  kPower,            ///< power of the rotors / their power in a hover
  kDynamicPressure,  ///< of the air that meets the vehicle, Pa
  kVibration,        ///< sum over the rotors of (speed / hover)^2 and the sine of their turn
};

/// A receiver's report of its fix.
struct FixReport {
  std::uint8_t type = 3;
  std::uint8_t satellites = 10;
  double eph_m = 1;
  double epv_m = 1;
};

struct SensorFault {
  SensorTopic topic{};
  int number = 1;  ///< of several sensors of that kind
  SensorEffect effect{};
  SampleField field{};
  Eigen::Vector3d value = Eigen::Vector3d::Zero();  ///< SI; factor for kScale, deviation for kNoise
  base::Duration delay{};
  BiasDriver driver = BiasDriver::kOne;  ///< of kBias
  std::optional<SampleField> only;       ///< of kFreeze: the rest goes on
  double drop_share = 1;                 ///< of kDrop: probability for each sample
  int all_but = 0;                       ///< of kDrop: each n-th passes; 0: none
  /// For kTurn: rotation from true to read vectors; for kRelocate: of the frame about the sensor's
  /// place.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  FixReport fix{};             ///< of kFix
  double time_constant_s = 0;  ///< of kMultipath
  double loss_db = 0;          ///< of kJam: fall of C/N0
  double rise_s = 0;           ///< of kJam: until it is so large
};

struct RotorFault {
  int rotor = 0;  ///< 0..15
  double speed_share = 1;
  double thrust_share = 1;  ///< below 0: it turns the other way
  bool stuck = false;       ///< it keeps the speed it has
  bool desync = false;      ///< its motor has no current
};

/// The wires of two rotors are exchanged.
struct SwapFault {
  int first = 0;  ///< 0..15
  int second = 0;
};

struct VoltageFault {
  double share = 1;
};

/// What is wrong with the servo of a control surface.
enum class SurfaceDefect : std::uint8_t {
  kStuck,     ///< it stays where it is
  kHeld,      ///< it turns to an angle and stays there
  kReversed,  ///< it turns to the other side
  kDead,      ///< without power it lets go: the surface turns to neutral
  kSlow,      ///< it reaches only a share of its fastest rate
};

struct SurfaceFault {
  std::string name;  ///< empty: by number
  int number = -1;   ///< index in the vehicle file, 0..15
  SurfaceDefect defect{};
  double angle_rad = 0;   ///< of kHeld
  double rate_share = 1;  ///< of kSlow

  /// Index of the surface; nullopt: the vehicle has none such.
  std::optional<std::size_t> index_in(const base::Vehicle& vehicle) const;
};

struct MassFault {
  double factor = 1;
};

struct CgFault {
  Eigen::Vector3d shift_B_m = Eigen::Vector3d::Zero();
};

/// The line of plugin external_ahrs is cut.
struct LineCutFault {};

using FaultKind = std::variant<SensorFault, RotorFault, SwapFault, VoltageFault, SurfaceFault,
                               MassFault, CgFault, GustCommand, LineCutFault>;

/// Name of the plugin of a sensor, which is that of the topic of its first: "imu".
std::string_view sensor_word(SensorTopic topic);

/// Name of the plugin without which a fault does nothing: the sensor's ("imu", "imu_2"), wind for a
/// gust, motor for rotors, aero for surfaces, external_ahrs for its line; empty: none.
std::string needed_plugin(const FaultKind& kind);

/// Whether it takes thrust or speed of rotors.
bool breaks_propulsion(const FaultKind& kind);

/// Why a vehicle cannot have this fault, as a sentence: the rotor or the surface that it names is
/// not there. Empty: it can.
std::string missing_part(const FaultKind& kind, const base::Vehicle& vehicle);

/// One fault: its begin, duration and effect.
struct FaultSpec {
  std::string name;
  std::optional<base::SimTime> at;
  std::optional<Expression> when;
  std::optional<base::Duration> lasting;  ///< neither lasting nor until: to the end of the run
  std::optional<Expression> until;
  FaultKind kind;
};

/// Reads one fault. @param number  names it where it has no name, from 1
FaultSpec parse_fault(const base::ConfigNode& node, std::size_t number);
/// Reads the list `faults` of plugin `fault`: keys are described in docs/use/plugins.md.
std::vector<FaultSpec> parse_faults(const base::ConfigNode& node);

/// The beginning or the end of a fault, as it is logged.
struct FaultEvent {
  base::SimTime time;
  std::size_t fault = 0;  ///< index in the list
  bool begins = false;
};

/// Decides which faults begin and end. Each happens once in a run.
class FaultSchedule {
 public:
  FaultSchedule() = default;
  explicit FaultSchedule(std::vector<FaultSpec> faults);

  /// Calls on_event(FaultEvent) for each fault that begins or ends at `now`.
  template <class OnEvent>
  void update(base::SimTime now, const Facts& facts, OnEvent&& on_event) {
    for (std::size_t i = 0; i < faults_.size(); ++i) {
      if (states_[i] == State::kWaiting && begins(faults_[i], now, facts)) {
        states_[i] = State::kActive;
        since_[i] = now;
        on_event(FaultEvent{now, i, true});
      } else if (states_[i] == State::kEnding ||
                 (states_[i] == State::kActive && ends(i, now, facts))) {
        states_[i] = State::kOver;
        on_event(FaultEvent{now, i, false});
      }
    }
  }
  /// Every fault waits again; those that were added are gone.
  void reset();
  /// Room for so many faults that add() takes: no fault's place in memory changes.
  void reserve(std::size_t further);
  /// One more. @throws base::ConfigError when the room is used up
  void add(FaultSpec fault);
  /// Ends those of that name that were added, with the next update().
  void end(const std::string& name);

  const std::vector<FaultSpec>& faults() const { return faults_; }
  bool is_active(std::size_t fault) const { return states_[fault] == State::kActive; }

 private:
  enum class State : std::uint8_t { kWaiting, kActive, kEnding, kOver };

  static bool begins(const FaultSpec& fault, base::SimTime now, const Facts& facts);
  bool ends(std::size_t fault, base::SimTime now, const Facts& facts) const;

  std::vector<FaultSpec> faults_;
  std::size_t scripted_ = 0;  ///< those in front, of the configuration
  std::vector<State> states_;
  std::vector<base::SimTime> since_;
};

}  // namespace cas::sim
