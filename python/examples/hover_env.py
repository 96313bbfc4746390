# SPDX-License-Identifier: BSD-3-Clause
import time

import cas.env

env = cas.env.Env(action_level="attitude", pose={"z_m": 10}, sensors="table1",
                  faults=[{"name": "payload", "at_s": 0, "mass_factor": 1.0}],
                  vary=[{"name": "mass", "key": "faults[payload].mass_factor", "uniform": [0.8, 1.3]}])
action, observation = env.new_action(), env.new_observation()
down, sinking = (env.observation_names.index(name) for name in ("position_down_m", "velocity_down_m_s"))

for seed in (1, 2, 3):
    env.reset(observation, seed)
    height_m, learnt, begin = -observation[down], 0.55, time.perf_counter()
    for _ in range(10_000):  # 20 s
        error_m = height_m + observation[down]
        learnt += 2e-5 * (error_m + observation[sinking])
        action[3] = max(0.0, min(1.0, learnt + 0.05 * error_m + 0.05 * observation[sinking]))  # of full thrust
        env.step(action, observation)
    pace = 10_000 / (time.perf_counter() - begin)
    print(f"seed {seed}: mass x {env.drawn['mass']}, thrust {action[3]:.2f}, "
          f"{height_m + observation[down]:+.3f} m from its height, {pace:,.0f} steps/s")
    assert abs(height_m + observation[down]) < 0.3
