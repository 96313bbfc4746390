// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/vehicle_description.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <cmath>

#include "base/earth/gravity.hpp"
#include "libsim/hilsim/wing_description.hpp"

namespace cas::sim {
namespace {

constexpr double kThousand_rad2_s2 = 1e6;  // effectiveness is shown at 1000 rad/s

/// 0 for a value within the rounding error of numbers near `scale`.
double tidy(double value, double scale) {
  constexpr double kRounding = 1e-8;
  return std::abs(value) < kRounding * scale ? 0.0 : value;
}

void print_body(std::string& text, const VehicleModel& model) {
  const Eigen::Vector3d cog = model.cog_in_root_m.unaryExpr([](double v) { return tidy(v, 1); });
  const Eigen::Matrix3d& full = model.mass.inertia_B();
  const double most = full.cwiseAbs().maxCoeff();
  const Eigen::Matrix3d inertia = full.unaryExpr([most](double v) { return tidy(v, most); });
  add_line(text, "mass               {:.6g} kg", model.mass.mass_kg());
  add_line(text, "centre of gravity  [{:.4f}, {:.4f}, {:.4f}] m from the model's origin", cog.x(),
           cog.y(), cog.z());
  add_line(text, "inertia            Ixx {:.6g}  Iyy {:.6g}  Izz {:.6g} kg m^2", inertia(0, 0),
           inertia(1, 1), inertia(2, 2));
  add_line(text,
           "                   Ixy {:.3g}  Ixz {:.3g}  Iyz {:.3g}, about the centre of gravity",
           inertia(0, 1), inertia(0, 2), inertia(1, 2));
}

double most_thrust_n(const base::RotorParams& params) {
  return params.thrust_coefficient * params.omega_max_rad_s * params.omega_max_rad_s;
}

void print_rotors(std::string& text, const base::Vehicle& vehicle) {
  add_line(text,
           "rotors             hub from the centre of gravity (forward, left, up), axis, spin seen "
           "against the axis");
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    const base::Rotor& rotor = vehicle.rotors[i];
    const Eigen::Vector3d& p = rotor.position_B_m;
    const Eigen::Vector3d& axis = rotor.axis_B;
    add_line(text,
             "  {:2}  [{:7.4f}, {:7.4f}, {:7.4f}] m  [{:.3f}, {:.3f}, {:.3f}]  {}  output {}  "
             "{:.2f} N at {:.0f} rad/s",
             i + 1, p.x(), p.y(), p.z(), axis.x(), axis.y(), axis.z(),
             rotor.spin > 0 ? "CCW" : "CW ", rotor.output + 1, most_thrust_n(rotor.params),
             rotor.params.omega_max_rad_s);
    if (rotor.wake) {
      add_line(text, "      in the wake of rotor {}: {:.0f} % of its thrust is left",
               rotor.wake->upper + 1, 100 * rotor.wake->thrust_share);
    }
    if (rotor.tilt) {
      constexpr double kDegrees = 180 / 3.14159265358979323846;
      const base::TiltServo& servo = *rotor.tilt;
      add_line(text,
               "      tilts from {:.0f} to {:.0f} deg about [{:.3f}, {:.3f}, {:.3f}] on output {}",
               servo.min_rad * kDegrees, servo.max_rad * kDegrees, servo.axis_B.x(),
               servo.axis_B.y(), servo.axis_B.z(), servo.output + 1);
      if (servo.middle_rad != 0) {
        add_line(text, "      stands at {:.0f} deg at output 0", servo.middle_rad * kDegrees);
      }
    }
  }
}

/// Motors with circuits on their battery in still air.
struct Drain {
  double voltage_v = 0;
  double current_a = 0;
  double thrust_n = 0;  ///< upwards
};

/// @param output   of all rotors, by a full battery
/// @param sagging  whether the battery's resistance takes its part of the voltage
Drain drain_at(const base::Vehicle& vehicle, double output, bool sagging) {
  const base::BatteryParams& battery = *vehicle.battery;
  const base::Effectiveness wrench_B = vehicle.effectiveness();
  const auto at = [&](double voltage_v) {
    Drain drain{.voltage_v = voltage_v};
    for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
      const base::Rotor& rotor = vehicle.rotors[i];
      const double k_m = rotor.params.torque_coefficient;
      base::ElectricMotor motor = *rotor.electric;
      const double duty = motor.steady_duty(rotor.speed_at(output), k_m);
      motor.supply_v = voltage_v;
      const double omega = motor.steady_speed_rad_s(duty, k_m);
      drain.current_a += duty * motor.current_a(duty * voltage_v, omega);
      drain.thrust_n += wrench_B(2, static_cast<Eigen::Index>(i)) * omega * omega;
    }
    return drain;
  };
  if (!sagging) return at(battery.full_v);
  double low = 0;
  double high = battery.full_v;
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const double rest_v = battery.full_v - battery.resistance_ohm * at(middle).current_a - middle;
    (rest_v > 0 ? low : high) = middle;
  }
  return at(high);
}

void print_battery(std::string& text, const base::Vehicle& vehicle, double weight_n) {
  const Drain full = drain_at(vehicle, 1, true);
  add_line(text, "battery            {:.1f} A at full output, at {:.2f} V: thrust to weight {:.2f}",
           full.current_a, full.voltage_v, full.thrust_n / weight_n);
  if (const auto hover = vehicle.hover_output(base::kStandardGravity_m_s2)) {
    add_line(text, "                   {:.1f} A in hover",
             drain_at(vehicle, *hover, false).current_a);
  }
}

void print_lift(std::string& text, const base::Vehicle& vehicle) {
  const double weight_n = vehicle.mass_kg * base::kStandardGravity_m_s2;
  const base::ControlScales most = vehicle.control_scales();
  if (const auto hover = vehicle.hover_output(base::kStandardGravity_m_s2)) {
    add_line(text, "hover              output {:.3f} of each rotor, {:.0f} rad/s at rotor 1",
             *hover, vehicle.rotors.front().speed_at(*hover));
  } else {
    add_line(text,
             "hover              no: at no output the same for all do the rotors carry {:.2f} N",
             weight_n);
  }
  add_line(text, "thrust to weight   {:.2f} ({:.2f} N to {:.2f} N)", most.u1_max_n / weight_n,
           most.u1_max_n, weight_n);
  if (vehicle.rotors.front().electric) print_battery(text, vehicle, weight_n);
  const base::ControlScales& scales = vehicle.scales;
  add_line(text,
           "scales             {{u1_max_n: {:.6g}, u2_max_nm: {:.6g}, u3_max_nm: {:.6g}, "
           "u4_max_nm: {:.6g}}}",
           scales.u1_max_n, scales.u2_max_nm, scales.u3_max_nm, scales.u4_max_nm);
}

/// Rank of the effectiveness of rotors (and servos, at hover). Each row is scaled to 1; those that
/// are rounding errors beside the other forces or moments count as 0, however small the vehicle is.
/// @param forces  rows of them; those below are moments
Eigen::Index rank_of(Eigen::MatrixXd columns, Eigen::Index forces) {
  constexpr double kRounding = 1e-9;
  const double most_force = columns.topRows(forces).cwiseAbs().maxCoeff();
  const double most_moment = columns.bottomRows(columns.rows() - forces).cwiseAbs().maxCoeff();
  for (Eigen::Index row = 0; row < columns.rows(); ++row) {
    const double most = columns.row(row).cwiseAbs().maxCoeff();
    const bool counts = most > kRounding * (row < forces ? most_force : most_moment);
    columns.row(row) *= counts ? 1 / most : 0.0;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  qr.setThreshold(1e-6);
  return qr.rank();
}

/// The effectiveness matrix with a column for each servo: its effect per radian of tilt.
Eigen::MatrixXd with_servos(const base::Vehicle& vehicle) {
  constexpr double kSmall_rad = 1e-3;
  const base::Effectiveness still = vehicle.effectiveness();
  Eigen::MatrixXd columns = still;
  for (std::size_t i = 0; i < vehicle.rotors.size(); ++i) {
    if (!vehicle.rotors[i].tilt) continue;
    std::vector<double> tilt(vehicle.rotors.size(), 0.0);
    tilt[i] = kSmall_rad;
    const auto at = static_cast<Eigen::Index>(i);
    const Eigen::VectorXd slope =
        (vehicle.effectiveness(tilt).col(at) - still.col(at)) / kSmall_rad;
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    columns.rightCols(1) = slope;
  }
  return columns;
}

void print_effectiveness(std::string& text, const base::Vehicle& vehicle) {
  const base::Effectiveness columns = vehicle.effectiveness();
  const char* const names[] = {"Fx N", "Fy N", "Fz N", "Mx Nm", "My Nm", "Mz Nm"};
  add_line(text, "effectiveness      of each rotor at 1000 rad/s, forward, left, up");
  constexpr double kSmall = 0.1;  // a nano vehicle's: its numbers need a power of ten
  const double most = kThousand_rad2_s2 * columns.cwiseAbs().maxCoeff();
  for (Eigen::Index row = 0; row < columns.rows(); ++row) {
    std::string line;
    for (Eigen::Index i = 0; i < columns.cols(); ++i) {
      const double own = tidy(columns(row, i) * kThousand_rad2_s2, most);
      line += most < kSmall ? fmt::format(" {:9.2e}", own) : fmt::format(" {:9.4f}", own);
    }
    add_line(text, "  {:6}{}", names[row], line);
  }
  const Eigen::MatrixXd all = with_servos(vehicle);
  add_line(text, "rank               {} of 6", rank_of(columns, 3));
  if (all.cols() > columns.cols()) {
    add_line(text, "                   {} with the servos", rank_of(all, 3));
  }
  Eigen::MatrixXd four(4, all.cols());
  four << all.row(2), all.row(3), all.row(4), all.row(5);
  add_line(text, "{}",
           rank_of(four, 1) == 4
               ? "                   thrust, roll, pitch and yaw can be set independently"
               : "                   thrust, roll, pitch and yaw can NOT be set independently");
}

void print_frame(std::string& text, const base::Vehicle& vehicle,
                 const std::vector<base::Frame>& frames) {
  for (const base::Frame& frame : frames) {
    if (!frame.fits(vehicle)) continue;
    add_line(text, "order and spins    {}", frame.name);
    if (frame.px4_airframe) {
      add_line(text, "                   PX4: SYS_AUTOSTART {}", *frame.px4_airframe);
    }
    if (frame.ardupilot) {
      add_line(text, "                   ArduPilot: FRAME_CLASS {}, FRAME_TYPE {}",
               frame.ardupilot->frame_class, frame.ardupilot->frame_type);
    }
    return;
  }
  add_line(text, "order and spins    of no frame that PX4 and ArduPilot have (config/frames.yaml)");
}

}  // namespace

bool hovers(const base::Vehicle& vehicle) {
  return !vehicle.aero || vehicle.hover_output(base::kStandardGravity_m_s2).has_value();
}

std::string describe_vehicle(const base::Vehicle& vehicle, const VehicleModel& model,
                             const std::vector<base::Frame>& frames) {
  std::string text;
  add_line(text, "vehicle            {}, model {}", vehicle.name, vehicle.urdf.filename().c_str());
  print_body(text, model);
  print_rotors(text, vehicle);
  if (hovers(vehicle)) {
    print_lift(text, vehicle);
    print_effectiveness(text, vehicle);
    print_frame(text, vehicle, frames);
  }
  if (vehicle.aero) text += describe_wings(vehicle, model);
  return text;
}

}  // namespace cas::sim
