// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/file_kind.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <string>

#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"

namespace cas::base {
namespace {

constexpr FileKind kAll[] = {FileKind::kScenario, FileKind::kTopology, FileKind::kVehicle,
                             FileKind::kWorld, FileKind::kStudy};

TEST(FileKinds, AShippedFileIsOfItsKindAlone) {
  struct ShippedFile {
    const char* name;
    FileKind kind;
    const char* word;
  };
  const ShippedFile rows[] = {{"scenarios/hover.yaml", FileKind::kScenario, "scenario"},
                              {"scenarios/px4_sitl.yaml", FileKind::kScenario, "scenario"},
                              {"topologies/px4_sitl.yaml", FileKind::kTopology, "topology"},
                              {"vehicles/quad_x.yaml", FileKind::kVehicle, "vehicle"},
                              {"worlds/bench.yaml", FileKind::kWorld, "world"},
                              {"worlds/px4_sitl.yaml", FileKind::kWorld, "world"},
                              {"studies/gain_grid.yaml", FileKind::kStudy, "study"},
                              {"campaigns/plane.yaml", FileKind::kStudy, "study"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const ConfigNode root =
        ConfigNode::load(std::string(test::source_dir()) + "/config/" + row.name);
    for (const FileKind wanted : kAll) {
      const std::string said = test::refusal([&] { expect_file(root, wanted); });
      if (wanted == row.kind) {
        EXPECT_EQ(said, "");
      } else {
        EXPECT_NE(said.find(std::string("this file is a ") + row.word), std::string::npos) << said;
      }
    }
  }
}

TEST(FileKind, AFileOfNoKindIsLeftToItsReader) {
  const ConfigNode root = ConfigNode::parse("schema: 1", "x.yaml");
  for (const FileKind wanted : kAll) expect_file(root, wanted);
}

}  // namespace
}  // namespace cas::base
