// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/wind/dryden.hpp"

namespace cas::sim {

/// How the mean wind changes with height.
enum class WindLaw {
  kUniform,  ///< not at all
  kLog,      ///< ln(h / z0) / ln(reference / z0); MIL-F-8785C has 20 ft and z0 = 0.15 ft
  kPower,    ///< (h / reference)^exponent
};

struct WindProfile {
  WindLaw law = WindLaw::kUniform;
  double reference_m = 6.096;    ///< height at which the mean wind holds: 20 ft
  double roughness_m = 0.04572;  ///< z0: 0.15 ft
  double exponent = 0.143;       ///< 1/7, of open land [Peterson-Hennessey]

  /// Wind at a height over its value at the reference.
  double share_at(double height_m) const;
};

struct WindParams {
  Eigen::Vector3d mean_N_m_s = Eigen::Vector3d::Zero();  ///< air velocity at the reference height
  WindProfile profile;
  double turbulence_w20_m_s = 0;  ///< 0: none
  double span_m = 0;              ///< of the vehicle, over which the wind changes; 0: it does not
  struct Gust {
    base::SimTime start;
    GustCommand gust;
  };
  std::vector<Gust> gusts;
};

/// Reads the parameters of plugin `wind`: keys are described in docs/use/plugins.md.
WindParams parse_wind_params(const base::ConfigNode& node);

/// Air velocity by a 1-cosine gust, MIL-F-8785C Sect. 3.7.3.3: rises over a length of air, holds,
/// falls over the same length.
class GustModel {
 public:
  GustModel() = default;  ///< one that is over
  explicit GustModel(const GustCommand& gust) : gust_(gust), over_(false) {}
  /// @param speed_m_s  V, through the mean air
  Eigen::Vector3d advance_N(double speed_m_s, double dt);
  bool over() const { return over_; }

 private:
  GustCommand gust_;
  double distance_m_ = 0;  // into the rise, or into the fall
  double held_s_ = 0;
  bool falling_ = false;
  bool over_ = true;
};

/// Mean wind, gusts and turbulence at one vehicle.
class WindModel {
 public:
  WindModel() = default;
  WindModel(const WindParams& params, std::uint64_t seed);

  /// Begins a gust. @return false for the ninth at a time, which is left out
  bool start(const GustCommand& gust);
  /// Air velocity in N for the step that begins at `now`.
  /// @param v_N  vehicle's velocity over ground, m/s
  /// @param field_N  air velocity besides, at its place: of the world, of a grid
  Eigen::Vector3d advance_N(base::SimTime now, double dt, double height_m,
                            const Eigen::Vector3d& v_N,
                            const Eigen::Vector3d& field_N = Eigen::Vector3d::Zero());
  /// Change of that wind over the vehicle, 1/s: of the profile and of turbulence; 0 without a span.
  /// A gust has none.
  const Eigen::Matrix3d& gradient_N() const { return gradient_N_; }
  double span_m() const { return params_.span_m; }

 private:
  /// @param along_N  wind besides turbulence and gusts, of any length
  Eigen::Vector3d turbulence_N(double height_m, double speed_m_s, double dt,
                               const Eigen::Vector3d& along_N);

  WindParams params_;
  std::size_t next_gust_ = 0;
  std::array<GustModel, 8> gusts_;
  Dryden dryden_;
  DrydenRates rates_;
  Eigen::Matrix3d gradient_N_ = Eigen::Matrix3d::Zero();
};

}  // namespace cas::sim
