// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// libsdformat's headers are not clean under our warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <ignition/math/Pose3.hh>
#include <ignition/math/SphericalCoordinates.hh>
#include <ignition/math/Vector3.hh>
#include <sdf/sdf.hh>
#pragma GCC diagnostic pop
