#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Follows docs/use/vehicles.md as a reader would: writes its files into an empty folder, calls its programs and
compares what they print with the page; then breaks the vehicle as the page says, and flies it.

Usage: vehicles_page_test.py BUILD_TREE [--print]    (--print: what the page should have, to paste)
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/use/vehicles.md").read_text()
BIN = pathlib.Path(sys.argv[1]).resolve() / "bin"


def blocks(kind):
    """(argument, text) of each code block below a comment '<!-- kind: argument -->'."""
    return re.findall(rf"<!-- {kind}: (.+?) -->\n```\w*\n(.*?)```", PAGE, re.DOTALL)


def run(command, folder, expected_exit=0):
    words = command.split()
    done = subprocess.run([str(BIN / words[0]), *words[1:]], cwd=folder, capture_output=True, text=True, timeout=300)
    if done.returncode != expected_exit:
        sys.exit(f"{command}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout, done.stderr


def check(condition, sentence):
    if not condition:
        sys.exit(sentence)


def refusal(folder, change):
    """Output of hilsim on mine.yaml after a change of its text."""
    before = (folder / "mine.yaml").read_text()
    (folder / "mine.yaml").write_text(change(before))
    _, error = run("hilsim --describe mine.yaml", folder, 78)
    (folder / "mine.yaml").write_text(before)
    return error


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    files = blocks("file")
    check(len(files) == 4, "the page has a URDF, two vehicles and a scenario")
    for file, text in files:
        (folder / file).write_text(text)

    outputs = blocks("output")
    check(len(outputs) >= 1, "the page shows its own vehicle")
    for command, text in outputs:
        printed, _ = run(command, folder)
        if "--print" in sys.argv:
            print(f"== {command}\n{printed}")
        else:
            check(printed == text, f"{command} prints\n{printed}\nand the page has\n{text}")

    parts = blocks("part")
    check(len(parts) >= 1, "the page shows a part of a shipped vehicle")
    for command, text in parts:
        printed, _ = run(command, folder)
        rest = iter(printed.splitlines())
        for line in text.splitlines():
            check(line in rest, f"{command} prints\n{printed}\nwithout, in this order, the page's line\n{line}")

    run("hilsim --describe mine.yaml --svg mine.svg", folder)
    picture = xml.etree.ElementTree.parse(folder / "mine.svg").getroot()
    discs = [e for e in picture if e.tag.endswith("polygon")]
    check(len(discs) == 2 * (1 + 4), "two views of one box and four rotors")

    # The refusals that the page shows.
    missing = refusal(folder, lambda text: re.sub(r"  (radius_m|ground_effect).*\n", "", text)
                      .replace("{link: prop_rl, spin: 1}", "{link: prop_rl}"))
    shown = re.search(r"hilsim: (mine\.yaml:1: keys are missing: .*)", PAGE)[1]
    check(shown in missing, f"the page has\n{shown}\nhilsim says\n{missing}")
    differing = refusal(folder, lambda text: text.replace(
        "{link: prop_fr, spin: 1}", "{link: prop_fr, spin: 1, position_B_m: [0.3, -0.3, 0.03]}"))
    shown = re.search(r"hilsim: (mine\.yaml:\d+: rotors\[0\]\.position_B_m: .*)", PAGE)[1]
    check(shown in differing, f"the page has\n{shown}\nhilsim says\n{differing}")

    # The first flight.
    command = re.search(r"```sh\n(hils run .*)\n```", PAGE)[1]
    run(command, folder)
    check((folder / "out/report.html").exists(), "the flight leaves a report")

    # And that of the vehicle with circuits.
    scenario = (folder / "first.yaml").read_text().replace("vehicle: mine.yaml", "vehicle: electric.yaml")
    (folder / "second.yaml").write_text(scenario)
    run("hils run second.yaml --virtual --out electric", folder)
    summary = json.loads((folder / "electric/summary.json").read_text())
    currents = summary["vehicles"][0]["plugins"]["motor"]
    check(len(currents) == 4, f"a curve for the current of each motor, not {currents}")
    check(all(1 < curve["mean"] < 10 for curve in currents.values()), f"some amperes in hover, not {currents}")
