// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/rotor_loss.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "fcu/control/control_allocation.hpp"
#include "tests/fcu/support/frames.hpp"

namespace cas::fcu {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 0.0025;

/// A vehicle that turns about its centre of gravity. Rotors and servos follow commands with the
/// vehicle file's dynamics, integrated in parts of a step.
class TurningBody {
 public:
  explicit TurningBody(const base::Vehicle& vehicle)
      : vehicle_(vehicle), tilt_(vehicle.rotors.size(), 0.0) {
    omega_.setZero(vehicle.rotor_count());
  }

  void step(const MixerResult& asked) {
    constexpr int kParts = 10;
    for (int i = 0; i < kParts; ++i) part(asked, kStep_s / kParts);
  }
  void lose(int rotor) { lost_ = rotor; }
  const Vector3d& w_D() const { return w_D_; }

 private:
  void part(const MixerResult& asked, double dt) {
    base::RotorVector omega_sq = omega_.cwiseAbs2();
    if (lost_) omega_sq[*lost_] = 0;
    const Eigen::Matrix<double, 6, 1> B = vehicle_.effectiveness(tilt_) * omega_sq;
    const Vector3d momentum = vehicle_.inertia_kg_m2.cwiseProduct(w_D_);
    const Vector3d moment_D = Vector3d(B[3], -B[4], -B[5]) - w_D_.cross(momentum);
    w_D_ += moment_D.cwiseQuotient(vehicle_.inertia_kg_m2) * dt;
    for (std::size_t i = 0; i < tilt_.size(); ++i) {
      const base::Rotor& rotor = vehicle_.rotors[i];
      const auto index = static_cast<Eigen::Index>(i);
      const double target = std::sqrt(asked.omega_sq[index]);
      double& omega = omega_[index];
      omega +=
          (target - omega) * dt /
          (target > omega ? rotor.params.time_constant_up_s : rotor.params.time_constant_down_s);
      if (!rotor.tilt) continue;
      const double rate = (asked.tilt_rad[index] - tilt_[i]) / rotor.tilt->time_constant_s;
      tilt_[i] += std::clamp(rate, -rotor.tilt->rate_rad_s, rotor.tilt->rate_rad_s) * dt;
    }
  }

  base::Vehicle vehicle_;
  base::RotorVector omega_;
  std::vector<double> tilt_;
  std::optional<int> lost_;
  Vector3d w_D_ = Vector3d::Zero();
};

base::Vehicle tricopter() {
  base::Vehicle vehicle = test::tri();
  vehicle.rotors[2].tilt->time_constant_s = 0.05;
  vehicle.rotors[2].tilt->rate_rad_s = 5;
  return vehicle;
}

/// Swings the tail from side to side while it damps the body's rates.
class SwingingTricopter {
 public:
  std::optional<int> step() {
    time_s_ += kStep_s;
    Eigen::Vector4d demand;
    const Vector3d damping = -4 * vehicle_.inertia_kg_m2.cwiseProduct(body_.w_D());
    demand << vehicle_.mass_kg * 9.80665, damping;
    demand[3] += kSwing_nm * std::sin(2 * M_PI * time_s_);
    const MixerResult asked = allocation_.allocate({demand, {}});
    const auto lost = detector_.update(body_.w_D(), asked, 0, kStep_s);
    body_.step(asked);
    return lost;
  }
  double residual_nm() const { return detector_.residual_D().norm(); }
  TurningBody& body() { return body_; }

  static constexpr double kSwing_nm = 0.4;

 private:
  base::Vehicle vehicle_ = tricopter();
  ControlAllocation allocation_{AllocationSetup::of(vehicle_)};
  RotorLossDetector detector_{vehicle_};
  TurningBody body_{vehicle_};
  double time_s_ = 0;
};

TEST(RotorLoss, KnowsWhereATiltingTailPoints) {
  SwingingTricopter tricopter;
  double most_nm = 0;
  for (int i = 0; i < 1200; ++i) {
    EXPECT_FALSE(tricopter.step()) << "all rotors turn";
    if (i > 400) most_nm = std::max(most_nm, tricopter.residual_nm());  // once all have spun up
  }
  // Steps of 2.5 ms against the body's 0.25 ms; a tail thought upright would leave the whole swing.
  EXPECT_LT(most_nm, 0.1 * SwingingTricopter::kSwing_nm);
}

TEST(RotorLoss, FindsTheTiltingTailThatIsLost) {
  for (const int after : {1100, 1200, 1300, 1400}) {  // steps: at four places of its swing
    SwingingTricopter tricopter;
    for (int i = 0; i < after; ++i) ASSERT_FALSE(tricopter.step());
    tricopter.body().lose(2);
    std::optional<int> found;
    for (int i = 0; i < 200 && !found; ++i) found = tricopter.step();
    EXPECT_EQ(found, 2) << "lost after " << after << " steps";
  }
}

}  // namespace
}  // namespace cas::fcu
