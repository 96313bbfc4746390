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


Clouds = TypedDict("Clouds", {
    "t_s": float,  # simulated
    "v": List[Any],  # x, y, z of each return in W, m, one after the other, in the order of the scene's vehicles
})
NotedCall = TypedDict("NotedCall", {
    "client": str,
    "method": str,  # or a signal's name
    "params": Any,
    "time_s": float,  # simulated
    "times": NotRequired[int],  # so many of sim.run_until, or of the same sim.step, in a row; params of the last
    "unix_us": int,
})
SimJournal = TypedDict("SimJournal", {
    "calls": List[NotedCall],
    "forgotten": int,  # older ones
})
MeshPiece = TypedDict("MeshPiece", {
    "base64": str,  # the bytes from `offset` on, 256 KiB at most
    "bytes": int,  # of the whole mesh
})
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
SceneHome = TypedDict("SceneHome", {
    "alt_m": float,
    "lat_deg": float,
    "lon_deg": float,
})
SceneSurface = TypedDict("SceneSurface", {
    "index": int,
    "sign": float,  # of the turn about its y axis at x = size / 2 by a deflection above 0
})
ScenePart = TypedDict("ScenePart", {
    "length_m": NotRequired[float],  # along z
    "mesh": NotRequired[str],  # sha256: and the hash
    "name": str,
    "p": List[float],  # m, in the parent
    "q": List[float],  # w, x, y, z
    "radius_m": NotRequired[float],
    "shape": str,  # box, sphere, cylinder, plane, mesh
    "size_m": NotRequired[List[float]],
    "surface": NotRequired[SceneSurface],  # of a visual that is a control surface
})
SceneObstacle = TypedDict("SceneObstacle", {
    "name": str,
    "parts": List[ScenePart],
})
SceneRay = TypedDict("SceneRay", {
    "dir_B": List[float],
    "max_m": float,
    "name": str,
    "p_B": List[float],  # m
})
SceneRotor = TypedDict("SceneRotor", {
    "axis_B": List[float],
    "k_f": float,  # N s^2
    "k_m": float,  # N m s^2
    "omega_max_rad_s": float,
    "p_B": List[float],  # m, hub
    "radius_m": float,
    "spin": int,  # 1 counter-clockwise, -1 clockwise
})
SceneVehicle = TypedDict("SceneVehicle", {
    "mass_kg": float,
    "name": str,
    "parts": List[ScenePart],  # what touches the ground
    "rays": List[SceneRay],
    "rotors": List[SceneRotor],
    "system": int,
    "type": str,  # the vehicle file's name
    "visuals": List[ScenePart],  # of its model without the rotors; none where it has neither wings nor a mesh among them
})
Scene = TypedDict("Scene", {
    "frame": str,  # W
    "hash": str,
    "home": SceneHome,
    "obstacles": List[SceneObstacle],  # that move
    "vehicles": List[SceneVehicle],
    "world": List[ScenePart],
})
Distribution = TypedDict("Distribution", {
    "count": int,
    "histogram": List[Any],  # [upper end in us, entries]
    "max": float,  # us
    "p50": float,  # us
    "p99": float,  # us
})
SimWarning = TypedDict("SimWarning", {
    "vehicle": str,  # its name, or empty for the world
    "warning": str,
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
    "warnings": List[SimWarning],
})
ObstacleMotion = TypedDict("ObstacleMotion", {
    "p": List[float],  # m, in W
    "q": List[float],  # w, x, y, z
})
VehicleMotion = TypedDict("VehicleMotion", {
    "contact": int,  # 0 or 1
    "p": List[float],  # m, in W
    "q": List[float],  # w, x, y, z; turns B into W
    "rays": List[Optional[float]],  # m
    "rotors": List[float],  # rad/s
    "surfaces": List[float],  # rad
    "vel": List[float],  # m/s, in W
    "w": List[float],  # rad/s, in B
})
Motion = TypedDict("Motion", {
    "late_steps": int,
    "o": List[ObstacleMotion],
    "paused": bool,
    "rate": float,  # real-time factor
    "steps": int,
    "t_s": float,  # simulated
    "v": List[VehicleMotion],
    "wind_W": List[float],  # m/s, at the first vehicle
})

class SimCalls:
    """sim.*"""

    def __init__(self, call: _Call) -> None:
        self._call = call

    def clouds(self) -> Clouds:
        """The newest scan of each lidar for a picture: at most 1500 returns of it."""
        return cast(Clouds, self._call("sim.clouds", _given()))

    def fault(self, vehicle: str, fault: Any) -> bool:
        """A fault that begins with the next step, for a vehicle whose plugin fault has by_hand.

        vehicle: its name
        fault: as an entry of the plugin's faults, without at_s and when
        """
        return cast(bool, self._call("sim.fault", _given(vehicle=vehicle, fault=fault)))

    def journal(self) -> SimJournal:
        """The newest calls and signals that changed the run, the oldest first."""
        return cast(SimJournal, self._call("sim.journal", _given()))

    def mesh(self, hash: str, *, offset: Optional[int] = None) -> MeshPiece:
        """A mesh of the scene, in pieces: counts of vertices and triangles (uint32), vertices (float32), indices (uint32).

        hash: 64 hexadecimal digits
        offset: bytes
        """
        return cast(MeshPiece, self._call("sim.mesh", _given(hash=hash, offset=offset)))

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

    def scene(self) -> Scene:
        """What there is, as the physics has it: shapes, rotors, beams."""
        return cast(Scene, self._call("sim.scene", _given()))

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

    def watch(self) -> Motion:
        """The newest motion, rounded for a picture; sampled 60 times a second at most, however many ask."""
        return cast(Motion, self._call("sim.watch", _given()))


class AsyncSimCalls:
    """sim.*"""

    def __init__(self, call: _AsyncCall) -> None:
        self._call = call

    async def clouds(self) -> Clouds:
        """The newest scan of each lidar for a picture: at most 1500 returns of it."""
        return cast(Clouds, await self._call("sim.clouds", _given()))

    async def fault(self, vehicle: str, fault: Any) -> bool:
        """A fault that begins with the next step, for a vehicle whose plugin fault has by_hand.

        vehicle: its name
        fault: as an entry of the plugin's faults, without at_s and when
        """
        return cast(bool, await self._call("sim.fault", _given(vehicle=vehicle, fault=fault)))

    async def journal(self) -> SimJournal:
        """The newest calls and signals that changed the run, the oldest first."""
        return cast(SimJournal, await self._call("sim.journal", _given()))

    async def mesh(self, hash: str, *, offset: Optional[int] = None) -> MeshPiece:
        """A mesh of the scene, in pieces: counts of vertices and triangles (uint32), vertices (float32), indices (uint32).

        hash: 64 hexadecimal digits
        offset: bytes
        """
        return cast(MeshPiece, await self._call("sim.mesh", _given(hash=hash, offset=offset)))

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

    async def scene(self) -> Scene:
        """What there is, as the physics has it: shapes, rotors, beams."""
        return cast(Scene, await self._call("sim.scene", _given()))

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

    async def watch(self) -> Motion:
        """The newest motion, rounded for a picture; sampled 60 times a second at most, however many ask."""
        return cast(Motion, await self._call("sim.watch", _given()))
