# SPDX-License-Identifier: BSD-3-Clause
import cas


def hover(loss):
    fault = {"when": "phase == lossy", "for_s": 20, "line": {"packet_loss": loss}}
    return {"schema": 1, "name": "hover", "vehicle": "vehicles/iris_paper.yaml",
            "home": {"lat_deg": 47.397742, "lon_deg": 8.545594, "alt_m": 488.0},
            "rates": {"sensor_hz": 500, "gps_hz": 5, "controls_hz": 400},
            "line": {"preset": "baud_921600"}, "faults": [fault] if loss else [],
            "steps": ["arm", {"takeoff": {"altitude_m": 2.5}}, {"hold": {"duration_s": 5}},
                      {"hold": {"name": "lossy", "duration_s": 20, "measure": True}}, "land"]}


rows = []
for percent in (0, 5, 20, 40):
    run = cas.run(hover(percent / 100), f"out/loss_{percent}", virtual=True)
    own = run.vehicle()
    sensors, rms = own["rates"]["HIL_SENSOR"], own["rms"]
    rows.append((percent, 100 * sensors["lost"] / sensors["sent"], rms["x_m"], rms["z_m"]))

print(cas.text_table(("asked %", "lost %", "RMS x m", "RMS z m"), rows))
try:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    pyplot.plot([row[0] for row in rows], [row[2:] for row in rows], "o-", label=["north", "up"])
    pyplot.xlabel("packets lost, %")
    pyplot.ylabel("RMS error of the hover, m")
    pyplot.legend()
    pyplot.savefig("out/loss.png")
except ImportError:
    print("install python3-matplotlib for the picture")
