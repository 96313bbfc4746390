// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/file_kind.hpp"

#include <array>
#include <string>
#include <string_view>

namespace cas::base {
namespace {

struct KindWords {
  FileKind kind;
  const char* key;         ///< that the other kinds do not have, but a scenario may name a world
  std::string_view is;     ///< what such a file is, and who takes it
  std::string_view needs;  ///< what a program that wants one looks for
};

constexpr std::array kKinds{
    KindWords{FileKind::kScenario, "steps", "a scenario, which hils run takes",
              "a scenario has 'steps', such as scenarios/hover.yaml"},
    KindWords{FileKind::kTopology, "links", "a topology, which casd takes",
              "a topology has 'links', such as topologies/px4_sitl.yaml"},
    KindWords{FileKind::kVehicle, "rotors",
              "a vehicle, which a scenario or a world names under 'vehicle'",
              "a vehicle has 'rotors', such as vehicles/quad_x.yaml"},
    KindWords{
        FileKind::kStudy, "scenario", "a study, which hils sweep, tune, compare or campaign takes",
        "a study names its 'scenario', such as studies/gain_grid.yaml, as does a campaign, such "
        "as campaigns/iris_paper.yaml"},
    KindWords{FileKind::kWorld, "world", "a world, which hilsim takes",
              "a world has 'world' and 'vehicles', such as worlds/bench.yaml"}};

const KindWords& words_of(FileKind kind) {
  for (const KindWords& each : kKinds) {
    if (each.kind == kind) return each;
  }
  return kKinds.front();
}

bool is_of(const ConfigNode& root, const KindWords& kind) {
  return root.has(kind.key) && (kind.kind != FileKind::kWorld || !root.has("steps"));
}

}  // namespace

void expect_file(const ConfigNode& root, FileKind wanted) {
  const KindWords& own = words_of(wanted);
  if (is_of(root, own)) return;
  for (const KindWords& other : kKinds) {
    if (!is_of(root, other)) continue;
    root.at(other.key).fail("this file is " + std::string(other.is) + "; " +
                            std::string(own.needs));
  }
}

}  // namespace cas::base
