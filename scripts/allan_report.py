#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Records an IMU at rest for an hour of simulated time and compares its Allan deviation with its figures.

Usage: allan_report.py [--hilsim FILE] [--presets NAME ...] [--output FOLDER] [--hours H]

Writes FOLDER/allan.png and prints a table in Markdown. Needs numpy and matplotlib (Debian:
python3-matplotlib). The IMU runs at 100 Hz: a density does not depend on the rate.
"""

import argparse
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy

from steps import Steps

PROJECT = pathlib.Path(__file__).resolve().parents[1]
RATE_HZ = 100
CONFIG = """schema: 1
world: {{gravity_m_s2: 9.80665, ground: true}}
home: {{lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}}
decimal_year: 2026.5
pace: free_run
vehicles:
  - name: iris0
    vehicle: vehicles/iris_paper.yaml
    sensors: {{preset: {preset}, imu: {{rate_hz: {rate}}}}}
    plugins:
      - {{plugin: imu}}
      - {{plugin: recorder, file: truth.csv, rate_hz: 1, sensor_dir: sensors}}
"""
# column, name of the figure in the preset, unit, from SI to that unit
TRIADS = (
    ("gyro_x_rad_s", "gyro", "deg_s", 180.0 / math.pi),
    ("accel_x_m_s2", "accel", "m_s2", 1.0),
)


def record(hilsim, preset, hours, folder):
    config = folder / "rest.yaml"
    config.write_text(CONFIG.format(preset=preset, rate=RATE_HZ), encoding="utf-8")
    command = [hilsim, config, "--duration", str(hours * 3600), "--output", folder,
               "--log-level", "warn"]
    subprocess.run([str(part) for part in command], check=True)
    file = folder / "sensors" / "imu.csv"
    with open(file, encoding="ascii") as stream:
        names = stream.readline().strip().split(",")
    return dict(zip(names, numpy.loadtxt(file, delimiter=",", skiprows=1, unpack=True)))


def allan_deviation(samples, taus):
    """Overlapping Allan deviation at averaging times in seconds."""
    integral = numpy.concatenate(([0.0], numpy.cumsum(samples))) / RATE_HZ
    deviations = []
    for tau in taus:
        m = int(round(tau * RATE_HZ))
        difference = integral[2 * m:] - 2 * integral[m:-m] + integral[:-2 * m]
        deviations.append(math.sqrt(numpy.mean(difference ** 2) / (2 * tau ** 2)))
    return numpy.array(deviations)


def figures_of(preset, name, unit):
    """Density (with the share of rounding), drift deviation and its time constant, by the preset file."""
    text = (PROJECT / "config" / "sensors" / f"{preset}.yaml").read_text(encoding="utf-8")

    def number(key):
        match = re.search(rf"\b{key}: *\[?([0-9.e+-]+)", text)
        return float(match.group(1)) if match else None

    density = number(f"{name}_density_{unit}_per_sqrt_hz")
    stddev = number(f"{name}_stddev_{unit}")
    if density is None:  # per sample, so a density only at the rate of this record
        density = stddev / math.sqrt(RATE_HZ)
    lsb = number(f"{name}_lsb_{unit}") or 0.0
    density = math.hypot(density, lsb / math.sqrt(12 * RATE_HZ))
    drift, tau = number(f"{name}_drift_stddev_{unit}"), number(f"{name}_drift_time_constant_s")
    walk = number(f"{name}_bias_walk_{unit}_per_sqrt_s")
    if walk is not None:
        tau = number(f"{name}_bias_time_constant_s")
        drift = walk * math.sqrt(tau / 2)
    return {"density": density, "drift": drift or 0.0, "tau": tau or 1.0}


def expected_deviation(figures, tau):
    """White noise and a Gauss-Markov drift (IEEE Std 952, Annex C)."""
    t = tau / figures["tau"]
    # 2 t - 3 + 4 e^-t - e^-2t, by series where it cancels
    shape = numpy.where(t < 1e-3, 2.0 / 3.0 * t ** 3, 2 * t - 3 + 4 * numpy.exp(-t) - numpy.exp(-2 * t))
    drift = figures["drift"] ** 2 / t ** 2 * shape
    return numpy.sqrt(figures["density"] ** 2 / tau + drift)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--hilsim", type=pathlib.Path, default=PROJECT / "build/release/bin/hilsim")
    parser.add_argument("--presets", nargs="+",
                        default=["table1", "gazebo_classic", "rotors_adis16448", "pixhawk"])
    parser.add_argument("--output", type=pathlib.Path, default=PROJECT / "docs/develop/results")
    parser.add_argument("--hours", type=float, default=1.0)
    arguments = parser.parse_args()
    try:
        import matplotlib
    except ImportError:
        sys.exit("allan_report.py: matplotlib is missing (Debian: apt-get install python3-matplotlib)")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    taus = numpy.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500])
    taus = taus[taus <= arguments.hours * 3600 / 6]
    figure, axes = plt.subplots(1, 2, figsize=(13, 5))
    print("| set | sensor | density, configured | measured at 1 s | error |\n|---|---|---|---|---|")
    steps = Steps("allan_report", len(arguments.presets))
    for colour, preset in enumerate(arguments.presets):
        steps.next(f"{preset}, {arguments.hours:g} h of simulated time")
        with tempfile.TemporaryDirectory() as folder:
            columns = record(arguments.hilsim, preset, arguments.hours, pathlib.Path(folder))
        steps.clear()
        for panel, (column, name, unit, factor) in zip(axes, TRIADS):
            figures = figures_of(preset, name, unit)
            measured = allan_deviation(columns[column] * factor, taus)
            panel.loglog(taus, measured, "o", markersize=4, color=f"C{colour}", label=preset)
            panel.loglog(taus, expected_deviation(figures, taus), linewidth=1, color=f"C{colour}")
            panel.set_title(f"{name} x")
            panel.set_ylabel(f"Allan deviation [{unit.replace('_', '/', 1)}]")
            at_1s = measured[list(taus).index(1)]
            expected = float(expected_deviation(figures, numpy.array([1.0]))[0])
            print(f"| {preset} | {name} x | {expected:.4g} {unit}/sqrt(Hz) | {at_1s:.4g} | "
                  f"{100 * (at_1s / expected - 1):+.1f} % |")
    for panel in axes:
        panel.set_xlabel("averaging time [s]")
        panel.grid(True, which="both", alpha=0.3)
        panel.legend(fontsize="small")
    arguments.output.mkdir(parents=True, exist_ok=True)
    figure.suptitle("An hour at rest: measured (dots) and configured (lines)")
    figure.tight_layout()
    figure.savefig(arguments.output / "allan.png", dpi=90)


if __name__ == "__main__":
    main()
