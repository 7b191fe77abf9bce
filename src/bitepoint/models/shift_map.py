"""A shift map: when a gearbox shifts up and down, over throttle and speed, as any driver or control unit holds it."""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.numerics.tables import lookup
from bitepoint.records import Curve, Record, RecordElements, count, curve, nested

_THROTTLE = ("throttle", "1", 0.0, 1.0)


class ShiftLine(Record):
    """Between a gear and the next."""

    up: Curve = curve(_THROTTLE, ("speed", "m/s", 0, 150), "vehicle speed above which it shifts up")
    down: Curve = curve(_THROTTLE, ("speed", "m/s", 0, 150), "vehicle speed below which it shifts down again")


class ShiftMap(Record):
    """All lines."""

    gears: int = count(1, 8, "forward gears")
    line: RecordElements[ShiftLine] = nested(ShiftLine, "from 1st to 2nd gear, from 2nd to 3rd, ...", shape=(7,))


@kernel
def mapped_gear(m: ShiftMap, gear: int, throttle: float, speed: float) -> int:
    """Return the gear, 1..8, that follows on `gear` at a throttle (0..1) and a vehicle speed (m/s): one up or down."""
    now = max(min(gear, 8), 1)
    wanted = now
    above = min(now - 1, 6)
    below = max(now - 2, 0)
    # never: shifts up, in the vectors of a driver without a shift map
    if now < m.gears and speed > lookup(m.line[above].up, throttle):
        wanted = now + 1
    # never: shifts down, likewise
    elif now > 1 and speed < lookup(m.line[below].down, throttle):
        wanted = now - 1
    return wanted
