#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Progress of a measurement's parts on standard error: parts done, of all, time left, for scripts in Python.

    steps = Steps("bench", 12)
    steps.next("hover, seed 1")     bench: 0 of 12, 0:00; hover, seed 1
"""

import sys
import time


def line(name, done, total, elapsed, what):
    """The time left appears from the first finished part on."""
    text = f"{name}: {done} of {total}, {clock(elapsed)}"
    if 0 < done < total:
        text += f", about {clock(elapsed * (total - done) / done)} left"
    return f"{text}; {what}" if what else text


def clock(seconds):
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


class Steps:
    """One line that is rewritten on a terminal; elsewhere a line for each part."""

    def __init__(self, name, total):
        self.name = name
        self.total = total
        self.done = -1
        self.begin = time.monotonic()
        self.terminal = sys.stderr.isatty()

    def next(self, what=""):
        """The part before is done; this one begins."""
        self.at(self.done + 1, what)

    def at(self, done, what=""):
        """So many parts are done."""
        self.done = done
        text = line(self.name, self.done, self.total, time.monotonic() - self.begin, what)
        if self.terminal:
            sys.stderr.write(f"\r\033[K{text}")
        else:
            sys.stderr.write(text + "\n")
        sys.stderr.flush()

    def again(self, what):
        """More of the part under way; on a terminal only."""
        if self.terminal:
            self.done -= 1
            self.next(what)

    def clear(self):
        """Takes the line away, before anything else is printed."""
        if self.terminal:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()
