# SPDX-License-Identifier: BSD-3-Clause
"""The calls of hilsim, made by generate_calls.py from its `rpc.discover`. Not written by hand."""

from __future__ import annotations

from typing import Any, Awaitable, Dict, List, NotRequired, Optional, Protocol, TypedDict, Union, cast


class _Call(Protocol):
    def __call__(self, method: str, params: Dict[str, Any]) -> Any: ...


class _AsyncCall(Protocol):
    def __call__(self, method: str, params: Dict[str, Any]) -> Awaitable[Any]: ...


def _given(**params: Any) -> Dict[str, Any]:
    """Without what was left out."""
    return {key: value for key, value in params.items() if value is not None}


VehicleTruth = TypedDict("VehicleTruth", {
    "in_contact": bool,
    "name": str,
    "p_W": List[float],  # m, centre of mass
    "q_WB": List[float],  # w, x, y, z; turns B into W
    "rpy_ND_rad": List[float],  # roll, pitch, yaw of D against N
    "v_W": List[float],  # m/s
    "w_B": List[float],  # rad/s
})
SimStatus = TypedDict("SimStatus", {
    "late_steps": int,
    "lockstep_timeouts": int,
    "pace": str,  # realtime, lockstep, free_run
    "paused": bool,
    "real_time_factor": float,
    "steps": int,
    "time_s": float,  # simulated
    "vehicles": List[VehicleTruth],
})
Distribution = TypedDict("Distribution", {
    "count": int,
    "histogram": List[Any],  # [upper end in us, entries]
    "max": float,  # us
    "p50": float,  # us
    "p99": float,  # us
})
SimStats = TypedDict("SimStats", {
    "given_up_s": float,
    "late_steps": int,
    "lateness_us": Distribution,
    "lockstep_timeouts": int,
    "plugins": Dict[str, Any],
    "program": str,
    "real_time_factor": float,
    "schema": int,
    "step_us": Distribution,
    "steps": int,
    "time_s": float,  # simulated
    "wall_s": float,
})

class SimCalls:
    """sim.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def pause(self) -> SimStatus:
        """Pauses; in lockstep once the newest HIL_SENSOR has been answered."""
        return cast(SimStatus, self._call("sim.pause", _given()))

    def phase(self, name: str) -> SimStatus:
        """Tells the plugins what the flight is about."""
        return cast(SimStatus, self._call("sim.phase", _given(name=name)))

    def quit(self) -> SimStatus:
        """Ends the run in good order."""
        return cast(SimStatus, self._call("sim.quit", _given()))

    def reset(self) -> SimStatus:
        """Back to time zero: the same seed, the same run."""
        return cast(SimStatus, self._call("sim.reset", _given()))

    def resume(self) -> SimStatus:
        """Goes on."""
        return cast(SimStatus, self._call("sim.resume", _given()))

    def run_until(self, time_s: float) -> SimStatus:
        """Runs to a simulated time and pauses there; answered when it is reached.

        time_s: since the start
        """
        return cast(SimStatus, self._call("sim.run_until", _given(time_s=time_s)))

    def stats(self) -> SimStats:
        """Figures of the run and of each plugin."""
        return cast(SimStats, self._call("sim.stats", _given()))

    def status(self) -> SimStatus:
        """Time, pace and the true motion of each vehicle."""
        return cast(SimStatus, self._call("sim.status", _given()))

    def step(self, *, n: Optional[int] = None) -> SimStatus:
        """Pauses, makes steps, and answers after the last.

        n: from 1
        """
        return cast(SimStatus, self._call("sim.step", _given(n=n)))


class AsyncSimCalls:
    """sim.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def pause(self) -> SimStatus:
        """Pauses; in lockstep once the newest HIL_SENSOR has been answered."""
        return cast(SimStatus, await self._call("sim.pause", _given()))

    async def phase(self, name: str) -> SimStatus:
        """Tells the plugins what the flight is about."""
        return cast(SimStatus, await self._call("sim.phase", _given(name=name)))

    async def quit(self) -> SimStatus:
        """Ends the run in good order."""
        return cast(SimStatus, await self._call("sim.quit", _given()))

    async def reset(self) -> SimStatus:
        """Back to time zero: the same seed, the same run."""
        return cast(SimStatus, await self._call("sim.reset", _given()))

    async def resume(self) -> SimStatus:
        """Goes on."""
        return cast(SimStatus, await self._call("sim.resume", _given()))

    async def run_until(self, time_s: float) -> SimStatus:
        """Runs to a simulated time and pauses there; answered when it is reached.

        time_s: since the start
        """
        return cast(SimStatus, await self._call("sim.run_until", _given(time_s=time_s)))

    async def stats(self) -> SimStats:
        """Figures of the run and of each plugin."""
        return cast(SimStats, await self._call("sim.stats", _given()))

    async def status(self) -> SimStatus:
        """Time, pace and the true motion of each vehicle."""
        return cast(SimStatus, await self._call("sim.status", _given()))

    async def step(self, *, n: Optional[int] = None) -> SimStatus:
        """Pauses, makes steps, and answers after the last.

        n: from 1
        """
        return cast(SimStatus, await self._call("sim.step", _given(n=n)))
