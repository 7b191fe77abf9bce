"""One launch: print its figures, look into its signals, write the recording and the picture."""

from __future__ import annotations

import numpy as np

import bitepoint


def main() -> None:
    """Run an urgent launch on a 10 % grade."""
    result = bitepoint.run("dct-launch", intent="urgent", road__grade="10 %")
    print(f"{result.status}: {result.reason}")
    for name, metric in result.metrics.items():
        print(f"  {name:<18} {metric}")

    recording = result.recording
    power = recording["clutch_torque"] * recording["slip_speed"]
    hottest = int(np.argmax(power))
    print(f"most heat in the clutch: {power[hottest] / 1000:.1f} kW at {recording.time[hottest]:.2f} s")

    for path in result.save("out/launch"):
        print(f"wrote {path}")


if __name__ == "__main__":
    main()
