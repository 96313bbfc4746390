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
    "urdfdom": ("urdf_parser/", "urdf_model/", "urdf_world/", "urdf_exception/", "tinyxml"),
    "sdformat": ("sdf/", "ignition/", "gz/"),
    "ncurses": ("ncurses", "curses.h"),
    "intrinsics": ("cpuid.h", "immintrin.h", "nmmintrin.h", "arm_neon.h", "arm_acle.h"),
    "gtest": ("gtest/", "gmock/", "benchmark/"),
}

# "std" is the C++ library, "system" the C headers of the operating system, "dialect" the generated
# headers mavlink/<dialect>/, "intrinsics" those of the compiler for one processor. A folder may always
# include itself. The deepest row counts.
SYSTEM = {"std", "system"}
RPC = {"base", "base/rpc", "nlohmann"}  # who calls or offers methods handles their JSON
MAVLINK = {"mavlink_gen/runtime", "dialect"}
EVERYTHING = None

LAYERS = {
    # the runtime can be lifted into firmware
    "mavlink_gen/runtime": {"std", "intrinsics"},
    "mavlink_gen/parser": SYSTEM | {"mavlink_gen/runtime", "expat"},
    "mavlink_gen/generator":
        SYSTEM | {"mavlink_gen/parser", "mavlink_gen/runtime", "base/cli", "CLI11"},
    "base": SYSTEM | {"spdlog", "yaml-cpp", "Eigen"},
    "base/cli": {"std", "CLI11"},
    "base/rpc": SYSTEM | {"base", "Asio", "nlohmann"},
    "libsim/api": SYSTEM | {"base", "Eigen"},
    "libsim/core": SYSTEM | RPC | {"libsim/api", "libsim/core/ode", "urdfdom", "sdformat", "expat",
                                   "Eigen", "Asio"},
    # the one folder that knows ODE
    "libsim/core/ode": SYSTEM | {"base", "libsim/api", "libsim/core", "ODE", "Eigen"},
    "plugins": SYSTEM | {"libsim/api", "base", "plugins/common", "Eigen"},
    "plugins/mavlink_interface":
        SYSTEM | MAVLINK | {"libsim/api", "base", "plugins/common", "Eigen", "Asio"},
    "casd": SYSTEM | RPC | MAVLINK | {"mavlink_gen/parser", "base/cli", "Asio", "CLI11"},
    "casd/casctl": SYSTEM | RPC | {"base/cli", "CLI11", "ncurses"},
    "fcu": SYSTEM | RPC | MAVLINK | {"base/cli", "Eigen", "Asio", "CLI11"},
    # the composition root, and what tests all
    "hils": EVERYTHING,
    "tests": EVERYTHING,
}

# Single files that may include more than their folder.
FILES = {
    "libsim/hilsim/hilsim_main.cpp": {"base/cli", "CLI11"},
}

# Nothing includes these, apart from themselves and the tests.
ROOTS = {"hils", "tests"}

# Slow to compile: they stay out of headers, so that not everybody pays. Their light parts may stay.
NOT_IN_HEADERS = ("nlohmann/", "spdlog/", "yaml-cpp/", "boost/asio.hpp")
LIGHT = ("nlohmann/json_fwd.hpp",)
# Headers for files that handle JSON anyway.
JSON_HEADERS = ("casd/casctl/", "casd/port/command_params.hpp")

SUFFIXES = {".hpp", ".cpp", ".h", ".cc"}
# example_plugin stands for a stranger's source tree.
SKIPPED = {"build", "out", "node_modules", "__pycache__", "example_plugin"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    """The deepest row of the table that `path` (with '/') lies in; a plugin is a layer of its own."""
    parts = path.split("/")
    for length in range(len(parts) - 1, 0, -1):
        folder = "/".join(parts[:length])
        if folder in LAYERS and folder != "plugins":
            return folder
    if parts[0] == "plugins" and len(parts) > 2:
        return "/".join(parts[:2])
    return parts[0] if parts[0] in LAYERS else None


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
    """What is wrong with one include of file `name`, None when nothing is."""
    layer = layer_of(name)
    word = what_is(bracket, target)
    if word is None:
        return f"'{target}' is no include that the table of scripts/check_layers.py knows"
    if layer == "tests" or word == layer:
        return None
    if word in ROOTS:
        return f"nothing includes {word}, but '{target}' is from there"
    if name.endswith((".hpp", ".h")) and target.startswith(NOT_IN_HEADERS):
        json = target.startswith("nlohmann/") and name.startswith(JSON_HEADERS)
        if not target.startswith(LIGHT) and not json:
            return f"'{target}' is slow to compile and stays out of headers"
    allowed = allowed_in(layer)
    if allowed is EVERYTHING or word in allowed or word in FILES.get(name, ()):
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
