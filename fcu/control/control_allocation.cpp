// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/control_allocation.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.hpp"

namespace cas::fcu {

using base::RotorVector;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector4d;

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Rows that are nearer to each other than this count as one, of rows of length 1.
constexpr double kRankThreshold = 1e-3;
/// A vehicle whose rotors are tilted by less pushes sideways only by accident: 0.6 degrees.
constexpr double kLeastSideShare = 0.01;
/// Below this share of the largest one, a column's entry does not move the rotor.
constexpr double kNothing = 1e-9;

struct Inversion {
  MatrixXd inverse;
  int rank = 0;
};

/// x of the least norm |x / scale| with rows x = given values.
Inversion pseudo_inverse(const MatrixXd& rows, const RotorVector& scale) {
  MatrixXd scaled = rows * scale.asDiagonal();
  Eigen::VectorXd length = scaled.rowwise().norm();
  for (double& l : length) l = l > 0 ? l : 1.0;
  scaled = length.cwiseInverse().asDiagonal() * scaled;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(kRankThreshold);
  decomposition.compute(scaled);
  return {scale.asDiagonal() * decomposition.pseudoInverse() * length.cwiseInverse().asDiagonal(),
          static_cast<int>(decomposition.rank())};
}

/// From B (forward, left, up) to thrust and the axes of D (forward, right, down).
base::Effectiveness in_D(const base::Effectiveness& wrench_B) {
  base::Effectiveness rows(6, wrench_B.cols());
  rows << wrench_B.row(2), wrench_B.row(3), -wrench_B.row(4), -wrench_B.row(5), wrench_B.row(0),
      -wrench_B.row(1);
  return rows;
}

}  // namespace

// Setup.

AllocationSetup AllocationSetup::of(const base::Vehicle& whole, RotorSet lost) {
  base::Vehicle vehicle = whole;
  for (base::Rotor& rotor : vehicle.rotors) {
    if (rotor.wake && has(lost, rotor.wake->upper)) rotor.wake.reset();
  }
  AllocationSetup setup;
  const Index rotors = vehicle.rotor_count();
  setup.low.resize(rotors);
  setup.high.resize(rotors);
  setup.weight.setOnes(rotors);
  for (Index i = 0; i < rotors; ++i) {
    const base::Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    setup.low[i] = std::pow(rotor.params.omega_idle_rad_s, 2);
    setup.high[i] = std::pow(rotor.params.omega_max_rad_s, 2);
    if (rotor.tilt) {
      setup.servos.push_back({static_cast<int>(i), rotor.tilt->min_rad, rotor.tilt->max_rad});
    }
  }
  const auto servos = static_cast<Index>(setup.servos.size());
  if (rotors + servos > base::kMaxRotors) {
    throw base::ConfigError("vehicle '" + vehicle.name +
                            "': more rotors and servos than the 16 outputs of an autopilot");
  }
  setup.wrench_B.resize(6, rotors + servos);
  setup.wrench_B.leftCols(rotors) = vehicle.effectiveness();
  // Axes a quarter of a turn to either side: half their difference is the part that sin(tilt)
  // multiplies, half their sum the part along the hinge.
  const std::vector<double> quarter(vehicle.rotors.size(), M_PI / 2);
  const std::vector<double> back(vehicle.rotors.size(), -M_PI / 2);
  const base::Effectiveness turned = vehicle.effectiveness(quarter);
  const base::Effectiveness turned_back = vehicle.effectiveness(back);
  setup.hinge_B.resize(6, servos);
  for (Index k = 0; k < servos; ++k) {
    const Index i = setup.servos[static_cast<std::size_t>(k)].rotor;
    setup.wrench_B.col(rotors + k) = 0.5 * (turned.col(i) - turned_back.col(i));
    setup.hinge_B.col(k) = 0.5 * (turned.col(i) + turned_back.col(i));
  }
  return setup;
}

ControlAllocation::ControlAllocation(const AllocationSetup& setup, RotorSet lost)
    : low_(setup.low), high_(setup.high), servos_(setup.servos) {
  const Index rotors = low_.size();
  const Index columns = setup.wrench_B.cols();
  CAS_CHECK(high_.size() == rotors && setup.weight.size() == rotors);
  CAS_CHECK(columns == rotors + static_cast<Index>(servos_.size()));
  CAS_CHECK(setup.hinge_B.cols() == static_cast<Index>(servos_.size()));
  wrench_D_ = in_D(setup.wrench_B);
  hinge_D_ = in_D(setup.hinge_B);

  RotorVector scale(columns);
  for (Index i = 0; i < rotors; ++i) {
    if (has(lost, static_cast<int>(i))) low_[i] = high_[i] = 0;
    scale[i] = high_[i] / std::sqrt(setup.weight[i]);
  }
  for (std::size_t k = 0; k < servos_.size(); ++k) {
    scale[rotors + static_cast<Index>(k)] = scale[servos_[k].rotor];
  }
  invert(scale);
  if (lost != 0) invert_without_each(scale, lost);
  level_ = thrust_range(RotorVector::Zero(columns));
}

void ControlAllocation::invert(const RotorVector& scale) {
  const Index columns = wrench_D_.cols();
  const Index rotors = low_.size();
  // Servos serve yaw and side force only: constant commands would wear out a tail.
  RotorVector upright = scale;
  upright.tail(columns - rotors).setZero();
  const Inversion lift = pseudo_inverse(wrench_D_.topRows(3), upright);
  has_lift_ = lift.rank == 3;
  lift_ = lift.inverse;
  rank_ = lift.rank;

  std::vector<Index> rows{0, 1, 2};
  MatrixXd taken = wrench_D_.topRows(3);
  // Takes a further axis, where the rotors give it independently of those before it.
  const auto add = [&](Index row) {
    MatrixXd more(taken.rows() + 1, columns);
    more << taken, wrench_D_.row(row);
    const int rank = pseudo_inverse(more, scale).rank;
    if (rank <= rank_) return false;
    rank_ = rank;
    taken = more;
    rows.push_back(row);
    return true;
  };
  turn_.setZero(columns, 1);
  side_.setZero(columns, 2);
  if (!has_lift_) return;
  has_yaw_ = add(3);
  if (has_yaw_) turn_ = pseudo_inverse(taken, scale).inverse.rightCols(1);
  const Eigen::RowVectorXd turned = wrench_D_.row(3) * lift_;
  lift_turns_ = has_yaw_ && servos_.empty() && turned.norm() > kNothing;
  const double thrust = (wrench_D_.row(0) * scale.asDiagonal()).norm();
  for (const int axis : {0, 1}) {
    const double side = (wrench_D_.row(4 + axis) * scale.asDiagonal()).norm();
    has_side_[static_cast<std::size_t>(axis)] = side > kLeastSideShare * thrust && add(4 + axis);
  }
  const MatrixXd all = pseudo_inverse(taken, scale).inverse;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] >= 4) side_.col(rows[i] - 4) = all.col(static_cast<Index>(i));
  }
}

void ControlAllocation::invert_without_each(const RotorVector& scale, RotorSet lost) {
  if (!has_yaw_) return;
  for (Index i = 0; i < low_.size(); ++i) {
    RotorVector others = scale;
    others[i] = 0;
    const Inversion inversion = pseudo_inverse(wrench_D_.topRows(4), others);
    Inverse<1>& turn = turn_without_.emplace_back(Inverse<1>::Zero(wrench_D_.cols(), 1));
    if (inversion.rank == 4 && !has(lost, static_cast<int>(i))) turn = inversion.inverse.col(3);
  }
}

// One step.

MixerResult ControlAllocation::allocate(const ControlDemand& demand, bool may_lift) const {
  // Thrust, roll and pitch, as if yaw did not matter.
  RotorVector x = level_flight(demand.u, may_lift);

  // As much of yaw as fits.
  if (has_yaw_) turn(demand.u[3], x);

  // As much of the force sideways as is left.
  if (has_side_[0] || has_side_[1]) {
    const Vector2d missing = demand.side_D_n - wrench_D_.bottomRows<2>() * x;
    const RotorVector step = side_ * missing;
    x += step * largest_part(x, step);
  }

  MixerResult result;
  hold_limits(x, result);
  result.thrust = saturation_of(demand.u[0], result.u[0], std::abs(level_.to));
  for (int axis = 0; axis < 3; ++axis) {
    result.torque[static_cast<std::size_t>(axis)] =
        saturation_of(demand.u[axis + 1], result.u[axis + 1], 1.0);
  }
  return result;
}

void ControlAllocation::turn(double wanted_nm, RotorVector& x) const {
  const auto missing_nm = [&] { return wanted_nm - wrench_D_.row(3).dot(x); };
  const RotorVector step = turn_.col(0) * missing_nm();
  x += step * largest_part(x, step);
  for (std::size_t i = 0; i < turn_without_.size(); ++i) {
    const auto index = static_cast<Index>(i);
    const double to_limit = (step[index] > 0 ? high_[index] : low_[index]) - x[index];
    if (step[index] == 0 || std::abs(to_limit) > kNothing * high_[index]) continue;
    const RotorVector rest = turn_without_[i].col(0) * missing_nm();
    x += rest * largest_part(x, rest);
  }
}

RotorVector ControlAllocation::level_flight(const Vector4d& u, bool may_lift) const {
  RotorVector tilt = lift_.col(1) * u[1] + lift_.col(2) * u[2];
  Range range = thrust_range(tilt);
  const bool fits = range.from <= u[0] && u[0] <= range.to;
  RotorVector freed;
  if (!fits && may_lift && lift_turns_ && with_any_yaw(tilt, u, freed)) return freed;
  if (!may_lift && range.from > u[0]) {
    // On the ground: only the part that fits around the demanded thrust.
    const RotorVector level = lift_.col(0) * std::max(u[0], level_.from);
    tilt *= largest_part(level, tilt);
    range = thrust_range(tilt);
  } else if (range.from > range.to) {
    tilt *= largest_tilt(tilt);
    range = thrust_range(tilt);
  }
  range.to = std::max(range.from, range.to);
  return tilt + lift_.col(0) * std::clamp(u[0], range.from, range.to);
}

/// Rolls and pitches whole, with the thrust that is nearest to the demand whatever the yaw, and the
/// yaw nearest to the demand beside that. @return false where no thrust does
bool ControlAllocation::with_any_yaw(const RotorVector& tilt, const Vector4d& u,
                                     RotorVector& x) const {
  // Each rotor bounds the yaw from both sides, each bound moves linearly with the thrust: every
  // lower one must stay below every upper one. A rotor that does not yaw bounds the thrust.
  struct Bound {
    double yaw = 0, per_thrust = 0;
  };
  std::array<Bound, base::kMaxRotors> lower, upper;
  std::size_t count = 0;
  Range thrust{0, kInfinite};
  const double nothing = kNothing * turn_.cwiseAbs().maxCoeff();
  for (Index i = 0; i < low_.size(); ++i) {
    if (high_[i] <= 0) continue;  // lost
    const double per_yaw = turn_(i, 0);
    const double per_thrust = lift_(i, 0);
    if (std::abs(per_yaw) <= nothing) {
      const double at_low = (low_[i] - tilt[i]) / per_thrust;
      const double at_high = (high_[i] - tilt[i]) / per_thrust;
      thrust.from = std::max(thrust.from, std::min(at_low, at_high));
      thrust.to = std::min(thrust.to, std::max(at_low, at_high));
      continue;
    }
    const Bound at_low{(low_[i] - tilt[i]) / per_yaw, -per_thrust / per_yaw};
    const Bound at_high{(high_[i] - tilt[i]) / per_yaw, -per_thrust / per_yaw};
    lower[count] = per_yaw > 0 ? at_low : at_high;
    upper[count] = per_yaw > 0 ? at_high : at_low;
    ++count;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      const double room = upper[j].yaw - lower[i].yaw;
      const double closing = lower[i].per_thrust - upper[j].per_thrust;
      if (closing > 0) thrust.to = std::min(thrust.to, room / closing);
      if (closing < 0) thrust.from = std::max(thrust.from, room / closing);
      if (closing == 0 && room < 0) return false;
    }
  }
  if (!(thrust.from <= thrust.to)) return false;
  const double n = std::clamp(u[0], thrust.from, thrust.to);
  Range yaw{-kInfinite, kInfinite};
  for (std::size_t i = 0; i < count; ++i) {
    yaw.from = std::max(yaw.from, lower[i].yaw + lower[i].per_thrust * n);
    yaw.to = std::min(yaw.to, upper[i].yaw + upper[i].per_thrust * n);
  }
  x = tilt + lift_.col(0) * n;
  const double wanted = u[3] - wrench_D_.row(3).dot(x);
  x += turn_.col(0) * std::min(std::max(wanted, yaw.from), std::max(yaw.from, yaw.to));
  return true;
}

/// Thrusts that keep every rotor of `base` plus thrust within its limits.
ControlAllocation::Range ControlAllocation::thrust_range(const RotorVector& base) const {
  Range range{0, kInfinite};
  const double nothing = kNothing * lift_.col(0).cwiseAbs().maxCoeff();
  for (Index i = 0; i < low_.size(); ++i) {
    const double per_n = lift_(i, 0);
    if (std::abs(per_n) <= nothing) continue;
    const double at_low = (low_[i] - base[i]) / per_n;
    const double at_high = (high_[i] - base[i]) / per_n;
    range.from = std::max(range.from, std::min(at_low, at_high));
    range.to = std::min(range.to, std::max(at_low, at_high));
  }
  return range;
}

/// Largest share 0..1 of `tilt` for which there is a thrust that keeps all rotors within limits.
double ControlAllocation::largest_tilt(const RotorVector& tilt) const {
  // Each rotor bounds the thrust from both sides, each bound moves linearly with the share s:
  // every lower one must stay below every upper one.
  double share = 1;
  const double nothing = kNothing * lift_.col(0).cwiseAbs().maxCoeff();
  for (Index i = 0; i < low_.size(); ++i) {
    const double per_n_i = lift_(i, 0);
    if (std::abs(per_n_i) <= nothing) continue;
    const double upper = (per_n_i > 0 ? high_[i] : low_[i]) / per_n_i;
    const double upper_slope = -tilt[i] / per_n_i;
    for (Index j = 0; j < low_.size(); ++j) {
      const double per_n_j = lift_(j, 0);
      if (std::abs(per_n_j) <= nothing) continue;
      const double lower = (per_n_j > 0 ? low_[j] : high_[j]) / per_n_j;
      const double closing = -tilt[j] / per_n_j - upper_slope;
      if (closing > 0) share = std::min(share, (upper - lower) / closing);
    }
  }
  return std::max(share, 0.0);
}

/// Largest part 0..1 of `step` that can be added to `base` within the limits.
double ControlAllocation::largest_part(const RotorVector& base, const RotorVector& step) const {
  double part = 1;
  const auto bound = [&](Index i, double low, double high) {
    if (step[i] > 0) part = std::min(part, (high - base[i]) / step[i]);
    if (step[i] < 0) part = std::min(part, (low - base[i]) / step[i]);
  };
  const Index rotors = low_.size();
  for (Index i = 0; i < rotors; ++i) bound(i, low_[i], high_[i]);
  for (std::size_t k = 0; k < servos_.size(); ++k) {
    const AllocationSetup::Servo& servo = servos_[k];
    const double upright = base[servo.rotor];
    const double most =
        std::sqrt(std::max(std::pow(high_[servo.rotor], 2) - upright * upright, 0.0));
    bound(rotors + static_cast<Index>(k), std::max(std::tan(servo.min_rad) * upright, -most),
          std::min(std::tan(servo.max_rad) * upright, most));
  }
  return std::clamp(part, 0.0, 1.0);
}

/// Speeds and tilts within the limits, and their wrench.
void ControlAllocation::hold_limits(RotorVector& x, MixerResult& result) const {
  const Index rotors = low_.size();
  result.omega_sq = x.head(rotors).cwiseMax(low_).cwiseMin(high_);
  x.head(rotors) = result.omega_sq;
  if (!servos_.empty()) result.tilt_rad.setZero(rotors);
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
  for (std::size_t k = 0; k < servos_.size(); ++k) {
    const AllocationSetup::Servo& servo = servos_[k];
    const Index i = servo.rotor;
    double& part = x[rotors + static_cast<Index>(k)];
    const double tilt = std::clamp(std::atan2(part, x[i]), servo.min_rad, servo.max_rad);
    const double omega_sq = std::clamp(std::hypot(x[i], part), low_[i], high_[i]);
    result.omega_sq[i] = omega_sq;
    result.tilt_rad[i] = tilt;
    x[i] = omega_sq * std::cos(tilt);
    part = omega_sq * std::sin(tilt);
    wrench += hinge_D_.col(static_cast<Index>(k)) * (omega_sq - x[i]);
  }
  wrench += wrench_D_ * x;
  result.u = wrench.head<4>();
  result.side_D_n = wrench.tail<2>();
}

MixerResult ControlAllocation::idle() const {
  MixerResult result;
  RotorVector x = RotorVector::Zero(wrench_D_.cols());
  x.head(low_.size()) = low_;
  hold_limits(x, result);
  return result;
}

// Capability of the rotors.

bool ControlAllocation::carries(double thrust_n) const {
  constexpr double kMargin = 0.02;  // of a rotor's full range, to either limit
  if (!has_lift_) return false;
  for (Index i = 0; i < low_.size(); ++i) {
    if (high_[i] <= 0) continue;  // lost
    const double speed = lift_(i, 0) * thrust_n;
    const double margin = kMargin * high_[i];
    if (speed < low_[i] + margin || speed > high_[i] - margin) return false;
  }
  return true;
}

ControlAllocation::YawReach ControlAllocation::yaw_reach(double thrust_n) const {
  if (!has_yaw_) return {};
  const auto yaw_nm = [&](double wanted_nm) {
    return allocate({{thrust_n, 0, 0, wanted_nm}, Vector2d::Zero()}).u[3];
  };
  const double beyond_nm = wrench_D_.row(3).head(high_.size()).cwiseAbs().dot(high_) + thrust_n;
  const double right_nm = yaw_nm(beyond_nm);
  const double left_nm = -yaw_nm(-beyond_nm);
  return {std::min(right_nm, left_nm), std::max(right_nm, left_nm)};
}

double ControlAllocation::side_force_n(double thrust_n) const {
  constexpr int kDirections = 16;
  if (!has_side_[0] || !has_side_[1]) return 0;
  const RotorVector base = level_flight({thrust_n, 0, 0, 0}, true);
  double force = thrust_n;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * M_PI * k / kDirections;
    const RotorVector step = side_ * Vector2d(std::cos(angle), std::sin(angle)) * thrust_n;
    force = std::min(force, thrust_n * largest_part(base, step));
  }
  return force;
}

}  // namespace cas::fcu
