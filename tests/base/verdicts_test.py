#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds docs/develop/verdicts.md to the tree: each test that it names is there, with that case, and the words
that it says are printed stand in a source. A row that names no test says "not tested".

Usage: verdicts_test.py [SOURCE_TREE]
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
ROOT = ROOT if ROOT.is_dir() else ROOT.parents[2]
TESTS = ROOT / "tests"

GOOGLE = re.compile(r"`(\w+)\.(\w+)(?:/(\w+))?`(?! \(CTest)")
CTEST = re.compile(r"`([\w.]+)` \(CTest\)")
CODE = re.compile(r"`([^`]+)`")
# Placeholders of a name or a figure in the output.
PLACES = re.compile(r"\b(?:NAME|DEVICE|N|X)\b|[0-9.]+|\.\.\.")
PROGRAMS = ("casd", "hils", "web/server", "libsim", "fcu", "base", "mavlink_gen", "scripts", "tests/base")


def rows(page):
    """Line number and cells of each row below a table's head."""
    for number, line in enumerate(page.splitlines(), 1):
        if line.startswith("|") and not line.startswith(("|-", "| printed |")):
            yield number, [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def missing_google_tests(cell, texts):
    for suite, name, case in GOOGLE.findall(cell):
        pattern = re.compile(rf"^TEST(?:_F|_P)?\(\s*{suite},\s*{name}\)", re.MULTILINE)
        found = [text for text in texts if pattern.search(text)]
        if not found:
            yield f"there is no test {suite}.{name}"
        elif case and not any(f'{{"{case}"' in text for text in found):
            yield f"{suite}.{name} has no case {case}"


def missing_ctests(text, lists):
    for name in CTEST.findall(text):
        if not re.search(rf"add_test\(\s*NAME {re.escape(name)}\s", lists):
            yield f"there is no add_test(NAME {name}"


def sources():
    """All text of the programs; literals that go on in the next line are one."""
    texts = []
    for folder in PROGRAMS:
        for file in (ROOT / folder).rglob("*"):
            if file.is_file() and (file.suffix in (".cpp", ".hpp", ".py", "") and file != pathlib.Path(__file__).resolve()):
                texts.append(file.read_text(errors="replace"))
    return re.sub(r'"\s*\n\s*"', "", "\n".join(texts))


def missing_words(cell, text):
    """The parts of each phrase in code between names and figures must be in a source."""
    for phrase in CODE.findall(cell):
        if phrase.startswith(("casd ", "casctl ", "mavlink_gen ", "scripts/", "--")):
            continue  # how it is called
        for piece in PLACES.split(phrase):
            for word in re.split(r": (?=true\b)", piece):
                if len(word.strip()) > 3 and word.strip(" ,:") not in text:
                    yield f"no source prints '{word.strip()}'"


def main():
    page = (ROOT / "docs/develop/verdicts.md").read_text()
    tests = [file.read_text() for file in TESTS.rglob("*.cpp")]
    lists = "\n".join(file.read_text() for file in TESTS.rglob("CMakeLists.txt"))
    text = sources()
    complaints = [f"docs/develop/verdicts.md: {what}" for what in missing_ctests(page, lists)]
    count = 0
    for number, cells in rows(page):
        count += 1
        where = f"docs/develop/verdicts.md:{number}: "
        if len(cells) != 4:
            complaints.append(where + f"{len(cells)} cells instead of 4")
            continue
        last = cells[3]
        if not (GOOGLE.search(last) or CTEST.search(last) or "not tested" in last or last.startswith("see ")):
            complaints.append(where + "names no test and does not say 'not tested'")
        complaints += [where + what for what in missing_google_tests(last, tests)]
        complaints += [where + what for what in missing_words(cells[0], text)]
    if count == 0:
        complaints.append("docs/develop/verdicts.md has no table")
    print("\n".join(complaints) or f"the {count} rows name tests that are there and words that are printed")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
