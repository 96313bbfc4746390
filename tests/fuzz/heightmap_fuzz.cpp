// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as the image of a heightmap: two triangles for each cell, none higher than the map.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "base/error.hpp"
#include "libsim/core/load/heightmap.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try {
    const auto mesh = cas::sim::parse_heightmap(bytes, "h.png", {9, 9, 2}, {0, 0, 1});
    for (const auto& v : mesh.vertices) {
      if (!v.allFinite() || v.z() < 1 || v.z() > 3 + 1e-9) std::abort();
    }
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle) {
        if (vertex >= mesh.vertices.size()) std::abort();
      }
    }
  } catch (const cas::base::ConfigError& error) {
    if (!std::string_view(error.what()).starts_with("h.png: ")) std::abort();
  }
  return 0;
}
