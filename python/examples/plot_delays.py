# SPDX-License-Identifier: BSD-3-Clause
import cas

hover = {"schema": 1, "name": "hover", "vehicle": "vehicles/iris_paper.yaml",
         "home": {"lat_deg": 47.397742, "lon_deg": 8.545594, "alt_m": 488.0},
         "rates": {"sensor_hz": 500, "gps_hz": 5, "controls_hz": 400},
         "line": {"preset": "baud_921600"},
         "steps": ["arm", {"takeoff": {"altitude_m": 2.5}}, {"hold": {"duration_s": 10, "measure": True}}, "land"]}
cas.run(hover, "out/delays", virtual=True)

log = cas.read("out/delays/flight.tlog")
delays = cas.control_delays(log)  # of each HIL_CONTROLS: from its sensor's stamp to casd
rows = [(f"{share:.0%}", cas.quantile(delays["delay_us"], share)) for share in (0.5, 0.9, 0.99, 1.0)]
print(cas.text_table(("of the controls", "within us"), rows))
assert 500 < rows[0][1] < 20000
try:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    pyplot.plot(delays["time_s"], delays["delay_us"], ".", markersize=1)
    pyplot.xlabel("time, s")
    pyplot.ylabel("sensor to control at casd, us")
    pyplot.savefig("out/delays.png")
except ImportError:
    print("install python3-matplotlib for the picture")
