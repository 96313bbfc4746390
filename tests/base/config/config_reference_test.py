#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds docs/reference/config.md and docs/use/plugins.md to the parsers: a key that is read is described in the section of its
file, and a key that a table or an example there names stands in the sources of that program. The tables of
topologies, simulations, controllers, scenarios and sensors are their programs' own words (tests/loopback/manuals_test.cpp).

Usage: config_reference_test.py [SOURCE_TREE]
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
ROOT = ROOT if ROOT.is_dir() else ROOT.parents[3]

PAGES = {"config": "docs/reference/config.md", "plugins": "docs/use/plugins.md"}

# Section of a page -> the files that read its keys.
SECTIONS = {
    ("config", "Scenario"): ["hils/scenario/scenario.cpp", "hils/flight/flight_step.cpp"],
    ("config", "Vehicle"): ["base/config/vehicle_file.cpp", "base/config/propulsion_file.cpp", "base/config/model_match.cpp"],
    ("plugins", "wind"): ["plugins/wind/*.cpp"],
    ("plugins", "fault"): ["plugins/fault/fault_spec.cpp"],
    ("plugins", "recorder"): ["plugins/recorder/recorder_plugin.cpp"],
    ("plugins", "mavlink_interface"): ["plugins/mavlink_interface/mavlink_interface_plugin.cpp"],
}

# Whose words a section names besides.
FURTHER = {("config", "Scenario"): ["plugins/fault/*.cpp", "fcu/core/*.cpp", "casd/station/*.cpp", "base/config/weather_keys.hpp"]}

# Functions that take a key, by the beginning of their names.
READERS = r"(?:at|find|has|get|require|optional|parse|positive|non_negative|microseconds|ms|kib|handed_on|place|offer|key)"
READ = re.compile(READERS + r"\w*(?:<[^>]*>)?\(\s*(?:\*?[\w.]+,\s*)?\"([a-z]\w*)\"")
WORD = re.compile(r"[A-Za-z]\w*")

# In every file, so described once.
EVERYWHERE = {"schema", "preset", "description", "rate_hz"}
# Made up of pieces in the source: read, but not found there as a whole.
COMPOSED = re.compile(r"^(specific_force|angular_rate|position|velocity|field|pressure|temperature|distance)(_\w+)?$")
# Quantities, words and file names that stand in the tables beside keys.
VALUES = {
    "config": {"hold", "arm", "takeoff", "land", "disarm", "goto", "setgain", "x_m", "y_m", "z_m", "yaw_rad", "p", "i",
               "d", "all", "udp", "udp_server", "tcp", "tcp_server", "serial", "iris0", "motor", "imu", "gps",
               "magnetometer", "barometer", "mavlink_interface", "recorder", "transport", "file", "ledger", "rate_hz",
               "local", "remote", "plugin", "FILE", "NAME", "DIR", "sensors"},
    "plugins": {"imu", "gps", "magnetometer", "barometer", "rangefinder", "name", "m_s2", "with", "plugin", "delay_s"},
}


def section(page, title):
    """The text below a heading, with its sub-headings."""
    text = (ROOT / PAGES[page]).read_text()
    found = re.search(rf"^(#+) {re.escape(title)}$", text, re.MULTILINE)
    if not found:
        raise SystemExit(f"{PAGES[page]} has no heading '{title}'")
    rest = text[found.end():]
    end = re.search(rf"^#{{1,{len(found[1])}}} ", rest, re.MULTILINE)
    return rest[:end.start()] if end else rest


def described(text):
    """Every word in code: possible keys."""
    words = set()
    for code in re.findall(r"```.*?```|`[^`]+`", text, re.DOTALL):
        words.update(WORD.findall(code))
    return words


def named(text):
    """Keys that tables and examples claim: first cells, and words before a colon in a block of YAML."""
    keys = set()
    for row in re.findall(r"^\|([^|]*)\|", text, re.MULTILINE):
        for code in re.findall(r"`([^`]+)`", row):
            keys.update(WORD.findall(code))
    for block in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL):
        keys.update(re.findall(r"([A-Za-z]\w*):(?=\s)", re.sub(r"#.*", "", block)))
    return keys


def read_keys(globs):
    keys = set()
    for pattern in globs:
        for file in ROOT.glob(pattern):
            keys.update(READ.findall(file.read_text()))
    return keys


def words_near(globs):
    """All words in quotes in the programs of the parsers: keys, words of enumerations, and keys that helpers read."""
    words = set()
    parts = [pathlib.PurePath(pattern).parts for pattern in globs]
    for folder in {"/".join(part[:2] if part[0] == "plugins" else part[:1]) for part in parts}:
        for file in (ROOT / folder).rglob("*.?pp"):
            words.update(re.findall(r'"([A-Za-z]\w*)"', file.read_text()))
    return words


def main():
    complaints = []
    for (page, title), globs in SECTIONS.items():
        text = section(page, title)
        read = read_keys(globs)
        for key in sorted(read - described(text) - EVERYWHERE):
            complaints.append(f"{PAGES[page]}, {title}: '{key}' is read by {' '.join(globs)} and not described")
        for key in sorted(named(text) - words_near(globs + FURTHER.get((page, title), [])) - EVERYWHERE - VALUES[page]):
            if not COMPOSED.match(key) and not key.endswith("_"):
                complaints.append(f"{PAGES[page]}, {title}: '{key}' is described and read by no parser")
    print("\n".join(complaints) or "the reference and the parsers name the same keys")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
