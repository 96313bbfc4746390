#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds docs/use/troubleshooting.md to the sources: each quoted message is one of the programs or of the C library.

Usage: troubleshooting_test.py [SOURCE_TREE]
"""

import errno
import os
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
ROOT = ROOT if ROOT.is_dir() else ROOT.parents[2]
PROGRAMS = ("base", "casd", "fcu", "hils", "libsim", "mavlink_gen", "plugins", "scripts", "config")

QUOTED = re.compile(r'"([^"]+)"')
CODE = re.compile(r"`([^`]+)`")
# In a quoted message: placeholders of a name or a figure.
PLACES = re.compile(r"\.\.\.|\b(?:NAME|FILE|LINE|ADDRESS)\b")
# A row whose words are another firmware's.
FOREIGN = re.compile(r"PX4 says")


def sources():
    """All text of the programs; literals that go on in the next line are one."""
    texts = []
    for folder in PROGRAMS:
        for file in sorted((ROOT / folder).rglob("*")):
            if file.is_file() and file.suffix in (".cpp", ".hpp", ".py", ".yaml", ".xml", ".rules", ".service", ""):
                texts.append(file.read_text(errors="replace"))
    return re.sub(r'"\s*\n\s*"', "", "\n".join(texts))


def rows(page):
    """Number and cells of each row below the head of a table."""
    lines = page.splitlines()
    for number, line in enumerate(lines, 1):
        is_head = number < len(lines) and lines[number].startswith("|-")
        if line.startswith("|") and not line.startswith("|-") and not is_head:
            yield number, [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def messages(cell):
    """Sentences that a cell quotes: all in double quotes, and in code sentences, but no names."""
    yield from QUOTED.findall(CODE.sub("", cell))
    for code in CODE.findall(cell):
        if re.search(r"[a-z]: .* ", code):
            yield code


def unsaid(cell, text, errors):
    for message in messages(cell):
        for piece in PLACES.split(message):
            for words in re.split(r", (?=[A-Z])|: (?=[A-Z])|^\w+: ", piece):  # "down, Address already in use"
                words = words.strip(" ,:")
                if len(words) > 3 and words not in text and not any(words in error for error in errors):
                    yield f"nothing says '{words}'"


def main():
    text = sources()
    errors = [os.strerror(number) for number in errno.errorcode]
    complaints = []
    count = 0
    for number, cells in rows((ROOT / "docs/use/troubleshooting.md").read_text()):
        if FOREIGN.search(cells[0]):
            continue
        count += len(list(messages(cells[0])))
        complaints += [f"docs/use/troubleshooting.md:{number}: {what}" for what in unsaid(cells[0], text, errors)]
    if count == 0:
        complaints.append("docs/use/troubleshooting.md quotes nothing")
    print("\n".join(complaints) or f"the {count} quoted messages are what the programs say")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
