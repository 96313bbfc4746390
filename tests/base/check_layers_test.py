#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of scripts/check_layers.py on small source trees."""

import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_layers  # noqa: E402


class CheckLayersTest(unittest.TestCase):
    def complaints(self, name, text):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, name)
            file.parent.mkdir(parents=True)
            file.write_text(text)
            return check_layers.check_tree(pathlib.Path(folder))

    def assert_allowed(self, name, include):
        self.assertEqual(self.complaints(name, f"#include {include}\n"), [])

    def assert_refused(self, name, include):
        found = self.complaints(name, f"// first\n#include {include}\n")
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(f"{name}:2: "), found)

    def test_what_the_table_allows(self):
        for name, include in [
            ("mavlink_gen/runtime/crc.hpp", "<cstdint>"),
            ("mavlink_gen/runtime/crc.cpp", '"mavlink_gen/runtime/crc.hpp"'),
            ("mavlink_gen/parser/xml.cpp", "<expat.h>"),
            ("mavlink_gen/generator/main.cpp", "<CLI/CLI.hpp>"),
            ("base/config/config.cpp", "<yaml-cpp/yaml.h>"),
            ("base/os/log.cpp", "<spdlog/spdlog.h>"),
            ("base/os/notify.cpp", "<sys/socket.h>"),
            ("base/rpc/server.cpp", "<boost/asio/io_context.hpp>"),
            ("base/rpc/server.cpp", '"base/error.hpp"'),
            ("libsim/core/ode/space.cpp", "<ode/ode.h>"),
            ("libsim/hilsim/hilsim_main.cpp", "<CLI/CLI.hpp>"),
            ("plugins/imu/imu_plugin.cpp", '"libsim/api/plugin.hpp"'),
            ("plugins/mavlink_interface/udp.cpp", "<boost/asio/ip/udp.hpp>"),
            ("plugins/mavlink_interface/udp.cpp", '"mavlink/common/all.hpp"'),
            ("casd/topology/topology.cpp", '"mavlink_gen/parser/parser.hpp"'),
            ("casd/casctl/screen.cpp", "<ncursesw/curses.h>"),
            ("fcu/control/pid.cpp", "<Eigen/Core>"),
            ("hils/programs/composition.cpp", '"fcu/flight_controller.hpp"'),
            ("tests/casd/routing/router_test.cpp", '"casd/routing/router.hpp"'),
        ]:
            with self.subTest(name=name, include=include):
                self.assert_allowed(name, include)

    def test_what_the_table_refuses(self):
        for name, include in [
            ("mavlink_gen/runtime/crc.hpp", '"base/error.hpp"'),
            ("mavlink_gen/runtime/crc.hpp", "<sys/socket.h>"),
            ("mavlink_gen/runtime/crc.hpp", "<Eigen/Core>"),
            ("mavlink_gen/parser/xml.cpp", '"mavlink_gen/generator/writer.hpp"'),
            ("base/config/config.cpp", "<nlohmann/json.hpp>"),
            ("base/time/clock.cpp", '"base/rpc/server.hpp"'),
            ("base/time/clock.cpp", "<boost/asio.hpp>"),
            ("libsim/api/world.hpp", "<ode/ode.h>"),
            ("libsim/api/world.hpp", '"libsim/core/run/sim_runner.hpp"'),
            ("libsim/core/run/sim_runner.cpp", "<ode/ode.h>"),
            ("libsim/core/run/sim_runner.cpp", "<CLI/CLI.hpp>"),
            ("plugins/imu/imu_model.cpp", '"libsim/core/world.hpp"'),
            ("plugins/imu/imu_model.cpp", '"mavlink/common/all.hpp"'),
            ("plugins/gps/gps_plugin.cpp", '"plugins/imu/imu_model.hpp"'),
            ("casd/routing/router.cpp", '"fcu/control/pid.hpp"'),
            ("casd/casctl/main.cpp", '"casd/routing/router.hpp"'),
            ("fcu/control/pid.cpp", '"casd/routing/router.hpp"'),
            ("fcu/control/pid.cpp", '"hils/scenario/scenario.hpp"'),
            ("base/time/clock.cpp", '"tests/base/x.hpp"'),
            ("base/time/clock.cpp", '"clock.hpp"'),
            ("base/time/clock.cpp", "<unheard_of/x.hpp>"),
            ("base/config/config.hpp", "<yaml-cpp/yaml.h>"),
            ("casd/routing/router.hpp", "<boost/asio.hpp>"),
        ]:
            with self.subTest(name=name, include=include):
                self.assert_refused(name, include)

    def test_an_include_in_a_comment_counts_for_nothing(self):
        self.assertEqual(self.complaints("base/x.cpp", '// #include "hils/x.hpp"\n'), [])

    def test_a_folder_without_a_row_is_refused(self):
        self.assertTrue(self.complaints("newcomer/x.cpp", "#include <vector>\n"))

    def test_the_project_keeps_to_the_table(self):
        self.assertEqual(check_layers.check_tree(check_layers.PROJECT), [])


if __name__ == "__main__":
    unittest.main()
