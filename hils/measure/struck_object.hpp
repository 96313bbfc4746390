// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hils/measure/incident.hpp"
#include "hils/measure/tracking.hpp"
#include "libsim/core/body/world_model.hpp"

namespace cas::hils {

/// How find_incidents() calls what a vehicle hit: the truth does not say what it was.
inline constexpr std::string_view kSomething = "something";

/// The world file that a run was flown in, of its simulator's configuration; nothing where there is
/// none, or where it cannot be read any more.
std::optional<sim::WorldModel> flown_world(const std::filesystem::path& simulator_config);

/// Name of the nearest model of a world whose surface is at most `reach_m` from a place in W; of
/// "house/wall" the model's, "house". Empty: none. Planes are left out.
std::string nearest_object(const sim::WorldModel& world, double time_s,
                           const Eigen::Vector3d& place_W, double reach_m);

/// Gives the objects that a vehicle hit their names in the world, where its simulator's
/// configuration names a world file that can still be read.
void name_struck_objects(const std::filesystem::path& simulator_config,
                         std::span<const PoseSample> truth, std::vector<Incident>& incidents);

}  // namespace cas::hils
