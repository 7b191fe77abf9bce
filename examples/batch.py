"""A thousand launches with other masses and grades: how the figures spread, and which launch is the worst."""

from __future__ import annotations

from collections import Counter

import numpy as np

import bitepoint

LANES = 1000


def main() -> None:
    """Vary mass and grade, print the distribution, and run the worst launch again on its own."""
    rng = np.random.default_rng(seed=1)
    over = {
        "vehicle.mass": rng.uniform(1400.0, 2000.0, LANES),
        "road.grade": rng.uniform(0.0, 0.2, LANES),
    }
    batch = bitepoint.run_batch("dct-launch", over)

    for status, count in Counter(batch.status).items():
        print(f"{status}: {count} of {LANES}")
    print(f"{'':<18} {'5 %':>8} {'median':>8} {'95 %':>8}")
    for name in ("launch_time", "friction_work", "jerk_peak", "jerk_peak_settled"):
        low, middle, high = np.nanpercentile(batch.metrics[name], [5, 50, 95])
        print(f"{name:<18} {low:8.3g} {middle:8.3g} {high:8.3g}  {batch.units[name]}")

    worst = int(np.nanargmax(batch.metrics["friction_work"]))
    settings = {key: values[worst] for key, values in over.items()}
    again = bitepoint.run("dct-launch", settings)
    print(f"most heat: lane {worst}, {settings['vehicle.mass']:.0f} kg on {100 * settings['road.grade']:.1f} %")
    print(f"  in the batch  {batch.metrics['friction_work'][worst]:.3f} J")
    print(f"  on its own    {again.metrics['friction_work'].value:.3f} J")


if __name__ == "__main__":
    main()
