// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a mesh: STL, OBJ or COLLADA by the first byte. Each triangle that is read names
// vertices that there are, and every warning and refusal names the file.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "libsim/core/load/mesh_file.hpp"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string file = data[0] == 's' ? "m.stl" : data[0] == 'o' ? "m.obj" : "m.dae";
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  std::vector<std::string> warnings;
  try {
    const auto mesh = cas::sim::parse_mesh(
        bytes, file, {.up_axis = cas::sim::UpAxis::kApplied, .warnings = &warnings});
    require(!mesh.triangles.empty());
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle) require(vertex < mesh.vertices.size());
    }
  } catch (const cas::base::ConfigError& error) {
    require(std::string_view(error.what()).starts_with(file + ":"));
  }
  require(std::ranges::all_of(warnings, [&](const std::string& w) { return w.starts_with(file); }));
  return 0;
}
