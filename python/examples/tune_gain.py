# SPDX-License-Identifier: BSD-3-Clause
import cas


def jump_of_3_m(gain):
    return {"schema": 1, "name": "jump", "vehicle": "vehicles/iris_paper.yaml",
            "home": {"lat_deg": 47.397742, "lon_deg": 8.545594, "alt_m": 488.0},
            "rates": {"sensor_hz": 500, "gps_hz": 5, "controls_hz": 400},
            "controller": {"params": {"MPC_XY_P": gain}},
            "steps": ["arm", {"takeoff": {"altitude_m": 5}}, {"hold": {"duration_s": 5}},
                      {"trajectory": {"name": "jump", "shape": "step", "size_m": 3,
                                      "duration_s": 20, "measure": True}}, "land"]}


responses = {}
for gain in (0.6, 1.0, 1.5, 2.5):
    run = cas.run(jump_of_3_m(gain), f"out/gain_{gain}", architecture="direct")
    responses[gain] = run.vehicle()["responses"][0]

columns = ("rise_s", "overshoot_pct", "settling_s", "integrated_error_m_s")
print(cas.text_table(("gain", *columns), [(gain, *(each[key] for key in columns))
                                          for gain, each in responses.items()]))
_, best = min((each["settling_s"], gain) for gain, each in responses.items())
print(f"MPC_XY_P {best} settles first")
