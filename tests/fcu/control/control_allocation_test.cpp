// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/control_allocation.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <functional>
#include <vector>

#include "base/random.hpp"
#include "fcu/control/mixer.hpp"
#include "tests/fcu/support/frames.hpp"

namespace cas::fcu {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector4d;

constexpr double kGravity = 9.80665;
constexpr double kTolerance = 1e-9;  // of numbers of order one to ten

base::Vehicle iris() {
  return base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/iris_paper.yaml");
}

double hover_n(const base::Vehicle& vehicle) { return vehicle.mass_kg * kGravity; }

/// U1..U4 and the forces along Dx and Dy of these speeds and tilts, from the vehicle alone.
Eigen::Matrix<double, 6, 1> wrench(const base::Vehicle& vehicle, const MixerResult& result) {
  std::vector<double> tilt(vehicle.rotors.size(), 0);
  for (Index i = 0; i < result.tilt_rad.size(); ++i) {
    tilt[static_cast<std::size_t>(i)] = result.tilt_rad[i];
  }
  const Eigen::Matrix<double, 6, 1> B = vehicle.effectiveness(tilt) * result.omega_sq;
  Eigen::Matrix<double, 6, 1> out;
  out << B[2], B[3], -B[4], -B[5], B[0], -B[1];
  return out;
}

// Closed forms.

struct Ring {
  const char* name;
  std::function<base::Vehicle()> vehicle;
};

/// Rotors on a circle whose spins alternate: the axes do not mix, and each is shared in proportion
/// to its lever arms.
TEST(RegularRing, SharesEachAxisByItsLeverArms) {
  const Ring rows[] = {{"Hexa", test::hexa_x}, {"Octo", test::octo_x}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const base::Vehicle vehicle = row.vehicle();
    const double n = vehicle.rotor_count();
    const double k_f = vehicle.rotors[0].params.thrust_coefficient;
    const double k_m = vehicle.rotors[0].params.torque_coefficient;
    const double arm_sq = vehicle.rotors[0].position_B_m.head<2>().squaredNorm();
    const Vector4d u(hover_n(vehicle), 0.4, -0.3, 0.05);
    const MixerResult result = ControlAllocation(AllocationSetup::of(vehicle)).allocate({u, {}});
    for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
      const base::Rotor& rotor = vehicle.rotors[i];
      const double expected =
          u[0] / (n * k_f) +
          2 * (u[1] * rotor.position_B_m.y() + u[2] * rotor.position_B_m.x()) / (n * arm_sq * k_f) +
          u[3] * rotor.spin / (n * k_m);
      EXPECT_NEAR(result.omega_sq[static_cast<Index>(i)] / expected, 1, kTolerance) << i;
    }
    EXPECT_TRUE(result.u.isApprox(u, kTolerance));
  }
}

TEST(ControlAllocation, IsTheInverseOfEq3ForFourEqualRotors) {
  const base::Vehicle vehicle = iris();
  const Mixer mixer(vehicle);
  const ControlAllocation allocation(AllocationSetup::of(vehicle));
  EXPECT_EQ(allocation.rank(), 4);
  base::NormalRandom random(3);
  for (int i = 0; i < 2000; ++i) {
    const Vector4d demand(15 + 10 * random(), 2 * random(), 2 * random(), 0.5 * random());
    for (const bool may_lift : {true, false}) {
      const MixerResult by_eq3 = mixer.mix(demand, may_lift);
      const MixerResult by_all = allocation.allocate({demand, {}}, may_lift);
      EXPECT_TRUE(by_all.omega_sq.isApprox(by_eq3.omega_sq, 1e-6))
          << demand.transpose() << (may_lift ? "" : " on the ground");
    }
  }
}

TEST(ControlAllocation, TurnsBothRotorsOfAPairEquallyFastWhereYawMustBalance) {
  const base::Vehicle vehicle = test::y6();
  const double k_f = vehicle.rotors[0].params.thrust_coefficient;
  const ControlAllocation allocation(AllocationSetup::of(vehicle));
  EXPECT_EQ(allocation.rank(), 4);
  const double thrust = hover_n(vehicle);
  const MixerResult result = allocation.allocate({{thrust, 0, 0, 0}, {}});
  const double expected = thrust / (3 * k_f * (1 + 0.8));  // the lower one gives 0.8 of the upper
  for (const double omega_sq : result.omega_sq) EXPECT_NEAR(omega_sq / expected, 1, kTolerance);
}

TEST(ControlAllocation, YawsATricopterByTiltingItsTail) {
  const base::Vehicle vehicle = test::tri();
  const ControlAllocation allocation(AllocationSetup::of(vehicle));
  EXPECT_EQ(allocation.rank(), 4);
  EXPECT_EQ(allocation.side_force_n(hover_n(vehicle)), 0);
  for (const double yaw : {-0.3, 0.0, 0.3}) {
    const Vector4d u(hover_n(vehicle), 0.2, -0.1, yaw);
    const MixerResult result = allocation.allocate({u, {}});
    EXPECT_TRUE(result.u.isApprox(u, kTolerance)) << result.u.transpose();
    EXPECT_TRUE(wrench(vehicle, result).head<4>().isApprox(u, kTolerance));
    // A third of the weight at the tail, tilted aside at the end of its arm, gives the yaw moment
    // that one rotor's drag torque leaves: the other two cancel.
    const double tail_n = u[0] / 3;
    const double missing_nm = yaw - 0.06 * tail_n;
    EXPECT_NEAR(result.tilt_rad[2], -std::atan(missing_nm / (0.3 * tail_n)), 0.08);
  }
}

/// Rodrigues: of thrust along a hinge that leans, the part along the hinge does not turn.
TEST(ControlAllocation, TurnsOnlyWhatStandsAcrossAHingeThatLeans) {
  base::Vehicle vehicle = test::tri();
  constexpr double kLean = 0.4;  // rad: the tail's hinge rises towards the nose
  vehicle.rotors[2].tilt->axis_B = {std::cos(kLean), 0, std::sin(kLean)};
  const ControlAllocation allocation(AllocationSetup::of(vehicle));
  EXPECT_EQ(allocation.rank(), 4);
  for (const double yaw : {-0.3, 0.0, 0.3}) {
    const Vector4d u(hover_n(vehicle), 0.2, -0.1, yaw);
    const MixerResult result = allocation.allocate({u, {}});
    // The returned wrench is the rotors' wrench.
    EXPECT_TRUE(wrench(vehicle, result).head<4>().isApprox(result.u, kTolerance));
    // The inversion takes the part along the hinge to shrink with cos(tilt), too: that error is of
    // the second order in the tilt, and all there is.
    const base::Rotor& tail = vehicle.rotors[2];
    const double tilt = result.tilt_rad[2];
    ASSERT_GT(std::abs(tilt), 0.01);
    const Eigen::Vector3d along_B =
        std::sin(kLean) * result.omega_sq[2] * (1 - std::cos(tilt)) * tail.tilt->axis_B;
    const Eigen::Vector3d force_B = tail.params.thrust_coefficient * along_B;
    const Eigen::Vector3d moment_B =
        tail.position_B_m.cross(force_B) - tail.spin * tail.params.torque_coefficient * along_B;
    const Vector4d error(force_B.z(), moment_B.x(), -moment_B.y(), -moment_B.z());
    EXPECT_LT((result.u - u - error).norm(), kTolerance) << yaw;
  }
}

TEST(ControlAllocation, GivesUpYawWhereTheTailTiltsNoFurther) {
  const base::Vehicle vehicle = test::tri();
  const ControlAllocation allocation(AllocationSetup::of(vehicle));
  const Vector4d u(hover_n(vehicle), 0.2, -0.1, 3);
  const MixerResult result = allocation.allocate({u, {}});
  EXPECT_NEAR(std::abs(result.tilt_rad[2]), 0.6, 0.05);
  EXPECT_LE(std::abs(result.tilt_rad[2]), 0.6 + kTolerance);
  EXPECT_NEAR(result.u[1], u[1], 0.02);
  EXPECT_NEAR(result.u[2], u[2], 0.02);
  EXPECT_TRUE(result.torque[2].up);
}

TEST(ControlAllocation, PushesSidewaysWithTiltedRotorsOnly) {
  const base::Vehicle tilted = test::tilted_hexa(0.35);
  const ControlAllocation six(AllocationSetup::of(tilted));
  EXPECT_EQ(six.rank(), 6);
  const double most = six.side_force_n(hover_n(tilted));
  EXPECT_GT(most, 1.0);
  for (const Vector2d& side : {Vector2d(most, 0), Vector2d(0, -most), Vector2d(-0.5, 0.5)}) {
    const MixerResult result = six.allocate({{hover_n(tilted), 0, 0, 0}, side});
    Eigen::Matrix<double, 6, 1> expected;
    expected << hover_n(tilted), 0, 0, 0, side;
    EXPECT_LT((wrench(tilted, result) - expected).norm(), 1e-6);
    EXPECT_LT((result.side_D_n - side).norm(), 1e-6);
  }
  const base::Vehicle flat = test::hexa_x();
  const ControlAllocation four(AllocationSetup::of(flat));
  EXPECT_EQ(four.rank(), 4);
  EXPECT_EQ(four.side_force_n(hover_n(flat)), 0);
  const Vector4d u(hover_n(flat), 0.1, 0, 0);
  EXPECT_EQ(four.allocate({u, {2, 1}}).omega_sq, four.allocate({u, {}}).omega_sq);
}

TEST(ControlAllocation, SharesByWeight) {
  const base::Vehicle vehicle = test::octo_x();
  AllocationSetup setup = AllocationSetup::of(vehicle);
  setup.weight[2] = 4;
  const ControlAllocation allocation(setup);
  const Vector4d u(hover_n(vehicle), 0, 0, 0);
  const MixerResult result = allocation.allocate({u, {}});
  EXPECT_TRUE(result.u.isApprox(u, kTolerance));
  for (Index i = 0; i < 8; ++i) {
    if (i == 2) continue;
    EXPECT_GT(result.omega_sq[i], result.omega_sq[2]);
  }
}

// Properties of all frames.

class AnyFrame : public testing::TestWithParam<Ring> {
 protected:
  AnyFrame() : vehicle_(GetParam().vehicle()), allocation_(AllocationSetup::of(vehicle_)) {}

  /// Demands within and far beyond the rotors' limits.
  void for_demands(const std::function<void(const ControlDemand&, bool)>& check) {
    base::NormalRandom random(11);
    for (int i = 0; i < 3000; ++i) {
      const double size = i % 2 == 0 ? 0.3 : 3.0;
      ControlDemand demand;
      demand.u << hover_n(vehicle_) * (1 + size * 0.5 * random()), size * random(), size * random(),
          0.4 * size * random();
      demand.side_D_n << size * random(), size * random();
      check(demand, i % 3 != 0);
    }
  }

  base::Vehicle vehicle_;
  ControlAllocation allocation_;
};

TEST_P(AnyFrame, NeverAsksForMoreThanTheRotorsHave) {
  for_demands([this](const ControlDemand& demand, bool may_lift) {
    const MixerResult result = allocation_.allocate(demand, may_lift);
    for (Index i = 0; i < result.omega_sq.size(); ++i) {
      const base::Rotor& rotor = vehicle_.rotors[static_cast<std::size_t>(i)];
      EXPECT_GE(result.omega_sq[i], std::pow(rotor.params.omega_idle_rad_s, 2) - 1e-6);
      EXPECT_LE(result.omega_sq[i], std::pow(rotor.params.omega_max_rad_s, 2) + 1e-6);
      if (!rotor.tilt) continue;
      EXPECT_GE(result.tilt_rad[i], rotor.tilt->min_rad);
      EXPECT_LE(result.tilt_rad[i], rotor.tilt->max_rad);
    }
    // The returned wrench is the rotors' wrench.
    const auto given = wrench(vehicle_, result);
    EXPECT_LT((given.head<4>() - result.u).norm(), 1e-6);
    EXPECT_LT((given.tail<2>() - result.side_D_n).norm(), 1e-6);
  });
}

TEST_P(AnyFrame, NeverTakesThrustRollOrPitchForYawNorAnythingForForcesSideways) {
  // The tail's tilt costs a tricopter a little of everything at its limits.
  const double tolerance = vehicle_.rotors.back().tilt ? 0.5 : 1e-6;
  for_demands([&](const ControlDemand& demand, bool may_lift) {
    ControlDemand less = demand;
    less.side_D_n.setZero();
    const Vector4d with_yaw = allocation_.allocate(less, may_lift).u;
    EXPECT_LT((allocation_.allocate(demand, may_lift).u - with_yaw).norm(), 1e-6);
    less.u[3] = 0;
    const Vector4d without_yaw = allocation_.allocate(less, may_lift).u;
    EXPECT_LT((with_yaw - without_yaw).head<3>().norm(), tolerance);
  });
}

TEST_P(AnyFrame, MovesThrustForRollAndPitchInTheAir) {
  for_demands([this](const ControlDemand& demand, bool) {
    ControlDemand other = demand;
    other.u[0] *= 0.5;
    const double tolerance = vehicle_.rotors.back().tilt ? 0.5 : 1e-6;
    EXPECT_LT((allocation_.allocate(demand).u - allocation_.allocate(other).u).segment<2>(1).norm(),
              tolerance);
  });
}

TEST_P(AnyFrame, ScalesRollAndPitchTogether) {
  if (vehicle_.rotors.back().tilt) return;  // its tail's limits bend the direction a little
  for_demands([this](const ControlDemand& demand, bool may_lift) {
    const Vector2d wanted = demand.u.segment<2>(1);
    const Vector2d given = allocation_.allocate(demand, may_lift).u.segment<2>(1);
    const double share = given.dot(wanted) / wanted.squaredNorm();
    EXPECT_GE(share, -1e-9);
    EXPECT_LE(share, 1 + 1e-9);
    EXPECT_LT((given - share * wanted).norm(), 1e-6);
  });
}

TEST_P(AnyFrame, GivesExactlyWhatLiesWithinTheLimitsWithTheLeastEffort) {
  const Vector4d u(hover_n(vehicle_), 0.1, -0.1, 0.02);
  const MixerResult result = allocation_.allocate({u, {}});
  EXPECT_TRUE(wrench(vehicle_, result).head<4>().isApprox(u, 1e-9));
  EXPECT_FALSE(result.thrust.up || result.thrust.down);
  for (const Saturation& s : result.torque) EXPECT_FALSE(s.up || s.down);
  if (result.tilt_rad.size() > 0) return;
  // No other speeds that give the same are smaller: at right angles to all that gives nothing.
  const Eigen::MatrixXd columns = vehicle_.effectiveness();
  Eigen::MatrixXd rows = columns;
  if (allocation_.rank() == 4) rows = Eigen::MatrixXd(columns.bottomRows(4));
  Eigen::FullPivLU<Eigen::MatrixXd> lu(rows);
  lu.setThreshold(1e-6);
  const Eigen::MatrixXd kernel = lu.kernel();
  const double size = result.omega_sq.norm();
  for (Index i = 0; i < kernel.cols(); ++i) {
    if (kernel.col(i).norm() == 0) continue;  // nothing is free
    EXPECT_LT(std::abs(kernel.col(i).normalized().dot(result.omega_sq)), 1e-6 * size);
  }
}

TEST_P(AnyFrame, OnTheGroundRollAndPitchRaiseNothing) {
  for_demands([this](const ControlDemand& demand, bool) {
    ControlDemand little = demand;
    little.u[0] = 0.1 * hover_n(vehicle_);
    const double lowest = allocation_.allocate({{0, 0, 0, 0}, {}}).u[0];
    EXPECT_LE(allocation_.allocate(little, false).u[0], std::max(little.u[0], lowest) + 0.05);
  });
}

TEST_P(AnyFrame, YawsBothWaysAsLongAsItIsWhole) {
  const auto [less_nm, more_nm] = allocation_.yaw_reach(hover_n(vehicle_));
  EXPECT_GT(less_nm, 0.5 * more_nm);
}

INSTANTIATE_TEST_SUITE_P(
    All, AnyFrame,
    testing::Values(Ring{"Quad", iris}, Ring{"Hexa", test::hexa_x}, Ring{"Octo", test::octo_x},
                    Ring{"Y6", test::y6}, Ring{"X8", test::x8}, Ring{"Tri", test::tri},
                    Ring{"TiltedHexa", [] { return test::tilted_hexa(0.35); }}),
    [](const auto& test) { return test.param.name; });

// A rotor is lost.

class HexaWithoutOne : public testing::TestWithParam<int> {};

TEST_P(HexaWithoutOne, KeepsThrustRollAndPitchWhole) {
  const base::Vehicle vehicle = test::hexa_x();
  const int lost = GetParam();
  const ControlAllocation allocation(AllocationSetup::of(vehicle), 1U << lost);
  EXPECT_TRUE(allocation.carries(hover_n(vehicle)));
  for (const double roll : {-0.5, 0.0, 0.5}) {
    for (const double pitch : {-0.5, 0.0, 0.5}) {
      const Vector4d u(hover_n(vehicle), roll, pitch, 0);
      const MixerResult result = allocation.allocate({u, {}});
      EXPECT_EQ(result.omega_sq[lost], 0);
      EXPECT_TRUE(result.u.head<3>().isApprox(u.head<3>(), kTolerance)) << result.u.transpose();
    }
  }
}

/// Du, Quan and Cai: no yaw both ways in hover, as the opposite rotor cannot push downwards.
TEST_P(HexaWithoutOne, HoversOnFourWithTheOppositeOneIdle) {
  const base::Vehicle vehicle = test::hexa_x();
  const int lost = GetParam();
  const ControlAllocation allocation(AllocationSetup::of(vehicle), 1U << lost);
  const MixerResult result = allocation.allocate({{hover_n(vehicle), 0, 0, 0}, {}});
  const double quarter = hover_n(vehicle) / 4 / vehicle.rotors[0].params.thrust_coefficient;
  const int opposite = (lost + 3) % 6;
  const double idle = std::pow(vehicle.rotors[0].params.omega_idle_rad_s, 2);
  EXPECT_NEAR(result.omega_sq[opposite], idle, 1e-6 * idle);
  for (int i = 0; i < 6; ++i) {
    if (i == lost || i == opposite) continue;
    EXPECT_NEAR(result.omega_sq[i] / quarter, 1, 0.05) << i;
  }
  const auto yaw = [&](double wanted) {
    return allocation.allocate({{hover_n(vehicle), 0, 0, wanted}, {}}).u[3];
  };
  const double spin = vehicle.rotors[static_cast<std::size_t>(lost)].spin;
  EXPECT_NEAR(yaw(-0.2 * spin), -0.2 * spin, kTolerance);  // the opposite one does speed up
  EXPECT_LT(yaw(0.2 * spin) * spin, 0.01);
}

/// Why yaw is lost: level flight needs the opposite rotor at rest, and roll and pitch use up the
/// remaining four rotors.
TEST_P(HexaWithoutOne, LeavesFourRotorsWhoseMatrixHasRankThree) {
  const base::Vehicle vehicle = test::hexa_x();
  const int lost = GetParam();
  const int opposite = (lost + 3) % 6;
  const Eigen::MatrixXd all = vehicle.effectiveness().bottomRows(4);  // thrust and moments
  Eigen::MatrixXd four(4, 4);
  Eigen::MatrixXd five(4, 5);
  for (int i = 0, k = 0, m = 0; i < 6; ++i) {
    if (i != lost) five.col(m++) = all.col(i);
    if (i != lost && i != opposite) four.col(k++) = all.col(i);
  }
  const auto rank = [](Eigen::MatrixXd matrix) {
    matrix.rowwise().normalize();
    Eigen::FullPivLU<Eigen::MatrixXd> lu(matrix);
    lu.setThreshold(1e-6);
    return lu.rank();
  };
  EXPECT_EQ(rank(all), 4);
  EXPECT_EQ(rank(five), 4) << "yaw is there, but for the opposite rotor pushing down";
  EXPECT_EQ(rank(four), 3);
}

TEST_P(HexaWithoutOne, GivesUpTheHeading) {
  Mixer mixer(test::hexa_x());
  EXPECT_TRUE(std::isinf(mixer.heading_torque_nm()));
  EXPECT_TRUE(mixer.set_lost(1U << GetParam()));
  EXPECT_EQ(mixer.heading_torque_nm(), 0);
  EXPECT_TRUE(mixer.set_lost(0));
  EXPECT_TRUE(std::isinf(mixer.heading_torque_nm()));
}

/// The largest yaw moment to either side of a hover on five rotors lies at a corner of the set of
/// their speeds: two rotors at limits, three that follow from thrust, roll and pitch.
ControlAllocation::YawReach corners(const base::Vehicle& vehicle, int lost) {
  const Eigen::MatrixXd all = vehicle.effectiveness().bottomRows(4);
  const double low = std::pow(vehicle.rotors[0].params.omega_idle_rad_s, 2);
  const double high = std::pow(vehicle.rotors[0].params.omega_max_rad_s, 2);
  double least = INFINITY;
  double most = -INFINITY;
  for (int corner = 0; corner < 6 * 6 * 4; ++corner) {
    const int a = corner % 6;
    const int b = corner / 6 % 6;
    if (a >= b || a == lost || b == lost) continue;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(6);
    x[a] = corner / 36 % 2 == 0 ? low : high;
    x[b] = corner / 72 == 0 ? low : high;
    Eigen::Matrix3d three;
    std::vector<int> others;
    for (int i = 0; i < 6; ++i) {
      if (i == a || i == b || i == lost) continue;
      three.col(static_cast<int>(others.size())) = all.col(i).head<3>();
      others.push_back(i);
    }
    const Eigen::Vector3d level(hover_n(vehicle), 0, 0);
    const Eigen::Vector3d rest = three.fullPivLu().solve(level - all.topRows(3) * x);
    if (!(three * rest).isApprox(level - all.topRows(3) * x, 1e-6)) continue;
    if (rest.minCoeff() < low * (1 - 1e-9) || rest.maxCoeff() > high * (1 + 1e-9)) continue;
    for (int k = 0; k < 3; ++k) x[others[static_cast<std::size_t>(k)]] = rest[k];
    least = std::min(least, all.row(3).dot(x));
    most = std::max(most, all.row(3).dot(x));
  }
  return {std::min(-least, most), std::max(-least, most)};
}

TEST_P(HexaWithoutOne, WithTiltedRotorsYawsAsFarAsTheyCan) {
  const base::Vehicle vehicle = test::tilted_hexa(0.35);
  const ControlAllocation allocation(AllocationSetup::of(vehicle), 1U << GetParam());
  const ControlAllocation::YawReach most = corners(vehicle, GetParam());
  const ControlAllocation::YawReach own = allocation.yaw_reach(hover_n(vehicle));
  EXPECT_GT(most.less_nm, 0);
  EXPECT_NEAR(own.less_nm, most.less_nm, 0.05 * most.less_nm);
  EXPECT_GT(own.more_nm, 0.5 * most.more_nm);
}

INSTANTIATE_TEST_SUITE_P(Each, HexaWithoutOne, testing::Range(0, 6));

/// Du, Quan and Cai's PPNNPN stays controllable after the loss of one of its rotors 1 to 4.
TEST(LostRotor, LeavesYawToAHexaWithItsSpinsInPairs) {
  const base::Vehicle vehicle =
      test::frame("ppnnpn", test::ring(0.3, 30, {1, 1, -1, -1, 1, -1}), 1.8, {0.06, 0.06, 0.11});
  for (int lost = 0; lost < 6; ++lost) {
    const ControlAllocation allocation(AllocationSetup::of(vehicle), 1U << lost);
    const auto gives = [&](double wanted) {
      const Vector4d u(hover_n(vehicle), 0, 0, wanted);
      return allocation.allocate({u, {}}).u.isApprox(u, kTolerance);
    };
    EXPECT_EQ(gives(0.02) && gives(-0.02), lost < 4) << lost;
    EXPECT_EQ(allocation.yaw_reach(hover_n(vehicle)).less_nm > 0, lost < 4) << lost;
  }
}

TEST(LostRotor, IsNoMatterForAnOcto) {
  const base::Vehicle vehicle = test::octo_x();
  for (int lost = 0; lost < 8; ++lost) {
    const ControlAllocation allocation(AllocationSetup::of(vehicle), 1U << lost);
    EXPECT_EQ(allocation.rank(), 4);
    const Vector4d u(hover_n(vehicle), 0.3, -0.2, 0.03);
    EXPECT_TRUE(allocation.allocate({u, {}}).u.isApprox(u, kTolerance)) << lost;
  }
}

TEST(LostRotor, CannotBeLeftOutWhereTheOthersDoNotCarryTheVehicle) {
  EXPECT_FALSE(ControlAllocation(AllocationSetup::of(iris()), 1).carries(hover_n(iris())));
  EXPECT_FALSE(ControlAllocation(AllocationSetup::of(test::tri()), 1).carries(10));
  const base::Vehicle hexa = test::hexa_x();
  EXPECT_FALSE(ControlAllocation(AllocationSetup::of(hexa), 0b011).carries(hover_n(hexa)));
  EXPECT_FALSE(ControlAllocation(AllocationSetup::of(hexa), 0b001).carries(60));  // too heavy
  Mixer mixer(hexa);
  EXPECT_TRUE(mixer.set_lost(0b001));
  EXPECT_FALSE(mixer.set_lost(0b011));
  EXPECT_EQ(mixer.lost(), 0b001U);
  EXPECT_TRUE(mixer.set_lost(0));
  EXPECT_GT(mixer.mix({hover_n(hexa), 0, 0, 0}).omega_sq[0], 0);
}

}  // namespace
}  // namespace cas::fcu
