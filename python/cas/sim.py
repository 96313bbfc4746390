# SPDX-License-Identifier: BSD-3-Clause
"""The control socket of hilsim (docs/use/simulator.md, Control)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Union

from .rpc import Address, AsyncClient, Client
from .sim_calls import AsyncSimCalls, SimCalls, SimStatus

START = "start hilsim with `hilsim worlds/bench.yaml --control PATH`, or a whole bench with `with cas.Bench() as bench:`"

#: Longest that a call may take, s: a stretch of simulated time on a machine that may be busy.
PATIENCE_S = 120.0


@dataclass(frozen=True)
class Motion:
    """Place, velocity and attitude of a vehicle."""

    #: From the origin, m.
    north_m: float
    east_m: float
    up_m: float
    #: Velocity, m/s.
    north_m_s: float
    east_m_s: float
    up_m_s: float
    #: Of the body (forward, right, down) against north, east, down, rad.
    roll_rad: float
    pitch_rad: float
    yaw_rad: float


@dataclass(frozen=True)
class Pose(Motion):
    """True motion of a vehicle's centre of mass at a simulated time, from the world's origin."""

    time_s: float
    in_contact: bool


def pose_of(status: SimStatus, vehicle: Union[int, str] = 0) -> Pose:
    """The pose of a vehicle, by its place in the list or its name, out of a status."""
    for place, truth in enumerate(status["vehicles"]):
        if vehicle in (place, truth["name"]):
            east, north, up = truth["p_W"]
            v_east, v_north, v_up = truth["v_W"]
            roll, pitch, yaw = truth["rpy_ND_rad"]
            return Pose(north, east, up, v_north, v_east, v_up, roll, pitch, yaw, status["time_s"],
                        truth["in_contact"])
    names = ", ".join(truth["name"] for truth in status["vehicles"])
    raise KeyError(f"the simulator has no vehicle {vehicle!r}; it has {names}")


class Sim(SimCalls):
    """A connection to hilsim's control socket, blocking; calls may come from several threads.

        sim = cas.Sim("/run/user/1000/hilsim.sock")
        sim.run_for(2.0)
        print(sim.pose().up_m)

    What the socket has: status, pause, resume, step, run_until, reset, phase, stats, quit. It sets neither
    pose, wind nor faults while the simulator runs: those are given in the world's file, or to cas.Bench
    (`pose=`, `wind=`, `faults=`), where a fault may wait for a phase that `phase()` tells.
    """

    def __init__(self, address: Address, *, timeout_s: float = PATIENCE_S) -> None:
        self.client = Client(address, timeout_s=timeout_s, start=START)
        super().__init__(self.client.call)

    def time_s(self) -> float:
        """Simulated time, s."""
        return self.status()["time_s"]

    def pose(self, vehicle: Union[int, str] = 0) -> Pose:
        """True pose of a vehicle, by its place in the list or its name."""
        return pose_of(self.status(), vehicle)

    def run_for(self, duration_s: float) -> SimStatus:
        """Runs for so much simulated time, s, and pauses there."""
        return self.run_until(self.time_s() + duration_s)

    def describe(self) -> dict[str, Any]:
        """The socket's own description: an OpenRPC document."""
        return self.client.describe()

    def close(self) -> None:
        """Ends the connection; hilsim goes on."""
        self.client.close()

    def __enter__(self) -> "Sim":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class AsyncSim(AsyncSimCalls):
    """As Sim, for asyncio: `async with await cas.AsyncSim.connect(path) as sim: await sim.run_until(2.0)`."""

    def __init__(self, client: AsyncClient) -> None:
        self.client = client
        super().__init__(client.call)

    @classmethod
    async def connect(cls, address: Address, *, timeout_s: float = PATIENCE_S) -> "AsyncSim":
        """Connects; the arguments are those of Sim."""
        return cls(await AsyncClient.connect(address, timeout_s=timeout_s, start=START))

    async def pose(self, vehicle: Union[int, str] = 0) -> Pose:
        """True pose of a vehicle, by its place in the list or its name."""
        return pose_of(await self.status(), vehicle)

    async def run_for(self, duration_s: float, since_s: Optional[float] = None) -> SimStatus:
        """Runs for so much simulated time, s, from now or from `since_s`, and pauses there."""
        begin = (await self.status())["time_s"] if since_s is None else since_s
        return await self.run_until(begin + duration_s)

    async def close(self) -> None:
        """Ends the connection; hilsim goes on."""
        await self.client.close()

    async def __aenter__(self) -> "AsyncSim":
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()
