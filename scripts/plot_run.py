#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws a run: position and attitude over time (as [HILS] Fig. 17), speed, rotors, track.

Usage: plot_run.py RUN [RUN ...] [--output FILE.png] [--from S] [--to S] [--sensors]

RUN is a run's folder (with truth.csv) or a CSV file of that form; several are drawn over each other.
Needs matplotlib (Debian: python3-matplotlib).
"""

import argparse
import csv
import json
import math
import pathlib
import sys

DEGREES = 180.0 / math.pi
PANELS = (
    # title, unit, columns with their names in the legend, factor
    ("Position", "m", {"x_m": "x north", "y_m": "y east", "z_m": "z up"}, 1.0),
    ("Attitude", "deg", {"roll_rad": "roll", "pitch_rad": "pitch", "yaw_rad": "yaw"}, DEGREES),
    ("Velocity", "m/s", {"vx_m_s": "north", "vy_m_s": "east", "vz_m_s": "up"}, 1.0),
    ("Rotors", "rad/s", {f"omega{i}_rad_s": str(i) for i in range(1, 5)}, 1.0),
)


def fail(sentence):
    print(f"plot_run.py: {sentence}", file=sys.stderr)
    sys.exit(2)


def read_columns(file, begin=-math.inf, end=math.inf):
    """Columns of a CSV file by name, cut to a stretch of time."""
    try:
        with open(file, newline="", encoding="ascii") as stream:
            rows = list(csv.DictReader(stream))
    except OSError as error:
        fail(f"{file}: {error.strerror}")
    if not rows:
        fail(f"{file}: holds no row")
    if "time_s" not in rows[0]:
        fail(f"{file}: has no column time_s")
    rows = [row for row in rows if begin <= float(row["time_s"]) <= end]
    if not rows:
        fail(f"{file}: has nothing between the given times")
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def truth_file(run):
    return run / "truth.csv" if run.is_dir() else run


def caption(run):
    """Name of the run, with its RMS figures where a summary stands beside it."""
    summary = run / "summary.json" if run.is_dir() else run.parent / "summary.json"
    name = run.name if run.is_dir() else run.stem
    if not summary.exists():
        return name
    with open(summary, encoding="utf-8") as stream:
        figures = json.load(stream)
    rms = figures.get("rms") or {}
    parts = [f"{axis.split('_')[0]} {value:.4f}" for axis, value in rms.items() if value is not None]
    verdict = "passed" if figures.get("passed") else "not passed"
    return f"{name} ({figures.get('architecture', '?')}, {verdict}) RMS: " + ", ".join(parts)


def draw_truth(axes, run, columns, many):
    time = columns["time_s"]
    for panel, (title, unit, names, factor) in zip(axes.flat, PANELS):
        for name, label in names.items():
            if name in columns:
                text = f"{label} {run.name}" if many else label
                panel.plot(time, [factor * value for value in columns[name]], label=text, linewidth=1)
        panel.set_title(title)
        panel.set_xlabel("time [s]")
        panel.set_ylabel(unit)
        panel.grid(True, alpha=0.3)
        panel.legend(fontsize="small")


def draw_sensors(plt, folder, begin, end):
    """One panel per recorded sensor file of `sensor_dir`."""
    files = sorted(file for file in folder.glob("*.csv") if file.stat().st_size > 200)
    if not files:
        fail(f"{folder}: holds no recorded sensor")
    figure, axes = plt.subplots(len(files), 1, figsize=(11, 2.6 * len(files)), squeeze=False)
    for panel, file in zip(axes.flat, files):
        columns = read_columns(file, begin, end)
        for name, values in columns.items():
            if name not in ("time_s", "sensor_time_s", "lat_deg", "lon_deg", "valid", "kind"):
                panel.plot(columns["time_s"], values, linewidth=0.6, label=name)
        panel.set_title(file.stem)
        panel.grid(True, alpha=0.3)
        panel.legend(fontsize="x-small", ncol=4)
    return figure


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("runs", nargs="+", type=pathlib.Path, metavar="RUN")
    parser.add_argument("--output", type=pathlib.Path, help="picture to write (default: RUN/run.png)")
    parser.add_argument("--from", dest="begin", type=float, default=-math.inf, metavar="S")
    parser.add_argument("--to", dest="end", type=float, default=math.inf, metavar="S")
    parser.add_argument("--sensors", action="store_true", help="also draw RUN/sensors/*.csv")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    try:
        import matplotlib
    except ImportError:
        fail("matplotlib is missing (Debian: apt-get install python3-matplotlib)")
    matplotlib.use("Agg")  # no display needed
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(13, 8))
    for run in arguments.runs:
        columns = read_columns(truth_file(run), arguments.begin, arguments.end)
        draw_truth(axes, run, columns, len(arguments.runs) > 1)
    figure.suptitle("\n".join(caption(run) for run in arguments.runs), fontsize="medium")
    figure.tight_layout()

    first = arguments.runs[0] if arguments.runs[0].is_dir() else arguments.runs[0].parent
    output = arguments.output or first / "run.png"
    figure.savefig(output, dpi=110)
    print(output)
    if arguments.sensors:
        sensors = draw_sensors(plt, first / "sensors", arguments.begin, arguments.end)
        sensors.tight_layout()
        sensors.savefig(output.with_name("sensors.png"), dpi=110)
        print(output.with_name("sensors.png"))


if __name__ == "__main__":
    main()
