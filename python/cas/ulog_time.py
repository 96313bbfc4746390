# SPDX-License-Identifier: BSD-3-Clause
"""The time of a ULog, though some stamps are damaged."""

from __future__ import annotations

#: A longer leap is believed where most topics make it, us.
GAP_US = 10_000_000
_WHILE_US = 2_000_000


class UlogTime:
    """Which stamps are right: a leap of more than 10 s, as a damaged stamp or a topic with a clock of its own makes one,
    is believed where most topics make it; the same as UlogTime of `hils replay`."""

    def __init__(self, start_us: int) -> None:
        self.newest = start_us
        self.heard: dict[str, int] = {}
        #: Stamps of a leap that is not believed yet, by topic, and the topics that stayed since.
        self.leapt: dict[str, int] = {}
        self.stayed: set[str] = set()
        self.began = 0

    def takes(self, topic: str, stamp: int) -> bool:
        """Whether the next stamp of a topic is believed."""
        if stamp > self.newest + GAP_US:
            if not self._is_confirmed(topic, stamp):
                return False
            self.leapt = {}
        elif self.leapt:
            self.stayed.add(topic)
            self.leapt.pop(topic, None)
        self.newest = max(self.newest, stamp)
        self.heard[topic] = stamp
        return True

    def _is_confirmed(self, topic: str, stamp: int) -> bool:
        self.leapt = {other: at for other, at in self.leapt.items() if other == topic or abs(at - stamp) <= GAP_US}
        if not self.leapt:
            self.stayed, self.began = set(), stamp
        goes_on = topic in self.leapt and stamp > self.leapt[topic]
        self.leapt[topic] = stamp
        if (len(self.leapt) < 2 and not goes_on) or len(self.leapt) <= len(self.stayed):
            return False
        of_late = sum(at + GAP_US >= self.newest for at in self.heard.values())
        return 2 * len(self.leapt) > of_late or (not self.stayed and stamp >= self.began + _WHILE_US)
