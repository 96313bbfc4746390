# SPDX-License-Identifier: BSD-3-Clause
"""A whole bench for as long as a `with` block lasts: simulator, casd and controller."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from .casd import Casd
from .errors import CallError, CasError, NoSuchVehicle, NotReached, ProgramEnded, Refused
from .places import program
from .rpc import Client
from .sim import Motion, Sim
from .sim_calls import SimStatus

READY_PATIENCE_S = 60.0
STOP_PATIENCE_S = 10.0
LOOK_PERIOD_S = 0.05
_LOCKSTEP_TIMEOUT_MS = 20_000  # a controller that died, not a machine that is busy
_REQUEST_MESSAGE = 512  # MAV_CMD_REQUEST_MESSAGE
_HOME_POSITION = 242


@dataclass(frozen=True)
class Estimate(Motion):
    """The controller's estimate, from its own origin."""


class _Program:
    """One child. It dies with this process (and with the thread that started it), and has a process group of its
    own, so that Ctrl-C leaves its end to the bench."""

    def __init__(self, name: str, arguments: Sequence[str], folder: Path, environment: Mapping[str, str]) -> None:
        self.name = name
        self.log = folder / f"{name}.log"
        #: Its STATUS to systemd when it was ready.
        self.status = ""
        where = folder / f"{name}.notify"
        self._notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._notify.bind(str(where))
        setpriv = shutil.which("setpriv")
        guard = [setpriv, "--pdeathsig", "TERM"] if setpriv else []
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen([*guard, program(name), *arguments], cwd=folder, stdin=subprocess.DEVNULL,
                                            stdout=log, stderr=subprocess.STDOUT, process_group=0,
                                            env={**environment, "NOTIFY_SOCKET": str(where)})

    def wait_ready(self) -> None:
        """Until it says so. Raises ProgramEnded."""
        deadline = time.monotonic() + READY_PATIENCE_S
        self._notify.settimeout(0.1)
        while time.monotonic() < deadline:
            with contextlib.suppress(TimeoutError):
                told = self._notify.recv(4096).decode(errors="replace")
                if "READY=1" in told:
                    self.status = told
                    return
            self.check()
        raise ProgramEnded(f"{self.name} was not ready in {READY_PATIENCE_S:g} s; its last lines:\n{self.tail()}")

    def check(self) -> None:
        """Raises ProgramEnded when it has ended."""
        code = self.process.poll()
        if code is not None:
            raise ProgramEnded(f"{self.name} ended with {code}; its last lines:\n{self.tail()}")

    def tail(self) -> str:
        """The last lines of its log."""
        with contextlib.suppress(OSError):
            return "\n".join(self.log.read_text(errors="replace").splitlines()[-8:])
        return ""

    def stop(self) -> Optional[int]:
        """Ends it in good order, or by force. Returns its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(STOP_PATIENCE_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._notify.close()
        return self.process.returncode


class Bench:
    """Simulator, casd and emulated controller, started on entry and ended on exit, whatever happens.

        with cas.Bench() as bench:
            bench.arm()
            bench.takeoff(2.5)
            bench.run_for(5)
            print(bench.sim.pose().up_m, bench.estimate().up_m)

    In lockstep, which is the default, simulated time stands still while Python thinks; run_for() and whatever
    waits move it on. The same calls give the same flight. With `lockstep` false it is real time.

    vehicle      vehicle file; names without a folder of their own are looked for among the shipped ones
    sensors      sensor set: "ideal", "rtk", ... or keys in a dict; left out: the vehicle's
    params       parameters of the emulated controller, by PX4's names
    wind         keys of plugin wind, e.g. {"mean_m_s": 3, "from_deg": 270}; the socket of hilsim cannot change it
    faults       entries of plugin fault, e.g. [{"at_s": 20, "for_s": 2, "drop": "gps"}]
    plugins      further plugins of the vehicle, each {"plugin": NAME, ...}
    pose         where it stands: {"x_m", "y_m", "z_m", "yaw_deg"}: east and north of home, m; yaw of the nose from
                 east, counter-clockwise, degrees; 90 (north) where it is left out
    world        an SDF file; left out: flat ground
    line         keys of the emulated serial line (docs/reference/config.md); in real time only
    controller   False: no emulator; one's own sends MAVLink over UDP to `controller_address`
    links, routes  further links and routes of casd (docs/reference/config.md, Topology), e.g. for a ground station
    folder       where logs, configurations, truth.csv, sensors/ and flight.tlog are left; left out: nowhere

    The programs end with the thread that entered the block. Within it: `casd` (Casd), `sim` (Sim), `fcu` (rpc.Client
    of the emulator's control socket), `controller_address`, `folder`.
    """

    def __init__(self, *, vehicle: Union[str, "os.PathLike[str]"] = "vehicles/iris_paper.yaml",
                 sensors: Union[None, str, Mapping[str, Any]] = None, params: Optional[Mapping[str, float]] = None,
                 wind: Optional[Mapping[str, Any]] = None, faults: Sequence[Mapping[str, Any]] = (),
                 plugins: Sequence[Mapping[str, Any]] = (), pose: Optional[Mapping[str, float]] = None,
                 world: Optional[str] = None, home: Optional[Mapping[str, float]] = None, seed: int = 1,
                 step_us: int = 1000, lockstep: bool = True, line: Optional[Mapping[str, Any]] = None,
                 controller: bool = True, links: Sequence[Mapping[str, Any]] = (),
                 routes: Sequence[Mapping[str, Any]] = (),
                 folder: Union[None, str, "os.PathLike[str]"] = None) -> None:
        file = os.fspath(vehicle)
        self._vehicle = os.path.abspath(file) if os.path.exists(file) else file
        self._sensors = sensors
        self._params = dict(params or {})
        self._plugins = [*plugins, *([{"plugin": "wind", **wind}] if wind else []),
                         *([{"plugin": "fault", "faults": [dict(each) for each in faults]}] if faults else [])]
        self._pose: dict[str, float] = {"x_m": 0, "y_m": 0, "yaw_deg": 90, **(pose or {})}
        self._world = world
        self._home = dict(home or {"lat_deg": 47.397742, "lon_deg": 8.545594, "alt_m": 488.0})
        self._seed = seed
        self._step_us = step_us
        self.lockstep = lockstep
        self._line = dict(line or {})
        self._has_emulator = controller
        self._links = [dict(each) for each in links]
        self._routes = [dict(each) for each in routes]
        self._keep = None if folder is None else Path(folder).resolve()
        self._exit = contextlib.ExitStack()
        self._programs: list[_Program] = []
        self.casd: Casd
        self.sim: Sim
        self.fcu: Client
        self.folder: Path
        #: HOST:PORT of casd's link to the controller, where the emulator is left out.
        self.controller_address = ""

    # Start and end.

    def __enter__(self) -> "Bench":
        try:
            self._start()
        except BaseException:
            self._stop()
            raise
        return self

    def __exit__(self, kind: Optional[type[BaseException]], *_: object) -> None:
        codes = self._stop()
        bad = [f"{name} ended with {code}" for name, code in codes.items() if code != 0]
        if bad and kind is None:
            raise ProgramEnded("; ".join(bad))

    def _start(self) -> None:
        places = Path(self._exit.enter_context(tempfile.TemporaryDirectory(prefix="cas-bench-")))
        self._places = places  # short paths: those of sockets are bounded
        self.folder = self._keep or places
        self.folder.mkdir(parents=True, exist_ok=True)
        environment = {**os.environ, "CAS_RUNTIME_DIR": str(places)}
        if self._has_emulator:
            self._launch("fcu_emulator", self._fcu_config(), ["--control", str(places / "fcu.sock")], environment)
            self.fcu = self._exit.enter_context(Client(places / "fcu.sock"))
        self._launch("casd", self._casd_config(), [], environment)
        self.casd = self._exit.enter_context(contextlib.closing(Casd(places / "casd.sock")))
        endpoints = {link["name"]: link["endpoint"] for link in self.casd.link.list()}
        if not self._has_emulator:
            self.controller_address = endpoints["fcu"]
        arguments = ["--paused", "--control", str(places / "sim.sock"), "--output", str(self.folder)]
        self._launch("hilsim", self._sim_config(endpoints["sim"]), arguments, environment)
        self.sim = self._exit.enter_context(contextlib.closing(Sim(places / "sim.sock")))
        if not self.lockstep:
            self.sim.resume()

    def _launch(self, name: str, config: Mapping[str, Any], arguments: Sequence[str],
                environment: Mapping[str, str]) -> None:
        file = self._places / f"{name}.yaml"
        file.write_text(json.dumps(config, indent=1), encoding="utf-8")  # JSON is YAML
        child = _Program(name, [str(file), *arguments], self._places, environment)
        self._programs.append(child)
        child.wait_ready()

    def _stop(self) -> dict[str, Optional[int]]:
        codes = {}
        try:
            for child in reversed(self._programs):  # the simulator first
                codes[child.name] = child.stop()
        finally:
            for child in self._programs:  # an interruption in between
                if child.process.poll() is None:
                    child.process.kill()
                if self._keep and child.log.exists():
                    shutil.copy(child.log, self._keep)
                    shutil.copy(self._places / f"{child.name}.yaml", self._keep)
            self._programs = []
            self._exit.close()
        return codes

    # Configurations.

    def _pace(self) -> str:
        return "lockstep" if self.lockstep else "realtime"

    def _sensor_keys(self) -> dict[str, Any]:
        if self._sensors is None:
            return {}
        return {"sensors": self._sensors if isinstance(self._sensors, str) else dict(self._sensors)}

    def _fcu_config(self) -> dict[str, Any]:
        return {"schema": 1, "vehicle": self._vehicle, **self._sensor_keys(), "pace": self._pace(),
                "line": {} if self.lockstep else self._line, "seed": self._seed, "params": self._params}

    def _casd_config(self) -> dict[str, Any]:
        # In lockstep all programs wait for each other: a late value is not old.
        queue = {"queue": {"hil_max_age_ms": 60_000, "gps_max_age_ms": 60_000}} if self.lockstep else {}
        link: dict[str, Any] = {"name": "fcu", "type": "udp", "local": "127.0.0.1:0"}
        if self._has_emulator:
            link = {"name": "fcu", "type": "serial", "device": "${CAS_RUNTIME_DIR}/fcu0",
                    "baud": 0 if self.lockstep else int(self._line.get("baud", 0))}
        log = {"log": {"folder": str(self.folder), "tlog": "flight.tlog", "overwrite": True,
                       "keep": {"free_space_min_mib": 0}}} if self._keep else {}
        return {"schema": 1, "pace": self._pace(), "gains": "gains.yaml",
                "command_port": {"address": "127.0.0.1", "port": 0, "unix": str(self._places / "casd.sock")},
                "links": [{"name": "sim", "type": "udp", "local": "127.0.0.1:0", **queue}, {**link, **queue}, *self._links],
                "routes": [{"from": "sim", "to": "fcu", "allow": ["HEARTBEAT", "HIL_SENSOR", "HIL_GPS"]},
                           {"from": "fcu", "to": "sim", "allow": ["HEARTBEAT", "HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"]},
                           *self._routes], **log}

    def _sim_config(self, casd: str) -> dict[str, Any]:
        own = [{"plugin": name} for name in ("motor", "imu", "gps", "magnetometer", "barometer")]
        interface = {"plugin": "mavlink_interface", "transport": "udp", "local": "127.0.0.1:0", "remote": casd,
                     "system_id": 1, "component_id": 200}
        recorder = [{"plugin": "recorder", "file": "truth.csv", "rate_hz": 100, "sensor_dir": "sensors"}] if self._keep else []
        vehicle = {"name": "iris0", "vehicle": self._vehicle, "pose": self._pose, **self._sensor_keys(),
                   "plugins": [*own, *self._plugins, interface, *recorder]}
        world: Any = {"gravity_m_s2": 9.80665, "ground": True}
        return {"schema": 1, "world": os.path.abspath(self._world) if self._world else world, "home": self._home,
                "decimal_year": 2026.5, "step_us": self._step_us, "pace": self._pace(),
                "pacing": {"lockstep_timeout_ms": _LOCKSTEP_TIMEOUT_MS}, "seed": self._seed, "vehicles": [vehicle]}

    # Time.

    def check(self) -> None:
        """Raises ProgramEnded when one of the programs has ended."""
        for child in self._programs:
            child.check()

    def run_for(self, duration_s: float) -> SimStatus:
        """Lets so much simulated time pass, s."""
        return self.run_until(self.sim.time_s() + duration_s)

    def run_until(self, time_s: float) -> SimStatus:
        """Lets time pass up to a simulated time, s."""
        try:
            if self.lockstep:
                return self.sim.run_until(time_s)
            while (status := self.sim.status())["time_s"] < time_s:
                time.sleep(min(LOOK_PERIOD_S, time_s - status["time_s"]))
            return status
        except CasError:
            self.check()  # the better reason
            raise

    def wait_until(self, condition: Callable[[], bool], within_s: float = 30.0, what: str = "the condition") -> None:
        """Lets time pass until `condition()` holds, looking each 50 ms of simulated time. Raises NotReached after
        `within_s`, s."""
        end_s = self.sim.time_s() + within_s
        while not condition():
            if self.run_for(LOOK_PERIOD_S)["time_s"] > end_s:
                raise NotReached(f"{what} has not come in {within_s:g} s of simulated time")

    def wait_for_vehicle(self) -> None:
        """Waits in real time, while simulated time stands, until casd has heard a vehicle. Raises NotReached."""
        deadline = time.monotonic() + READY_PATIENCE_S
        while not self.casd.status()["vehicles"]:
            if time.monotonic() > deadline:
                raise NotReached("casd has heard no HEARTBEAT of a vehicle"
                                 + ("" if self._has_emulator else f"; send one to {self.controller_address}"))
            self.check()
            time.sleep(0.01)

    # Flight.

    def estimate(self) -> Estimate:
        """The controller's estimate: from the emulator itself, else from its messages to casd (its state has a place only
        once LOCAL_POSITION_NED and ATTITUDE have come)."""
        if self._has_emulator:
            status = self.fcu.call("fcu.status")
            north, east, down = status["p_N_m"]
            v_north, v_east, v_down = status["v_N_m_s"]
            return Estimate(north, east, -down, v_north, v_east, -v_down, *status["rpy_rad"])
        state = self.casd.vehicle.state()
        if "position_N" not in state or "attitude" not in state:
            raise NotReached("the controller has told no position and attitude yet")
        at, turned = state["position_N"], state["attitude"]
        return Estimate(at["x_m"], at["y_m"], -at["z_m"], at["vx_m_s"], at["vy_m_s"], -at["vz_m_s"],
                        turned["roll_rad"], turned["pitch_rad"], turned["yaw_rad"])

    def arm(self, within_s: float = 30.0) -> None:
        """Arms as soon as the vehicle is heard and lets one: asks again each second of simulated time. Raises the last
        refusal after `within_s`, s."""
        end_s = self.sim.time_s() + within_s
        while True:
            try:
                self.casd.vehicle.arm()
                return
            except (NoSuchVehicle, Refused):
                if self.sim.time_s() >= end_s:
                    raise
            if self._has_emulator and not self.fcu.call("fcu.status")["estimator_ready"]:
                self.wait_until(lambda: bool(self.fcu.call("fcu.status")["estimator_ready"]), within_s,
                                "the controller's estimate")
            self.run_for(1.0)

    def _hovers_at(self, north_m: float, east_m: float, up_m: float, radius_m: float = 0.3) -> bool:
        at = self.estimate()
        offset = (at.north_m - north_m, at.east_m - east_m, at.up_m - up_m)
        speed = (at.north_m_s, at.east_m_s, at.up_m_s)
        return sum(x * x for x in offset) < radius_m ** 2 and sum(v * v for v in speed) < 0.3 ** 2

    def _tell_home(self) -> None:
        with contextlib.suppress(CallError):  # it may have none yet
            self.casd.vehicle.command(_REQUEST_MESSAGE, params=[_HOME_POSITION])

    def takeoff(self, altitude_m: float, within_s: float = 30.0) -> None:
        """Takes off and waits until it hovers at that height above home, m."""
        at = self.estimate()
        self._tell_home()
        self.casd.vehicle.takeoff(altitude_m)
        self.wait_until(lambda: self._hovers_at(at.north_m, at.east_m, altitude_m, 0.5), within_s, "the hover")

    def goto(self, north_m: float, east_m: float, up_m: float, yaw_deg: Optional[float] = None,
             within_s: float = 30.0) -> None:
        """Goes to a place from the controller's origin, m, and waits until it hovers there; `yaw_deg` is the heading
        from north, clockwise."""
        self._tell_home()
        self.casd.vehicle.goto(north_m, east_m, -up_m, yaw_deg=yaw_deg)
        self.wait_until(lambda: self._hovers_at(north_m, east_m, up_m), within_s, "the hover there")

    def land(self, within_s: float = 60.0) -> None:
        """Lands and waits until the true vehicle stands and the controller has disarmed."""
        self.casd.vehicle.land()
        self.wait_until(lambda: self.sim.pose().in_contact and not self._armed(), within_s, "the landing")

    def _armed(self) -> bool:
        if self._has_emulator:
            return bool(self.fcu.call("fcu.status")["armed"])
        return self.casd.vehicle.state()["armed"]
