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
            for parent in file.relative_to(folder).parents:
                (pathlib.Path(folder) / parent / "README.md").write_text("what lives here\n")
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
            ("casd/link/link_loop.cpp", '"casd/routing/router.hpp"'),
            ("casd/app.cpp", '"casd/transport/udp_link.hpp"'),
            ("casd/casctl/monitor/screen.cpp", "<ncursesw/curses.h>"),
            ("fcu/control/mixer.cpp", "<Eigen/Core>"),
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
            ("base/time/clock.cpp", '"base/config/config.hpp"'),
            ("libsim/api/world.hpp", "<ode/ode.h>"),
            ("libsim/api/world.hpp", '"libsim/core/run/sim_runner.hpp"'),
            ("libsim/core/run/sim_runner.cpp", "<ode/ode.h>"),
            ("libsim/core/run/sim_runner.cpp", "<CLI/CLI.hpp>"),
            ("libsim/core/body/shape.cpp", '"libsim/core/run/sim_world.hpp"'),
            ("libsim/core/load/mesh_file.cpp", '"libsim/core/run/sim_world.hpp"'),
            ("plugins/imu/imu_model.cpp", '"libsim/core/run/sim_world.hpp"'),
            ("plugins/imu/imu_model.cpp", '"mavlink/common/all.hpp"'),
            ("plugins/gps/gps_plugin.cpp", '"plugins/imu/imu_model.hpp"'),
            ("casd/routing/router.cpp", '"fcu/control/pid.hpp"'),
            ("casd/routing/router.cpp", '"casd/link/switchboard.hpp"'),
            ("casd/routing/router.cpp", "<boost/asio/post.hpp>"),
            ("casd/topology/topology.cpp", '"casd/app.hpp"'),
            ("casd/topology/topology.cpp", "<Eigen/Core>"),
            ("casd/casctl/main.cpp", '"casd/routing/router.hpp"'),
            ("casd/casctl/session/session.cpp", '"casd/casctl/verbs/verbs.hpp"'),
            ("fcu/control/mixer.cpp", '"casd/routing/router.hpp"'),
            ("fcu/control/mixer.cpp", '"hils/scenario/scenario.hpp"'),
            ("fcu/flight/commander.hpp", '"fcu/flight_controller.hpp"'),
            ("fcu/core/fcu_core.hpp", '"fcu/flight_controller.hpp"'),
            ("hils/measure/statistics.cpp", '"hils/report/report.hpp"'),
            ("hils/programs/composition.cpp", '"hils/report/report.hpp"'),
            ("base/time/clock.cpp", '"tests/base/x.hpp"'),
            ("base/time/clock.cpp", '"clock.hpp"'),
            ("base/time/clock.cpp", "<unheard_of/x.hpp>"),
            ("base/config/config.hpp", "<yaml-cpp/yaml.h>"),
            ("casd/link/link_loop.hpp", "<boost/asio.hpp>"),
        ]:
            with self.subTest(name=name, include=include):
                self.assert_refused(name, include)

    def test_no_row_allows_what_stands_above_it(self):
        def below(folder, seen):
            for other in sorted((check_layers.LAYERS.get(folder) or set()) & set(check_layers.LAYERS)):
                if other not in seen:
                    seen.add(other)
                    below(other, seen)
            return seen

        for folder in check_layers.LAYERS:
            if folder != "tests":
                self.assertNotIn(folder, below(folder, set()))

    def test_an_upward_include_in_the_project_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            tree = pathlib.Path(folder)
            for room in ("casd/packet", "casd/link"):
                (tree / room).mkdir(parents=True)
                (tree / room / "README.md").write_text("what lives here\n")
            (tree / "casd/README.md").write_text("what lives here\n")
            (tree / "casd/packet/link_id.hpp").write_text('#include "casd/link/link.hpp"\n')
            self.assertEqual(check_layers.check_tree(tree), [
                "casd/packet/link_id.hpp:1: casd/packet may not include casd/link ('casd/link/link.hpp')"])

    def test_a_room_without_a_readme_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "casd").mkdir()
            self.assertEqual(len(check_layers.check_tree(pathlib.Path(folder))), 1)

    def test_a_new_room_needs_a_row(self):
        self.assertTrue(self.complaints("casd/newcomer/x.cpp", "#include <vector>\n"))

    def test_an_include_in_a_comment_counts_for_nothing(self):
        self.assertEqual(self.complaints("base/x.cpp", '// #include "hils/x.hpp"\n'), [])

    def test_a_folder_without_a_row_is_refused(self):
        self.assertTrue(self.complaints("newcomer/x.cpp", "#include <vector>\n"))

    def test_the_project_keeps_to_the_table(self):
        self.assertEqual(check_layers.check_tree(check_layers.PROJECT), [])


if __name__ == "__main__":
    unittest.main()
