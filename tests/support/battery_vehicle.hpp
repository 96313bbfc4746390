// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {

/// iris_paper with a battery, in a file of the folder. @return its path
inline std::string write_with_battery(const TemporaryFolder& folder, const std::string& battery) {
  const std::string vehicles = source_dir() + "/config/vehicles/";
  std::string text = TemporaryFolder::read(vehicles + "iris_paper.yaml");
  const std::string urdf = "urdf: iris_paper.urdf";
  text.replace(text.find(urdf), urdf.size(), "urdf: " + vehicles + "iris_paper.urdf");
  return folder.write("iris_battery.yaml", text + "\nbattery: " + battery + "\n").string();
}

}  // namespace cas::test
