// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/free_port.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

inline const std::filesystem::path kConfig =
    std::filesystem::path(cas::test::source_dir()) / "config";

inline std::string content(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

/// A shipped world or topology whose files are named from the root: it is copied elsewhere.
inline std::string with_whole_paths(std::string text) {
  for (const char* name : {"vehicles", "gains.yaml"}) {
    const std::string relative = std::string("../") + name;
    const std::size_t at = text.find(relative);
    if (at != std::string::npos) text.replace(at, relative.size(), (kConfig / name).string());
  }
  return text;
}

/// Free ports for the shipped px4_sitl: another test may fly at the same time.
struct Px4SitlPorts {
  std::string simulator = std::to_string(free_port());  ///< TCP
  std::string casd = std::to_string(free_port());
  std::string firmware = std::to_string(free_port());
  std::string ground_station = "0";  ///< casd's, for others

  /// Of scripted_firmware.
  std::string arguments() const {
    return "'" + simulator + "', '" + firmware + "', '" + casd + "'";
  }
};

/// The same for two of them: `simulator` and `firmware` are lists.
struct TwoPx4SitlPorts {
  std::string simulator[2] = {std::to_string(free_port()), std::to_string(free_port())};
  std::string firmware[2] = {std::to_string(free_port()), std::to_string(free_port())};
  std::string casd = std::to_string(free_port());

  std::string arguments() const {
    return "'" + simulator[0] + "," + simulator[1] + "', '" + firmware[0] + "," + firmware[1] +
           "', '" + casd + "'";
  }
  /// The shipped world with its vehicle twice, as fast as it goes.
  std::string world() const {
    std::string text = with_whole_paths(content(kConfig / "worlds/px4_sitl.yaml"));
    text = replaced(text, "\nspeed: 1\n", "\n");
    const std::size_t at = text.find("  - name: iris0");
    const std::string vehicle = text.substr(at);
    text.resize(at);
    for (int i = 0; i < 2; ++i) {
      std::string own = replaced(vehicle, "iris0", i == 0 ? "left" : "right");
      own = replaced(own, "{yaw_deg: 90}", "{x_m: " + std::to_string(5 * i) + ", yaw_deg: 90}");
      text += replaced(own, "# instance: 1",
                       "local: '127.0.0.1:" + simulator[i] +
                           "'\n        system_id: " + std::to_string(i + 1) + "  #");
    }
    return text;
  }
  /// A link that hears and answers both.
  std::string topology() const {
    std::string text = with_whole_paths(content(kConfig / "topologies/px4_sitl.yaml"));
    text = replaced(text, "type: udp, local: 127.0.0.1:14550, remote: 127.0.0.1:18570",
                    "type: udp_server, local: 127.0.0.1:" + casd);
    text = replaced(text, "block_systems: [1]", "block_systems: [1, 2]");
    return replaced(text, "local: 127.0.0.1:14551", "local: 127.0.0.1:0");
  }
};

inline std::string px4_sitl_world(const Px4SitlPorts& ports) {
  return replaced(content(kConfig / "worlds/px4_sitl.yaml"), "# instance: 1",
                  "local: '127.0.0.1:" + ports.simulator + "' #");
}

inline std::string px4_sitl_topology(const Px4SitlPorts& ports) {
  const std::string loopback = "127.0.0.1:";
  std::string text = content(kConfig / "topologies/px4_sitl.yaml");
  text = replaced(text, "local: 127.0.0.1:14550", "local: " + loopback + ports.casd);
  text = replaced(text, "remote: 127.0.0.1:18570", "remote: " + loopback + ports.firmware);
  return replaced(text, "local: 127.0.0.1:14551", "local: " + loopback + ports.ground_station);
}

}  // namespace cas::test
