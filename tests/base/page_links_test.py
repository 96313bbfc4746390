#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds the links between the pages: each relative link leads to a file and a heading that are there, and so does
each docs/....md that a source, script or configuration file names.

Usage: page_links_test.py [SOURCE_TREE]
"""

import os
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
ROOT = ROOT if ROOT.is_dir() else ROOT.parents[2]
SOURCES = ("base", "casd", "cmake", "config", "fcu", "hils", "libsim", "mavlink_gen", "packaging", "plugins", "python",
           "scripts", "tests", "web")
MADE_UP = "tests/base/scripts_test.py"  # names a page of its own
LINK = re.compile(r"(?:\]\(|src=\")([^)\s\"]+)")
NAMED = re.compile(r"\bdocs/[\w/]+\.md(?:#[\w-]+)?")
FENCE = re.compile(r"^ *```.*?^ *```$", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]*`")


def anchors(page):
    """The anchors that GitHub makes of the headings of a page."""
    found = set()
    for heading in re.findall(r"^#+ (.*)$", FENCE.sub("", page.read_text()), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        found.add(re.sub(r"[^\w\- ]", "", words).strip().replace(" ", "-"))
    return found


def fault(target, anchor):
    if not target.exists():
        return "there is no such file"
    if anchor and target.suffix == ".md" and anchor not in anchors(target):
        return "there is no such heading"
    return None


def files(folder):
    for place, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if name not in ("node_modules", "__pycache__")]
        yield from (pathlib.Path(place) / name for name in names)


def named_links():
    """(file, what it names, target, anchor) of all links."""
    pages = [*ROOT.glob("*.md"), *files(ROOT / "docs"), *(file for folder in SOURCES for file in files(ROOT / folder))]
    for page in (page for page in pages if page.suffix == ".md"):
        for link in LINK.findall(CODE.sub("", FENCE.sub("", page.read_text()))):
            if not re.match(r"[a-z]+:", link):
                path, _, anchor = link.partition("#")
                yield page, link, page.parent / path if path else page, anchor
    for folder in SOURCES:
        for file in (file for file in files(ROOT / folder) if file != ROOT / MADE_UP):
            try:
                names = set(NAMED.findall(file.read_text()))
            except UnicodeDecodeError:
                continue
            for name in names:
                path, _, anchor = name.partition("#")
                yield file, name, ROOT / path, anchor


def main():
    links = list(named_links())
    complaints = [f"{file.relative_to(ROOT)}: {link}: {found}" for file, link, target, anchor in links
                  if (found := fault(target, anchor))]
    if not links:
        complaints.append("no page has a link")
    print("\n".join(complaints) or f"the {len(links)} links of pages and sources lead somewhere")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
