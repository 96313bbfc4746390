// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::base {

/// Standard gravity, by definition (CGPM 1901).
inline constexpr double kStandardGravity_m_s2 = 9.80665;

}  // namespace cas::base
