// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/plausibility.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <tuple>

#include "base/earth/gravity.hpp"

namespace cas::sim {
namespace {

// Multirotors from 30 g to 25 kg weigh 3 to 40 kg for each cube of their largest extent; the
// radius of gyration about their vertical axis is 0.15 to 0.4 of it.
constexpr double kDensity_kg_m3 = 10;
constexpr double kGyration = 0.2;
constexpr double kTooLarge = 6;    // times the extent that the mass would have: 0.05 kg/m^3
constexpr double kTooSmall = 0.2;  // 1250 kg/m^3
constexpr double kTooFar = 2;      // times the farthest place, of the radius of gyration
constexpr double kTooNear = 0.03;  // of the largest extent
constexpr double kShapesBesideRotors = 50;
constexpr double kLeastThrust = 1.05;  // over the weight
constexpr double kMostThrust = 20;
constexpr double kLeastShare = 0.05;  // of the thrust of the rotor that gives most of it in hover
constexpr double kRounding = 1e-6;
constexpr double kSeaLevelAir_kg_m3 = 1.225;  // standard atmosphere
constexpr double kSound_m_s = 340.3;          // at sea level, standard atmosphere
constexpr double kMostMach = 0.95;
constexpr double kLongestLag_s = 0.6;
constexpr double kTouchingDiscs_m = 0.005;
constexpr double kOnePlane = 0.02;           // of the radii of two discs, along their axis
constexpr double kCoaxial = 0.1;             // of the radii of two discs, across their axis
constexpr double kParallel = 0.98;           // cosine of the angle between two axes
constexpr double kMostTorque = 2;            // over thrust, times the radius of the disc
constexpr double kLeastTorque = 0.5;         // of that of a rotor without any loss
constexpr double kRotorInertia = 0.002;      // of the body's
constexpr double kMostRotorInertia = 0.2;    // of the body's
constexpr double kThinnestAir_kg_m3 = 0.01;  // half of that of Mars
constexpr double kThickestAir_kg_m3 = 10;
constexpr double kMostGravity_m_s2 = 25;  // Jupiter's
constexpr double kOneG = 0.02;            // from 1 m/s^2, which no planet or moon has
constexpr double kRadPerS = 9.549;        // revolutions a minute of one
constexpr double kRevPerS = 6.283;        // rad/s of one

struct Unit {
  const char* name;
  double factor;  // to SI
};
constexpr Unit kLengths[]{{"mm", 1e-3}, {"cm or inches", 0.016}};
constexpr Unit kMasses[]{{"g", 1e-3}};
constexpr Unit kInertias[]{{"g mm^2", 1e-9},  {"g cm^2", 1e-7},     {"kg mm^2", 1e-6},
                           {"kg cm^2", 1e-4}, {"lb in^2", 2.93e-4}, {"g m^2", 1e-3}};

std::string text(double value) { return fmt::format("{:.3g}", value); }

/// ": it may be in mm instead of m", by the unit in which a value is nearest to what is expected;
/// nothing where none comes near.
std::string likely(double value, double expected, std::span<const Unit> units,
                   const std::string& what, const std::string& instead) {
  constexpr double kNear = 10;
  const auto distance = [&](const Unit& unit) {
    return std::abs(std::log(value * unit.factor / expected));
  };
  const auto best = std::ranges::min_element(units, {}, distance);
  if (distance(*best) > std::log(kNear)) return "";
  return ": " + what + " may be in " + best->name + " instead of " + instead;
}

/// Half the edges of a shape's bounding box, in its own axes.
Eigen::Vector3d half_edges(const Geometry& geometry) {
  if (const auto* box = std::get_if<Box>(&geometry)) return 0.5 * box->size_m;
  if (const auto* ball = std::get_if<Sphere>(&geometry)) {
    return Eigen::Vector3d::Constant(ball->radius_m);
  }
  if (const auto* rod = std::get_if<Cylinder>(&geometry)) {
    return {rod->radius_m, rod->radius_m, 0.5 * rod->length_m};
  }
  return Eigen::Vector3d::Zero();
}

class Check {
 public:
  Check(const base::Vehicle& vehicle, const VehicleModel& model)
      : vehicle_(vehicle), mass_kg_(model.mass.mass_kg()) {
    for (const Shape& shape : model.shapes) {
      const Eigen::Vector3d reach = shape.pose.linear().cwiseAbs() * half_edges(shape.geometry);
      shapes_.extend(Eigen::Vector3d(shape.pose.translation() - reach));
      shapes_.extend(Eigen::Vector3d(shape.pose.translation() + reach));
    }
    for (const base::Rotor& rotor : vehicle.rotors) rotors_.extend(rotor.position_B_m);
    inertia_kg_m2_ = model.mass.inertia_B().diagonal().maxCoeff();
  }

  std::vector<std::string> run() {
    check_size();
    if (warnings_.empty()) check_inertia();
    check_thrust();
    if (warnings_.empty()) check_torque();
    if (warnings_.empty()) check_rotor_inertia();
    check_air();
    check_balance();
    check_tips();
    if (warnings_.empty()) check_discs();
    check_lag();
    return std::move(warnings_);
  }

 private:
  void check_size() {
    const double expected = std::cbrt(mass_kg_ / kDensity_kg_m3);
    const double shapes = shapes_.sizes().maxCoeff();
    const double rotors = rotors_.sizes().maxCoeff();
    check_large("its collision shapes are " + text(shapes) + " m across", shapes, expected);
    check_large("its rotors are " + text(rotors) + " m apart", rotors, expected);
    if (!warnings_.empty()) return;
    const double largest = std::max(shapes, rotors);
    if (largest < kTooSmall * expected) {
      const double cube = kDensity_kg_m3 * std::pow(largest, 3);
      say("it weighs " + text(mass_kg_) + " kg and is " + text(largest) + " m across" +
          likely(mass_kg_, cube, kMasses, "its mass", "kg"));
    } else if (shapes * kShapesBesideRotors < rotors) {
      say("its collision shapes are " + text(shapes) + " m across and its rotors " + text(rotors) +
          " m apart: a mesh may be scaled twice");
    }
  }

  void check_large(const std::string& what, double extent, double expected) {
    if (extent < kTooLarge * expected) return;
    say(what + ", of a vehicle of " + text(mass_kg_) + " kg" +
        likely(extent, expected, kLengths, "lengths", "m"));
  }

  void check_inertia() {
    Eigen::AlignedBox3d all = shapes_;
    all.extend(rotors_);
    const double extent = all.sizes().maxCoeff();
    const double farthest = all.min().cwiseAbs().cwiseMax(all.max().cwiseAbs()).norm();
    const double gyration = std::sqrt(inertia_kg_m2_ / mass_kg_);
    const std::string figures = "its largest moment of inertia is " + text(inertia_kg_m2_) +
                                " kg m^2, of a body of " + text(mass_kg_) + " kg and " +
                                text(extent) + " m";
    if (gyration > kTooFar * farthest) {
      say(figures + likely(inertia_kg_m2_, mass_kg_ * std::pow(kGyration * extent, 2), kInertias,
                           "it", "kg m^2"));
    } else if (gyration < kTooNear * extent) {
      say(figures + ": it is too small, as of point masses in the middle");
    }
  }

  void check_thrust() {
    const double weight_n = mass_kg_ * base::kStandardGravity_m_s2;
    const double ratio = vehicle_.control_scales().u1_max_n / weight_n;
    if (vehicle_.aero && ratio < kLeastThrust) return;  // its wings carry it
    const double per_rpm = kRadPerS * kRadPerS;
    if (ratio < kLeastThrust) {
      say("its rotors lift " + text(ratio) + " of its weight" + weak_by_unit(ratio));
    } else if (ratio > kMostThrust) {
      say("its rotors lift " + text(ratio) + " times its weight" +
          (ratio / per_rpm > kLeastThrust
               ? ": omega_max_rad_s may be in rev/min, or thrust_coefficient of a force in g"
               : ""));
    }
  }

  /// The unit by which rotors that carry nothing would carry the vehicle, nearest to what is usual.
  static std::string weak_by_unit(double ratio) {
    constexpr double kUsual = 3;
    constexpr double kMostUsual = 8;
    struct Guess {
      double factor;
      const char* unit;
    };
    constexpr std::array kGuesses{
        Guess{kRadPerS * kRadPerS,
              "thrust_coefficient may be in N over (rev/min)^2 instead of N s^2"},
        Guess{kRevPerS * kRevPerS, "omega_max_rad_s may be in rev/s instead of rad/s"},
        Guess{base::kStandardGravity_m_s2, "thrust_coefficient may be of a force in kg"}};
    const auto nearest = std::ranges::min_element(kGuesses, {}, [ratio](const Guess& guess) {
      return std::abs(std::log(ratio * guess.factor / kUsual));
    });
    const double then = ratio * nearest->factor;
    return then > kLeastThrust && then < kMostUsual ? std::string(": ") + nearest->unit : "";
  }

  /// A rotor without loss turns against k_m / k_f = sqrt(k_f / (2 rho A)): its induced power alone.
  void check_torque() {
    for (const base::Rotor& rotor : vehicle_.rotors) {
      const auto& [k_f, k_m, radius_m] = std::tuple(
          rotor.params.thrust_coefficient, rotor.params.torque_coefficient, rotor.params.radius_m);
      if (rotor.propeller || k_f <= 0 || k_m <= 0 || radius_m <= 0) continue;
      const double torque_m = k_m / k_f;
      const double disc_m2 = std::numbers::pi * radius_m * radius_m;
      const double lossless_m = std::sqrt(k_f / (2 * kSeaLevelAir_kg_m3 * disc_m2));
      const std::string what = "a rotor of " + text(radius_m) + " m turns against " +
                               text(torque_m) + " N m for each N of thrust";
      if (torque_m > kMostTorque * radius_m) {
        return say(what + ": torque_coefficient may be of another unit than N m s^2");
      }
      if (torque_m < kLeastTorque * lossless_m) {
        return say(what + ", and without any loss it would be " + text(lossless_m) +
                   ": torque_coefficient may be of another unit than N m s^2");
      }
    }
  }

  void check_rotor_inertia() {
    double most = 0;
    for (const base::Rotor& rotor : vehicle_.rotors) {
      most = std::max(most, rotor.params.inertia_kg_m2);
    }
    if (most < kMostRotorInertia * inertia_kg_m2_) return;
    say("a rotor's inertia is " + text(most) + " kg m^2, and that of the whole body " +
        text(inertia_kg_m2_) +
        likely(most, kRotorInertia * inertia_kg_m2_, kInertias, "the rotor's", "kg m^2"));
  }

  void check_air() {
    for (const base::Rotor& rotor : vehicle_.rotors) {
      const double density = rotor.params.reference_density_kg_m3;
      if (density == 0 || (density > kThinnestAir_kg_m3 && density < kThickestAir_kg_m3)) continue;
      return say("reference_density_kg_m3 of its rotors is " + text(density) +
                 ", and air has about 1.2: their thrust changes by the ratio");
    }
  }

  /// Four rotors that do not tilt share the weight in one way alone, and none has next to nothing.
  void check_balance() {
    const base::Effectiveness all = vehicle_.effectiveness();
    Eigen::Matrix4d shares_to_wrench;  // thrust and moments of each lifting rotor, by its thrust
    Eigen::Index lifting = 0;
    for (Eigen::Index i = 0; i < all.cols(); ++i) {
      if (vehicle_.rotors[static_cast<std::size_t>(i)].tilt) return;
      if (all(2, i) <= 0) continue;
      if (lifting == 4) return;
      shares_to_wrench.col(lifting++) = all.col(i).tail<4>() / all(2, i);
    }
    if (lifting < 4) return;
    for (Eigen::Index row = 0; row < 4; ++row) {
      const double most = shares_to_wrench.row(row).cwiseAbs().maxCoeff();
      if (most > 0) shares_to_wrench.row(row) /= most;
    }
    const Eigen::Vector4d weight = Eigen::Vector4d::UnitX();
    const Eigen::Vector4d shares = shares_to_wrench.completeOrthogonalDecomposition().solve(weight);
    const bool balances = (shares_to_wrench * shares - weight).norm() < kRounding;
    if (!balances || shares.minCoeff() < kLeastShare * shares.maxCoeff()) {
      say("its rotors cannot carry it and leave no moment: a spin or a place may be wrong");
    }
  }

  void check_tips() {
    double mach = 0;
    double radius = 0;
    for (const base::Rotor& rotor : vehicle_.rotors) {
      mach = std::max(mach, rotor.params.omega_max_rad_s * rotor.params.radius_m / kSound_m_s);
      radius = std::max(radius, rotor.params.radius_m);
    }
    if (mach < kMostMach) return;
    const double arms = std::max(shapes_.sizes().maxCoeff(), rotors_.sizes().maxCoeff());
    const std::string unit =
        radius > arms                 ? likely(radius, kGyration * arms, kLengths, "radius_m", "m")
        : mach / kRadPerS < kMostMach ? ": omega_max_rad_s may be in rev/min instead of rad/s"
                                      : "";
    say("the tips of its rotors reach Mach " + text(mach) + unit);
  }

  /// Propellers in one plane keep clear of one another; coaxial ones and those of two heights may
  /// not.
  void check_discs() {
    for (std::size_t i = 0; i < vehicle_.rotors.size(); ++i) {
      for (std::size_t k = i + 1; k < vehicle_.rotors.size(); ++k) {
        const double overlap_m = overlap(vehicle_.rotors[i], vehicle_.rotors[k]);
        if (overlap_m <= kTouchingDiscs_m) continue;
        say(fmt::format(
            "the propellers of rotors {} and {} overlap by {:.3g} m: radius_m or a place may be "
            "wrong",
            i + 1, k + 1, overlap_m));
        return;
      }
    }
  }

  /// How far the discs of two rotors that push along one axis in one plane reach into one another;
  /// not above 0 where they do not.
  static double overlap(const base::Rotor& one, const base::Rotor& other) {
    const Eigen::Vector3d between = other.position_B_m - one.position_B_m;
    const double radii = one.params.radius_m + other.params.radius_m;
    const double apart = one.axis_B.dot(between);
    const double aside = (between - one.axis_B * apart).norm();
    const bool coaxial = aside < kCoaxial * radii;
    const bool parallel = std::abs(one.axis_B.dot(other.axis_B)) > kParallel;
    if (coaxial || !parallel || std::abs(apart) > kOnePlane * radii) return 0;
    return radii - aside;
  }

  void check_lag() {
    double lag = 0;
    for (const base::Rotor& rotor : vehicle_.rotors) {
      lag = std::max({lag, rotor.params.time_constant_up_s, rotor.params.time_constant_down_s});
    }
    if (lag > kLongestLag_s) {
      say("its rotors follow a command with a time constant of " + text(lag) +
          " s: it may be in ms instead of s");
    }
  }

  void say(const std::string& sentence) {
    warnings_.push_back("vehicle " + vehicle_.name + ": " + sentence);
  }

  const base::Vehicle& vehicle_;
  double mass_kg_;
  double inertia_kg_m2_ = 0;
  Eigen::AlignedBox3d shapes_;
  Eigen::AlignedBox3d rotors_;
  std::vector<std::string> warnings_;
};

}  // namespace

std::vector<std::string> implausible(const base::Vehicle& vehicle, const VehicleModel& model) {
  return Check(vehicle, model).run();
}

std::optional<std::string> implausible_gravity(const Eigen::Vector3d& gravity_W) {
  const double size = gravity_W.norm();
  const bool feet = std::abs(size - base::kStandardGravity_m_s2 / 0.3048) < 0.1;
  if (size > kMostGravity_m_s2) {
    return "gravity is " + text(size) + " m/s^2" +
           (feet ? ": it may be in ft/s^2 instead of m/s^2" : "");
  }
  if (std::abs(size - 1) < kOneG) {
    return "gravity is " + text(size) + " m/s^2: it may be in g instead of m/s^2";
  }
  if (size > 0 && gravity_W.z() > -0.5 * size) return "gravity does not point down";
  return std::nullopt;
}

}  // namespace cas::sim
