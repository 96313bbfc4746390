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

struct ShippedFile {
  const char* name;
  FileKind kind;
  const char* word;
};

class FileKinds : public testing::TestWithParam<ShippedFile> {};

TEST_P(FileKinds, AShippedFileIsOfItsKindAlone) {
  const ConfigNode root =
      ConfigNode::load(std::string(test::source_dir()) + "/config/" + GetParam().name);
  for (const FileKind wanted : kAll) {
    const std::string said = test::refusal([&] { expect_file(root, wanted); });
    if (wanted == GetParam().kind) {
      EXPECT_EQ(said, "");
    } else {
      EXPECT_NE(said.find(std::string("this file is a ") + GetParam().word), std::string::npos)
          << said;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shipped, FileKinds,
    testing::Values(ShippedFile{"scenarios/hover.yaml", FileKind::kScenario, "scenario"},
                    ShippedFile{"scenarios/px4_sitl.yaml", FileKind::kScenario, "scenario"},
                    ShippedFile{"topologies/px4_sitl.yaml", FileKind::kTopology, "topology"},
                    ShippedFile{"vehicles/quad_x.yaml", FileKind::kVehicle, "vehicle"},
                    ShippedFile{"worlds/bench.yaml", FileKind::kWorld, "world"},
                    ShippedFile{"worlds/px4_sitl.yaml", FileKind::kWorld, "world"},
                    ShippedFile{"studies/gain_grid.yaml", FileKind::kStudy, "study"},
                    ShippedFile{"campaigns/plane.yaml", FileKind::kStudy, "study"}),
    [](const auto& each) {
      std::string name = each.param.name;
      for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
      return name;
    });

TEST(FileKind, AFileOfNoKindIsLeftToItsReader) {
  const ConfigNode root = ConfigNode::parse("schema: 1", "x.yaml");
  for (const FileKind wanted : kAll) expect_file(root, wanted);
}

}  // namespace
}  // namespace cas::base
