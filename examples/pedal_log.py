"""A launch that follows a logged pedal: cut the interesting part out of a CSV and run it."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import bitepoint


def write_log(path: Path) -> None:
    """Write a log as a car would give it: 50 Hz, percent, a sensor that rests at 4 %, time since ignition."""
    time = np.arange(310.0, 320.0, 0.02)
    pedal = np.interp(time, [312.0, 312.3, 313.0, 314.0, 315.5], [4.0, 16.0, 22.0, 30.0, 30.0])
    rows = [f"{t:.2f},{p:.1f},0" for t, p in zip(time, pedal, strict=True)]
    path.write_text("\n".join(["time,accelerator,brake", *rows, ""]), encoding="utf-8")


def main() -> None:
    """Run the launch that the log holds, and the one that the scenario's own pedal gives."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log.csv"
        write_log(log)
        logged = bitepoint.run(
            "dct-launch",
            pedal=log,
            pedal__column="accelerator",
            pedal__rest="4 %",
            pedal__start="311.8 s",
            pedal__end="316 s",
        )
    for name, result in (("logged pedal", logged), ("intent normal", bitepoint.run("dct-launch"))):
        highest = result.recording["pedal"].max()
        print(f"{name:<14} pedal to {highest:.1%}, {result.status}", end="")
        print(f", {result.metrics['launch_time']}, {result.metrics['friction_work']}")


if __name__ == "__main__":
    main()
