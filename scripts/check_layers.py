#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that each folder includes only what the table below allows.

Usage: check_layers.py [SOURCE_TREE]     exit 0: all in order, 1: complaints on standard output
"""

import os
import pathlib
import re
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[1]

# Outside libraries, by the beginning of the include.
EXTERNALS = {
    "expat": ("expat.h", "expat_external.h"),
    "CLI11": ("CLI/",),
    "spdlog": ("spdlog/",),
    "fmt": ("fmt/",),
    "yaml-cpp": ("yaml-cpp/",),
    "Eigen": ("Eigen/", "unsupported/Eigen/"),
    "Asio": ("boost/asio", "boost/beast", "boost/system"),
    "nlohmann": ("nlohmann/",),
    "ODE": ("ode/",),
    "Embree": ("embree3/",),
    "libtiff": ("tiffio.h",),
    "urdfdom": ("urdf_parser/", "urdf_model/", "urdf_world/", "urdf_exception/", "tinyxml"),
    "libpng": ("png.h",),
    "sdformat": ("sdf/", "ignition/", "gz/"),
    "sqlite": ("sqlite3.h",),
    "pagmo": ("pagmo/",),
    "pybind11": ("pybind11/",),
    "zlib": ("zlib.h",),
    "zstd": ("zstd.h",),
    "Boost": ("boost/math/", "boost/random/"),
    "ncurses": ("ncurses", "curses.h"),
    "intrinsics": ("cpuid.h", "immintrin.h", "nmmintrin.h", "wmmintrin.h", "arm_neon.h", "arm_acle.h"),
    "gtest": ("gtest/", "gmock/", "benchmark/"),
}

# "std" is the C++ library, "system" the C headers of the operating system, "dialect" the generated
# headers mavlink/<dialect>/, "intrinsics" those of the compiler for one processor. A folder may always
# include itself, and nothing of its subfolders unless its row names them.


def rooms(program, names):
    return {f"{program}/{name}" for name in names.split()}


SYSTEM = {"std", "system"}
BASE = SYSTEM | {"base", "fmt"} | rooms("base", "config earth measure os time")
RPC = {"base/rpc", "nlohmann"}  # who calls or offers methods handles their JSON
MAVLINK = {"mavlink_gen/runtime", "dialect"}
SERVICES = {"mavlink_gen/services"}
PROGRAM = {"base/cli", "CLI11"}  # readers of a command line
API = BASE | {"libsim/api", "Eigen"}
PLUGIN = API | {"plugins/common", "nlohmann"}
EVERYTHING = None

# Rooms of a program, from the ground floor up: a folder includes the entries of its row, and no row has
# a room above it (tests/base/check_layers_test.py).
LAYERS = {
    # the runtime can be lifted into firmware
    "mavlink_gen/runtime": {"std", "intrinsics"},
    # of base: suggestion.hpp, which is whole in itself
    "mavlink_gen/parser": SYSTEM | {"mavlink_gen/runtime", "base", "expat"},
    # of base: suggestion.hpp, too
    "mavlink_gen/services": {"std", "base"} | MAVLINK,
    "mavlink_gen/json":
        {"std", "base", "nlohmann"} | MAVLINK | SERVICES | {"mavlink_gen/parser"},
    "mavlink_gen/generator": SYSTEM | PROGRAM | {"base", "mavlink_gen/parser", "mavlink_gen/runtime"},

    "base": SYSTEM,
    "base/time": SYSTEM | {"base"},
    "base/earth": SYSTEM | {"base", "Eigen"},
    "base/config": SYSTEM | {"base", "base/time", "base/earth", "fmt", "yaml-cpp", "Eigen", "expat"},
    "base/os": SYSTEM | {"base", "base/config", "spdlog"},
    "base/measure": SYSTEM | rooms("base", "os time") | {"base"},
    "base/cli": {"std", "base", "CLI11"},
    # of the runtime: SHA-256
    "base/rpc": SYSTEM | rooms("base", "os time") | {"base", "mavlink_gen/runtime", "Asio", "nlohmann"},

    "libsim/api": BASE - {"fmt"} | {"Eigen"},
    "libsim/core": SYSTEM,
    "libsim/core/body": API | {"libsim/core"},
    # the one folder that knows libtiff
    "libsim/core/terrain": API | {"libsim/core", "libsim/core/body", "libtiff"},
    # the one folder that knows ODE
    "libsim/core/ode": API | {"libsim/core", "libsim/core/body", "libsim/core/terrain", "ODE"},
    # the one folder that knows Embree
    "libsim/core/rays": API | {"libsim/core", "libsim/core/body", "Embree"},
    "libsim/core/load":
        API | rooms("libsim/core", "body terrain") | {"libsim/core", "sdformat", "libpng"},
    "libsim/core/run": API | {"libsim/core"} | rooms("libsim/core", "body terrain ode rays load"),

    "plugins/common": API | MAVLINK | SERVICES | {"nlohmann"},
    "plugins": PLUGIN,  # each of plugins/<name>
    "plugins/landing_target": PLUGIN | MAVLINK,
    "plugins/lidar": PLUGIN | MAVLINK,
    "plugins/odometry": PLUGIN | MAVLINK,
    "plugins/optical_flow": PLUGIN | MAVLINK,
    "plugins/mavlink_interface": PLUGIN | MAVLINK | SERVICES | {"Asio"},

    "casd/words": {"std"},
    "casd/packet": BASE | MAVLINK | SERVICES | {"casd/words"},
    "casd/routing": BASE | MAVLINK | SERVICES | rooms("casd", "packet words"),
    "casd/queue": BASE | rooms("casd", "packet words"),
    "casd/tlog": BASE | MAVLINK | SERVICES,
    "casd/topology":
        BASE | MAVLINK | rooms("casd", "packet routing queue tlog") | {"base/rpc", "mavlink_gen/parser"},
    "casd/counters": BASE | MAVLINK | rooms("casd", "packet routing queue words"),
    "casd/signing":
        BASE | MAVLINK | RPC | rooms("casd", "packet topology counters"),
    "casd/link":
        BASE | MAVLINK | rooms("casd", "packet routing queue tlog topology counters signing")
        | {"Asio"},
    "casd/station": BASE | MAVLINK | SERVICES | rooms("casd", "packet"),
    "casd/autopilot_log": BASE | MAVLINK | SERVICES | rooms("casd", "packet tlog station"),
    "casd/transport":
        BASE | MAVLINK | rooms("casd", "packet routing tlog counters link station") | {"Asio"},
    "casd/port":
        BASE | MAVLINK | RPC
        | rooms("casd", "words packet routing queue tlog topology counters station autopilot_log")
        | {"mavlink_gen/parser", "mavlink_gen/json", "Asio"},
    "casd":
        BASE | MAVLINK | RPC | PROGRAM | {"Asio"}
        | rooms("casd",
                "packet routing queue tlog topology counters signing link station autopilot_log transport port"),
    "casd/casctl/session": BASE | RPC | PROGRAM | {"casd/words"},
    "casd/casctl/verbs": BASE | RPC | {"base/cli", "casd/words", "casd/casctl/session"},
    "casd/casctl/doctor": BASE | RPC | {"casd/words", "casd/casctl/session"},
    "casd/casctl/monitor": BASE | RPC | {"base/cli", "casd/words", "casd/casctl/session", "ncurses"},
    # of services: the tables of flight modes
    "casd/casctl": BASE | RPC | PROGRAM | SERVICES | rooms("casd/casctl", "session verbs doctor monitor"),

    "fcu/line": BASE,
    "fcu/estimation": BASE | {"Eigen"},
    "fcu/control": BASE | rooms("fcu", "estimation") | {"Eigen"},
    "fcu/params": BASE | rooms("fcu", "estimation control") | {"Eigen"},
    "fcu/flight": BASE | MAVLINK | SERVICES | rooms("fcu", "estimation control params") | {"Eigen"},
    "fcu/core":
        BASE | MAVLINK | rooms("fcu", "line estimation control params flight") | {"Eigen"},
    "fcu/protocols":
        BASE | MAVLINK | SERVICES | rooms("fcu", "core estimation flight params") | {"Eigen"},
    "fcu": BASE | MAVLINK | rooms("fcu", "core flight protocols") | {"Eigen"},
    "fcu/emulator":
        BASE | MAVLINK | SERVICES | RPC | PROGRAM | rooms("fcu", "core line params")
        | {"fcu", "Eigen", "Asio"},

    # of the runtime: SHA-256; of fcu: the design of the rate loops, of the plugins: the models that a trim needs, for
    # --describe
    "libsim/hilsim":
        API | RPC | PROGRAM | rooms("libsim/core", "body load rays run")
        | {"mavlink_gen/runtime", "fcu/control", "plugins/aero", "plugins/motor", "Asio"},

    # of casd and hilsim it knows the sockets alone
    "web/server": BASE | RPC | PROGRAM | {"Asio"},

    "tests": EVERYTHING,
}

# hils stands above all others: its rooms list each other, and may include everything below.
BELOW_HILS = set(LAYERS) - {"tests"} | SYSTEM | MAVLINK | rooms("plugins", "airspeed barometer fault gps imu magnetometer") | set(EXTERNALS) - {"gtest"}
LAYERS |= {name: BELOW_HILS | others for name, others in {
    "hils/flight": set(),
    "hils/scenario": rooms("hils", "flight"),
    "hils/run": rooms("hils", "scenario"),
    "hils/measure": rooms("hils", "flight scenario run"),
    "hils/report": rooms("hils", "measure run"),
    "hils/ulog": rooms("hils", "measure run"),
    "hils/mcap": rooms("hils", "scenario measure run"),
    "hils/replay": rooms("hils", "scenario run measure ulog mcap programs"),
    "hils/programs": rooms("hils", "flight scenario run measure"),
    "hils/boards": rooms("hils", "flight run measure report programs"),
    "hils/timing": rooms("hils", "run measure report boards"),
    "hils/virtual": rooms("hils", "flight scenario run measure programs"),
    "hils/firmware": rooms("hils", "flight scenario run measure programs"),
    "hils/bench": rooms("hils", "run measure programs virtual firmware"),
    "hils/compare": rooms("hils", "scenario run measure report programs bench"),
    "hils/sweep": rooms("hils", "flight scenario run measure report programs boards bench"),
    "hils/env": rooms("hils", "scenario run sweep"),
    "hils/tune": rooms("hils", "flight scenario run measure report programs sweep"),
    "hils/campaign": rooms("hils", "flight scenario run measure report ulog replay programs boards sweep bench"),
    "hils/runs": rooms("hils", "run measure report replay"),
    "hils": rooms("hils", "flight scenario run measure report ulog mcap replay runs programs boards timing bench compare sweep tune campaign"),
}.items()}

# Slow to compile: they stay out of headers, so that not everybody pays. Their light parts may stay.
NOT_IN_HEADERS = ("nlohmann/", "spdlog/", "yaml-cpp/", "boost/asio.hpp")
LIGHT = ("nlohmann/json_fwd.hpp",)
# Headers for files that handle JSON anyway.
JSON_HEADERS = ("base/rpc/call_params.hpp", "casd/casctl/", "casd/port/call_json.hpp")

SUFFIXES = {".hpp", ".cpp", ".h", ".cc"}
# example_plugin and examples stand for a stranger's source tree.
SKIPPED = {"build", "out", "node_modules", "__pycache__", "example_plugin", "examples"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    """The folder of `path` (with '/') if it has a row; a plugin is a layer of its own, the tests are one."""
    folder = path.rpartition("/")[0]
    if folder in LAYERS and folder != "plugins":
        return folder
    if folder.split("/")[0] == "tests":
        return "tests"
    return folder if re.fullmatch("plugins/[^/]+", folder) else None


def allowed_in(layer):
    if layer in LAYERS:
        return LAYERS[layer]
    return LAYERS["plugins"]  # plugins/<name>


def what_is(bracket, target):
    """The table's word for an include, None for one that it does not know."""
    for library, beginnings in EXTERNALS.items():
        if target.startswith(beginnings):
            return library
    if bracket == "<":
        if target.endswith(".h"):
            return "system"
        return None if "/" in target or "." in target else "std"
    if target.startswith("mavlink/"):
        return "dialect"
    return layer_of(target)


def fault_of(name, bracket, target):
    """The fault of one include of file `name`, None if it is allowed."""
    layer = layer_of(name)
    word = what_is(bracket, target)
    if word is None:
        return f"'{target}' is no include that the table of scripts/check_layers.py knows"
    if layer == "tests" or word == layer:
        return None
    if name.endswith((".hpp", ".h")) and target.startswith(NOT_IN_HEADERS):
        json = target.startswith("nlohmann/") and name.startswith(JSON_HEADERS)
        if not target.startswith(LIGHT) and not json:
            return f"'{target}' is slow to compile and stays out of headers"
    allowed = allowed_in(layer)
    if allowed is EVERYTHING or word in allowed:
        return None
    return f"{layer} may not include {word} ('{target}')"


def check_file(root, name):
    if layer_of(name) is None:
        return [f"{name}:1: its folder has no row in the table of scripts/check_layers.py"]
    complaints = []
    with open(root / name, encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            match = INCLUDE.match(line)
            fault = match and fault_of(name, match.group(1), match.group(2))
            if fault:
                complaints.append(f"{name}:{number}: {fault}")
    return complaints


def check_tree(root):
    """The complaints about all C++ files below `root`, as FILE:LINE: sentence."""
    complaints = []
    for folder in sorted(LAYERS):
        if (root / folder).is_dir() and folder != "tests" and not (root / folder / "README.md").is_file():
            complaints.append(f"{folder}: there is no README.md that says what lives here and what may not")
    for folder, subfolders, files in os.walk(root):
        subfolders[:] = sorted(
            name for name in subfolders if name not in SKIPPED and not name.startswith("."))
        for file in sorted(files):
            if pathlib.PurePath(file).suffix in SUFFIXES:
                name = (pathlib.Path(folder) / file).relative_to(root).as_posix()
                complaints += check_file(root, name)
    return complaints


def main():
    root = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else PROJECT
    complaints = check_tree(root)
    print("\n".join(complaints) if complaints else "each folder includes only what it may")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
