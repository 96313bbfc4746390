// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ode/ode.h>

#include <cstddef>
#include <optional>
#include <span>

namespace cas::sim {

/// Contacts of two boxes, a face of one on a face of the other, where ODE has found the crossing of
/// two edges although faces meet: one point would not carry a box that stands half over an edge.
///
/// Writes the corners of the overlap that are in the other box, as ODE writes contacts.
/// @param found  ODE's contacts of the two
/// @param out  has room for eight
/// @return their number; nullopt where ODE's contacts stand
std::optional<std::size_t> collide_faces(std::span<const dContactGeom> found,
                                         std::span<dContactGeom> out);

}  // namespace cas::sim
