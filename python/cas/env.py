# SPDX-License-Identifier: BSD-3-Clause
"""The simulator as an environment: reset, and step by one control period, inside this process.

    env = cas.env.Env(action_level="rates", pose={"z_m": 20})
    action, observation = env.new_action(), env.new_observation()
    env.reset(observation, seed=1)
    env.step(action, observation)

It needs the extension _cas_env (Debian: python3-cas-env; in the tree: pybind11-dev when it is built).
"""

from __future__ import annotations

import array
import importlib
import importlib.machinery
import importlib.util
import json
import math
import os
import sys
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Protocol, Sequence, Union, cast

from .errors import CasError, ProgramMissing


class _Core(Protocol):
    """Interface of the extension's StepEnv."""

    def reset(self, seed: int, observation: Any) -> None: ...
    def step(self, action: Any, observation: Any) -> None: ...
    def close(self) -> None: ...
    def action_names(self) -> list[str]: ...
    def action_limits(self) -> list[tuple[float, float]]: ...
    def observation_names(self) -> list[str]: ...
    def time_s(self) -> float: ...
    def in_contact(self) -> bool: ...
    def drawn(self) -> list[tuple[str, str]]: ...


def _extension() -> Any:
    """Module _cas_env: installed, or of the build tree that CAS_BIN names."""
    if "_cas_env" in sys.modules:
        return sys.modules["_cas_env"]
    folder = os.environ.get("CAS_BIN")
    tree = Path(folder).resolve().parent if folder else None
    try:
        if tree is None or not (tree / "CMakeCache.txt").exists():
            return importlib.import_module("_cas_env")
        # An installed one beside the programs of a build tree would be of other sources.
        path = tree / "lib" / ("_cas_env" + importlib.machinery.EXTENSION_SUFFIXES[0])
        spec = importlib.util.spec_from_file_location("_cas_env", path)
        if not path.exists() or spec is None or spec.loader is None:
            raise ImportError(f"there is no {path}")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        sys.modules["_cas_env"] = module
        return module
    except ImportError as error:
        raise ProgramMissing("cas.env needs the extension _cas_env: install python3-cas-env, or pybind11-dev before "
                             f"scripts/build and set CAS_BIN ({error})") from error


class Env:
    """One vehicle in the simulator, moved by one control period a call. One at a time in a process: close() ends one.

    action_level what an action is: "motors" (each 0..1, then servos), "rates" (body rates in D,
                 rad/s, and thrust, a share of full), "attitude" (roll, pitch, yaw, rad, and thrust) or "velocity"
                 (north, east, down, m/s, and yaw rate, rad/s). The loops below you are the emulated controller's
                 own; they read attitude and velocity as they are, without an estimator
    observe      "truth", or "sensors": the newest sample of each, with the noise and the delay of `sensors`; the rates
                 that the loops below you read are then the gyro's
    vehicle, sensors, world, home, pose, wind, faults, plugins, params
                 as in cas.Bench; the vehicle starts at rest at `pose`, its rotors stopped, and needs no arming.
                 Plugins write their files into the working directory
    vary         what each episode's seed draws: entries as `vary` of a study (docs/use/sweep.md), e.g. {"key":
                 "faults[payload].mass_factor", "uniform": [0.8, 1.2]}; keys lead into the arguments above
    period_us    simulated time of a step, microseconds; a multiple of `step_us`, the simulator's own

    Actions and observations are your own memory, written and read in place: NumPy arrays or array.array, float64 ("d")
    or float32 ("f"). The same seed and actions give the same bytes.
    """

    def __init__(self, *, action_level: str = "motors", observe: str = "truth",
                 vehicle: Union[str, "os.PathLike[str]"] = "vehicles/iris_paper.yaml",
                 sensors: Union[None, str, Mapping[str, Any]] = None, world: Optional[str] = None,
                 home: Optional[Mapping[str, float]] = None, pose: Optional[Mapping[str, float]] = None,
                 wind: Optional[Mapping[str, Any]] = None, faults: Sequence[Mapping[str, Any]] = (),
                 plugins: Sequence[Mapping[str, Any]] = (), params: Optional[Mapping[str, float]] = None,
                 vary: Sequence[Mapping[str, Any]] = (), period_us: int = 2000, step_us: int = 1000) -> None:
        file = os.fspath(vehicle)
        setup: dict[str, Any] = {"vehicle": os.path.abspath(file) if os.path.exists(file) else file, "step_us": step_us}
        own = [dict(each) for each in plugins] + ([{"plugin": "wind", **wind}] if wind else [])
        for key, value in (("sensors", sensors), ("home", home), ("params", params), ("plugins", own),
                           ("world", os.path.abspath(world) if world else None),
                           ("faults", [dict(each) for each in faults])):
            if value:
                setup[key] = value if isinstance(value, (str, list)) else dict(cast(Mapping[str, Any], value))
        setup["pose"] = {"x_m": 0, "y_m": 0, "yaw_deg": 90, **(pose or {})}
        varied = json.dumps([dict(each) for each in vary]) if vary else ""
        core: _Core = _told(lambda: _extension().StepEnv(json.dumps(setup), varied, action_level, observe, period_us))
        self._core = core
        self._last_seed = 0
        #: Meaning of each number of an action, with its unit; its least and greatest value.
        self.action_names = core.action_names()
        self.action_limits = core.action_limits()
        #: Meaning of each number of an observation, with its unit. NaN: no sample has come yet.
        self.observation_names = core.observation_names()

    def new_action(self) -> "array.array[float]":
        """An action of zeros."""
        return array.array("d", bytes(8 * len(self.action_names)))

    def new_observation(self) -> "array.array[float]":
        """Room for an observation."""
        return array.array("d", bytes(8 * len(self.observation_names)))

    def reset(self, observation: Any, seed: Optional[int] = None) -> None:
        """Begins an episode and writes its first observation. Without a seed it takes the one after the last, at
        first 1."""
        taken = seed if seed is not None else self._last_seed + 1
        _told(lambda: self._core.reset(taken, observation))
        self._last_seed = taken

    def step(self, action: Any, observation: Any) -> None:
        """Flies on for one control period, and writes the observation at its end."""
        try:  # without _told(): one call less in the hottest method
            self._core.step(action, observation)
        except RuntimeError as error:
            raise CasError(str(error)) from error

    def close(self) -> None:
        """Ends the episode: another Env of this process may then be made. reset() begins the next one."""
        self._core.close()

    @property
    def time_s(self) -> float:
        """Simulated time since the reset, s."""
        return self._core.time_s()

    @property
    def in_contact(self) -> bool:
        """Whether the vehicle touches the ground, or anything."""
        return self._core.in_contact()

    @property
    def drawn(self) -> dict[str, str]:
        """Values drawn by the episode's seed, by the names of `vary`."""
        return dict(self._core.drawn())


def _told(call: Callable[[], Any]) -> Any:
    """The result of a call; a refusal of the extension is a CasError."""
    try:
        return call()
    except RuntimeError as error:
        raise CasError(str(error)) from error


def gymnasium_env(env: Env, reward: Callable[[Any, Any], float],
                  terminated: Callable[[Any], bool] = lambda observation: False, longest_s: float = math.inf) -> Any:
    """`env` with gymnasium's interface (gymnasium and NumPy are to be installed). `reward(observation, action)` and
    `terminated(observation)` are yours; an episode is truncated after `longest_s`, s. A reset with a seed makes all
    later episodes repeat, too. Where no sample of a sensor has come yet there is 0, not NaN, which no space holds."""
    import gymnasium
    import numpy

    def box(limits: Sequence[tuple[float, float]]) -> Any:
        low, high = (numpy.array(side, dtype=numpy.float64) for side in zip(*limits))
        return gymnasium.spaces.Box(low=low, high=high, dtype=numpy.float64)

    class GymnasiumEnv(gymnasium.Env):  # type: ignore[misc]
        """`step` and `reset` return new arrays, as gymnasium's users expect."""

        metadata: dict[str, Any] = {"render_modes": []}
        render_mode = None

        def __init__(self) -> None:
            self.action_space = box(env.action_limits)
            self.observation_space = box([(-math.inf, math.inf)] * len(env.observation_names))

        def reset(self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None) -> Any:
            super().reset(seed=seed)
            observation = numpy.empty(len(env.observation_names))
            env.reset(observation, int(self.np_random.integers(1 << 62)) if seed is None else seed)
            observation[numpy.isnan(observation)] = 0
            return observation, {"drawn": env.drawn}

        def step(self, action: Any) -> Any:
            taken = numpy.ascontiguousarray(action, dtype=numpy.float64)
            observation = numpy.empty(len(env.observation_names))
            env.step(taken, observation)
            observation[numpy.isnan(observation)] = 0
            info = {"time_s": env.time_s, "in_contact": env.in_contact}
            return (observation, float(reward(observation, taken)), bool(terminated(observation)),
                    env.time_s >= longest_s, info)

        def close(self) -> None:
            env.close()

    return GymnasiumEnv()
