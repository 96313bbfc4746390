// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

#include "base/time/clock.hpp"
#include "libsim/api/world.hpp"

namespace cas::sim {

inline constexpr std::string_view kTruthHeader =
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,roll_rad,pitch_rad,yaw_rad,p_rad_s,q_rad_s,r_rad_s,"
    "omega1_rad_s,omega2_rad_s,omega3_rad_s,omega4_rad_s";
inline constexpr std::size_t kTruthColumns = 17;

/// One line of truth.csv: x north, y east, z up; roll, pitch, yaw of D in N; p, q, r in D.
std::array<double, kTruthColumns> truth_row(base::SimTime time, const BodyState& state,
                                            const Eigen::Vector4d& omega_rad_s);

}  // namespace cas::sim
