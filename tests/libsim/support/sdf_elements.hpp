// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "libsim/core/load/world_loader.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim::test {

/// A world of one file with these elements in it.
inline std::string world_of(const std::string& elements) {
  return "<sdf version='1.6'>\n<world name='w'>\n" + elements + "\n</world></sdf>";
}

/// Loads a world of these elements.
inline WorldModel load_elements(const std::string& elements) {
  const cas::test::TemporaryFolder folder;
  return load_sdf_world(folder.write("w.sdf", world_of(elements)), {});
}

/// A static box with this surface.
inline std::string obstacle(const std::string& surface) {
  return "<model name='m'><static>1</static><link name='l'><collision "
         "name='c'><geometry><box><size>"
         "1 1 1</size></box></geometry>\n<surface>" +
         surface + "</surface></collision></link></model>";
}

}  // namespace cas::sim::test
