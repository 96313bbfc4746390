# SPDX-License-Identifier: BSD-3-Clause
import math
import threading

import cas

MASS_KG, GRAVITY_M_S2, HEIGHT_M = 1.55, 9.80665, 2.0
U1_MAX_N, U2_MAX_NM, U4_MAX_NM = 28.2656, 2.74818465, 0.847968  # full deflection of HIL_CONTROLS
IXX_KG_M2, IZZ_KG_M2 = 0.03, 0.057


class Hover:
    """Gyro for attitude, barometer and accelerometer for height, GPS for velocity: good for a minute."""

    def __init__(self):
        self.last_us, self.ground_m = None, None
        self.roll = self.pitch = self.yaw = self.up = self.climb = self.north = self.east = 0.0

    def on_gps(self, gps):  # HIL_GPS: cm/s
        self.north += 0.3 * (gps.vn / 100 - self.north)
        self.east += 0.3 * (gps.ve / 100 - self.east)

    def on_sensor(self, s):  # HIL_SENSOR: rad/s, m/s^2, m; axes forward, right, down
        dt = 0.0 if self.last_us is None else (s.time_usec - self.last_us) * 1e-6
        self.last_us = s.time_usec
        self.roll += dt * (s.xgyro + math.tan(self.pitch) * (s.ygyro * self.roll + s.zgyro))
        self.pitch += dt * (s.ygyro - s.zgyro * self.roll)
        self.yaw += dt * s.zgyro
        self.north -= dt * GRAVITY_M_S2 * self.pitch
        self.east += dt * GRAVITY_M_S2 * self.roll
        if s.fields_updated & 0x800:  # pressure altitude
            self.ground_m = s.pressure_alt if self.ground_m is None else self.ground_m
            self.up += 0.05 * (s.pressure_alt - self.ground_m - self.up)
            self.climb += 0.06 * (s.pressure_alt - self.ground_m - self.up)
        lift = -s.zacc * math.cos(self.roll) * math.cos(self.pitch)
        self.climb += dt * (lift - GRAVITY_M_S2)
        self.up += dt * self.climb
        return self.controls(s)

    def controls(self, s):
        def tilt(speed):  # against the speed, rad
            return max(-0.15, min(0.15, 0.08 * speed))

        thrust_n = MASS_KG * (GRAVITY_M_S2 + 2.0 * (HEIGHT_M - self.up) - 2.5 * self.climb)
        roll_nm = IXX_KG_M2 * (60 * (tilt(-self.east) - self.roll) - 12 * s.xgyro)
        pitch_nm = IXX_KG_M2 * (60 * (tilt(self.north) - self.pitch) - 12 * s.ygyro)
        yaw_nm = IZZ_KG_M2 * (4 * -self.yaw - 4 * s.zgyro)
        return {"time_usec": s.time_usec, "throttle": max(0.0, min(1.0, thrust_n / U1_MAX_N)),
                "roll_ailerons": roll_nm / U2_MAX_NM, "pitch_elevator": pitch_nm / U2_MAX_NM,
                "yaw_rudder": yaw_nm / U4_MAX_NM, "mode": 128 + 32}  # armed, in HIL


def fly(link):
    """Answers each HIL_SENSOR with HIL_CONTROLS that carry its stamp: lockstep waits for them."""
    hover = Hover()
    for message in link:
        if message.name == "HIL_GPS":
            hover.on_gps(message)
        elif message.name == "HIL_SENSOR":
            link.send("HIL_CONTROLS", **hover.on_sensor(message))


with cas.Bench(controller=False, sensors="ideal") as bench, \
        cas.mavlink.UdpLink(bench.controller_address, system=1, component=1) as link:
    link.send("HEARTBEAT", type=2, autopilot=12, base_mode=128 + 32, system_status=4, mavlink_version=3)
    bench.wait_for_vehicle()
    threading.Thread(target=fly, args=(link,), daemon=True).start()
    for _ in range(15):
        bench.run_for(1.0)
        pose = bench.sim.pose()
        print(f"{pose.time_s:4.1f} s  up {pose.up_m:5.2f} m  north {pose.north_m:5.2f} m  east {pose.east_m:5.2f} m")
    assert abs(pose.up_m - HEIGHT_M) < 0.3 and abs(pose.north_m) < 1 and abs(pose.east_m) < 1
