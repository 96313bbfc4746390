// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a vehicle's model, URDF or SDF: a ConfigError, or a body of finite figures.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "base/config/model_body.hpp"
#include "base/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cas::base;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const ModelBody body =
        parse_model_body(text, "/nowhere/model/fuzz.sdf", {{"gimbal", PartUse::kFixed}});
    if (!(body.mass_kg >= 0) || !std::isfinite(body.mass_kg)) std::abort();
    if (!body.cog_R_m.allFinite() || !body.inertia_B_kg_m2.allFinite()) std::abort();
    if (body.links.size() > kMaxModelLinks) std::abort();
    for (const ModelLink& link : body.links) {
      if (!link.position_R_m.allFinite()) std::abort();
      if (link.axis_R && std::abs(link.axis_R->norm() - 1) > 1e-6) std::abort();
      if (link.name == "gimbal" && link.axis_R) std::abort();
    }
    for (const ModelShape& shape : body.shapes) {
      if (!shape.size.allFinite() || !shape.X_RS.matrix().allFinite()) std::abort();
    }
  } catch (const ConfigError&) {
  }
  return 0;
}
