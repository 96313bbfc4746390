# SPDX-License-Identifier: BSD-3-Clause
import cas

CORNERS = [(4, 0), (4, 4), (0, 4), (0, 0)]  # north, east, m

with cas.Bench(sensors="table1", seed=3) as bench:
    errors = []

    def look():
        truth, estimate = bench.sim.pose(), bench.estimate()
        errors.append((truth.north_m - estimate.north_m, truth.east_m - estimate.east_m))

    bench.arm()
    bench.takeoff(2.5)
    start, origin = bench.sim.pose(), bench.estimate()
    for north_m, east_m in CORNERS:
        bench.casd.vehicle.goto(north_m, east_m, -2.5)
        for _ in range(120):  # 6 s
            bench.run_for(0.05)
            look()
        truth = bench.sim.pose()
        print(f"at {truth.north_m:6.2f} {truth.east_m:6.2f}, asked for {north_m} {east_m}")
        assert abs(truth.north_m - north_m) < 1.0 and abs(truth.east_m - east_m) < 1.0
    bench.land()

north, east = (cas.rms(values) for values in zip(*errors))
print(f"the estimate is wrong by {north:.2f} m north and {east:.2f} m east (RMS of {len(errors)} looks)")
assert north < 0.5 and east < 0.5
