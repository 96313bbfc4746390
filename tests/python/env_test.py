# SPDX-License-Identifier: BSD-3-Clause
"""cas.env: the simulator by reset and step, on the built extension."""

import array
import importlib.machinery
import math
import sys
import types
import unittest
from unittest import mock

from helpers import FolderTest

import cas
import cas.env

try:
    import numpy
except ImportError:
    numpy = None

HIGH = {"z_m": 100}


def fly(env, action, steps, seed=1, observation=None):
    """The observation after so many steps with one action."""
    observation = env.new_observation() if observation is None else observation
    env.reset(observation, seed)
    taken = array.array("d", action)
    for _ in range(steps):
        env.step(taken, observation)
    return observation


def seen(env, observation):
    return dict(zip(env.observation_names, observation))


class EnvTest(FolderTest):
    def test_a_step_is_one_control_period(self):
        env = cas.env.Env(pose=HIGH)
        fly(env, [0, 0, 0, 0], 500)
        self.assertAlmostEqual(env.time_s, 1.0)
        fly(env, [0, 0, 0, 0], 1)
        self.assertAlmostEqual(env.time_s, 0.002)

    def test_the_same_seed_and_actions_give_the_same_bytes(self):
        vary = [{"name": "mass", "key": "faults[payload].mass_factor",
                 "normal": {"mean": 1, "deviation": 0.1, "least": 0.7}}]
        env = cas.env.Env(action_level="rates", observe="sensors", sensors="table1", pose=HIGH, vary=vary,
                          wind={"mean_m_s": 3, "from_deg": 90, "turbulence": "light"},
                          faults=[{"name": "payload", "at_s": 0, "mass_factor": 1}])
        first, other, again = (fly(env, [0.1, 0, 0, 0.6], 500, seed).tobytes() for seed in (7, 8, 7))
        self.assertEqual(first, again)
        self.assertNotEqual(first, other)

    def test_motors_are_driven_as_they_are(self):
        env = cas.env.Env(action_level="motors", pose=HIGH)
        self.assertEqual(env.action_names, ["motor1", "motor2", "motor3", "motor4"])
        self.assertEqual(env.action_limits, [(0.0, 1.0)] * 4)
        rising = seen(env, fly(env, [1, 1, 1, 1], 500))
        self.assertLess(rising["velocity_down_m_s"], -2)
        self.assertGreater(rising["rotor1_rad_s"], 900)
        falling = seen(env, fly(env, [0, 0, 0, 0], 500))
        self.assertGreater(falling["velocity_down_m_s"], 8)

    def test_rates_are_followed(self):
        env = cas.env.Env(action_level="rates", pose=HIGH)
        after = seen(env, fly(env, [0.5, -0.4, 0.3, 0.55], 250))
        for axis, asked in (("x", 0.5), ("y", -0.4), ("z", 0.3)):
            self.assertAlmostEqual(after[f"rate_{axis}_rad_s"], asked, delta=0.1)

    def test_attitude_is_followed(self):
        env = cas.env.Env(action_level="attitude", pose={**HIGH, "yaw_deg": 90})  # nose north
        after = seen(env, fly(env, [0.1, 0, 0, 0.55], 1000))
        w, x, y, z = (after[f"q_ND_{part}"] for part in "wxyz")
        roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        self.assertAlmostEqual(roll, 0.1, delta=0.02)
        self.assertGreater(after["velocity_east_m_s"], 1)

    def test_velocity_is_followed_and_the_heading_kept(self):
        env = cas.env.Env(action_level="velocity", pose={**HIGH, "yaw_deg": 90})
        after = seen(env, fly(env, [2, -1, -0.5, 0], 2500))
        for axis, asked in (("north", 2), ("east", -1), ("down", -0.5)):
            self.assertAlmostEqual(after[f"velocity_{axis}_m_s"], asked, delta=0.2)
        self.assertAlmostEqual(abs(after["q_ND_w"]), 1, delta=0.02)

    def test_sensors_measure_with_their_noise_and_delay(self):
        def spread(sensors):
            env = cas.env.Env(observe="sensors", sensors=sensors)
            observation = env.new_observation()
            env.reset(observation)
            self.assertTrue(math.isnan(observation[0]))
            forces = []
            for _ in range(1000):
                env.step(env.new_action(), observation)
                forces.append(seen(env, observation)["force_z_m_s2"])
            self.assertAlmostEqual(sum(forces[500:]) / 500, -9.8, delta=0.2)
            return max(forces[500:]) - min(forces[500:]), seen(env, observation)["gps_age_s"]

        noisy, _ = spread("table1")
        quiet, _ = spread("ideal")
        self.assertGreater(noisy, 10 * quiet)
        _, age = spread({"preset": "ideal", "gps": {"delay_s": 0.3}})
        self.assertGreaterEqual(age, 0.3 - 1e-9)

    def test_each_seed_draws_what_varies(self):
        env = cas.env.Env(pose=HIGH, vary=[
            {"name": "thrust", "key": "vehicle.rotor.thrust_coefficient", "log": [5e-6, 7e-6]},
            {"name": "yaw", "key": "pose.yaw_deg", "values": [0, 90]}])
        drawn = []
        for seed in range(1, 9):
            env.reset(env.new_observation(), seed)
            drawn.append(env.drawn)
        self.assertEqual({each["yaw"] for each in drawn}, {"0", "90"})
        self.assertEqual(len({each["thrust"] for each in drawn}), 8)
        self.assertTrue(all(5e-6 <= float(each["thrust"]) <= 7e-6 for each in drawn))
        speeds = [seen(env, fly(env, [0.6] * 4, 200, seed))["velocity_down_m_s"] for seed in (1, 2)]
        stronger = 0 if float(drawn[0]["thrust"]) > float(drawn[1]["thrust"]) else 1
        self.assertLess(speeds[stronger], speeds[1 - stronger])

    def test_a_reset_without_a_seed_takes_the_next(self):
        env = cas.env.Env(observe="sensors", sensors="table1")
        observation, action, ends = env.new_observation(), env.new_action(), []
        for seed in (5, None, 6):
            env.reset(observation, seed)
            for _ in range(10):
                env.step(action, observation)
            ends.append(observation.tobytes())
        self.assertEqual(ends[1], ends[2])
        self.assertNotEqual(ends[0], ends[1])

    def test_single_precision_is_taken_and_given(self):
        env = cas.env.Env(action_level="velocity", pose=HIGH)
        single = array.array("f", bytes(4 * len(env.observation_names)))
        env.reset(single, 1)
        env.step(array.array("f", [0, 0, 0, 0]), single)
        self.assertAlmostEqual(seen(env, single)["position_down_m"], -100, delta=0.5)

    def test_contact_is_told(self):
        env = cas.env.Env()
        fly(env, [0, 0, 0, 0], 500)
        self.assertTrue(env.in_contact)
        env.close()
        high = cas.env.Env(pose=HIGH)
        fly(high, [0, 0, 0, 0], 5)
        self.assertFalse(high.in_contact)

    def test_what_does_not_fit_is_refused_in_words(self):
        env = cas.env.Env()
        action, observation = env.new_action(), env.new_observation()
        for call, words in (
                (lambda: env.step(action, observation), "there is no episode"),
                (lambda: env.reset(array.array("d", [0])), "the observation has"),
                (lambda: env.reset(array.array("i", [0])), "float64 or float32"),
                (lambda: cas.env.Env(action_level="wheels"), "action_level is motors, rates"),
                (lambda: cas.env.Env(observe="stars"), "observe is truth"),
                (lambda: cas.env.Env(period_us=1500), "no multiple"),
                (lambda: cas.env.Env(vehicle="vehicles/none.yaml"), "none.yaml"),
                (lambda: cas.env.Env(action_level="rates", params={"NO_SUCH": 1}), "no parameter NO_SUCH"),
                (lambda: cas.env.Env(vary=[{"key": "line.packet_loss", "uniform": [0, 1]}]), "line"),
                (lambda: cas.env.Env(vary=[{"key": "pose.yaw_deg", "uniform": [1]}]), "uniform")):
            with self.assertRaisesRegex(cas.CasError, words):
                call()
        env.reset(observation)
        with self.assertRaisesRegex(cas.CasError, "the action has 4 numbers, not 3"):
            env.step(array.array("d", [0, 0, 0]), observation)
        with self.assertRaises((BufferError, TypeError)):
            env.step(action, bytes(observation))

    def test_without_the_extension_it_says_what_to_install(self):
        with mock.patch.dict(sys.modules, {"_cas_env": None}), mock.patch.dict("os.environ", {"CAS_BIN": "/nowhere"}):
            del sys.modules["_cas_env"]
            with mock.patch("importlib.import_module", side_effect=ImportError("none")):
                with self.assertRaisesRegex(cas.ProgramMissing, "python3-cas-env"):
                    cas.env.Env()


    def test_a_build_tree_without_the_extension_is_told_of(self):
        (self.folder / "bin").mkdir()
        (self.folder / "CMakeCache.txt").write_text("")
        with mock.patch.dict(sys.modules), mock.patch.dict("os.environ", {"CAS_BIN": str(self.folder / "bin")}):
            sys.modules.pop("_cas_env", None)
            with self.assertRaisesRegex(cas.ProgramMissing, "there is no .*/lib/_cas_env.cpython"):
                cas.env.Env()
            suffix = importlib.machinery.EXTENSION_SUFFIXES[0]
            (self.folder / "lib").mkdir()
            (self.folder / "lib" / f"_cas_env{suffix}").write_text("no library")
            with self.assertRaisesRegex(cas.ProgramMissing, "python3-cas-env"):
                cas.env.Env()


class StandInEnv:
    """gymnasium.Env as its documentation has it: reset() seeds np_random."""

    _random = None

    @property
    def np_random(self):
        if self._random is None:
            self._random = numpy.random.default_rng()
        return self._random

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            self._random = numpy.random.default_rng(seed)


class StandInBox:
    """gymnasium.spaces.Box: bounds, shape and type."""

    def __init__(self, low, high, dtype):
        assert low.shape == high.shape and low.dtype == high.dtype == dtype and (low <= high).all()
        self.low, self.high, self.shape, self.dtype = low, high, low.shape, dtype

    def contains(self, x):
        return x.shape == self.shape and x.dtype == self.dtype and bool(((self.low <= x) & (x <= self.high)).all())


@unittest.skipIf(numpy is None, "NumPy is not installed")
class GymnasiumTest(FolderTest):
    def setUp(self):
        super().setUp()
        stand_in = types.SimpleNamespace(Env=StandInEnv, spaces=types.SimpleNamespace(Box=StandInBox))
        patch = mock.patch.dict(sys.modules, {"gymnasium": stand_in})
        patch.start()
        self.addCleanup(patch.stop)

    def make(self, **more):
        env = cas.env.Env(action_level="velocity", pose={"z_m": 10}, observe="truth",
                          vary=[{"key": "pose.x_m", "uniform": [-5, 5]}])
        made = cas.env.gymnasium_env(env, reward=lambda seen, action: -abs(seen[2] + 10), **more)
        self.addCleanup(made.close)
        return made

    def test_spaces_hold_what_reset_and_step_give(self):
        env = self.make()
        observation, info = env.reset(seed=3)
        self.assertTrue(env.observation_space.contains(observation))
        self.assertIn("pose.x_m", info["drawn"])
        self.assertEqual(env.action_space.shape, (4,))
        result = env.step(numpy.zeros(4, dtype=numpy.float32))
        self.assertEqual(len(result), 5)
        later, reward, terminated, truncated, info = result
        self.assertTrue(env.observation_space.contains(later))
        self.assertIsNot(later, observation)
        self.assertEqual([type(each) for each in (reward, terminated, truncated)], [float, bool, bool])
        self.assertIsInstance(info, dict)

    def test_what_no_sensor_has_measured_yet_is_0(self):
        inner = cas.env.Env(observe="sensors", sensors="table1")
        env = cas.env.gymnasium_env(inner, reward=lambda seen, action: float(seen.sum()))
        self.addCleanup(env.close)
        observation, _ = env.reset(seed=1)
        self.assertTrue(env.observation_space.contains(observation))
        self.assertFalse(observation.any())
        later, reward = env.step(numpy.zeros(4))[:2]
        self.assertTrue(env.observation_space.contains(later))
        self.assertTrue(math.isfinite(reward))

    def test_a_seed_repeats_its_episode_and_all_that_follow(self):
        env = self.make()

        def episodes(seed):
            starts = [env.reset(seed=seed)[0]] + [env.reset()[0] for _ in range(3)]
            return [float(each[1]) for each in starts]

        first = episodes(11)
        self.assertEqual(first, episodes(11))
        self.assertEqual(len(set(first)), 4)

    def test_an_episode_ends_by_its_condition_or_its_time(self):
        env = self.make(terminated=lambda seen: seen[2] < -10.5, longest_s=2.0)
        env.reset(seed=1)
        ends = (False, False)
        while not any(ends):
            ends = env.step(numpy.array([0, 0, 0, 0.0]))[2:4]
        self.assertEqual(ends, (False, True))
        env.reset(seed=1)
        ends = (False, False)
        while not any(ends):
            ends = env.step(numpy.array([0, 0, -2, 0.0]))[2:4]
        self.assertEqual(ends, (True, False))


if __name__ == "__main__":
    unittest.main()
