// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as an SDF world, through libsdformat: what is read can be given to the engine.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <variant>

#include "base/error.hpp"
#include "libsim/core/load/world_loader.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using cas::sim::Box;
using cas::sim::Cylinder;
using cas::sim::Shape;
using cas::sim::Sphere;

bool has_extent(const Shape& shape) {
  if (const auto* box = std::get_if<Box>(&shape.geometry)) return box->size_m.minCoeff() > 0;
  if (const auto* ball = std::get_if<Sphere>(&shape.geometry)) return ball->radius_m > 0;
  if (const auto* tube = std::get_if<Cylinder>(&shape.geometry)) {
    return tube->radius_m > 0 && tube->length_m > 0;
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const cas::test::TemporaryFolder folder;
  const auto file = folder.write("w.sdf", {reinterpret_cast<const char*>(data), size});
  try {
    const auto world = cas::sim::load_sdf_world(file, {}, cas::sim::Missing::kIgnore);
    if (!world.gravity_W.allFinite() || !world.wind_W.allFinite()) std::abort();
    for (const Shape& shape : world.statics) {
      if (!has_extent(shape) || !shape.pose.matrix().allFinite()) std::abort();
      if (!(shape.surface.friction >= 0)) std::abort();
    }
  } catch (const cas::base::ConfigError& error) {
    if (std::string_view(error.what()).find("w.sdf") == std::string_view::npos) std::abort();
  }
  return 0;
}
