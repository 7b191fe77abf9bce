"""A shift map: when a gearbox shifts up and down, over throttle and speed, as any driver or control unit holds it."""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.numerics.tables import lookup
from bitepoint.recording import Floats
from bitepoint.records import Curve, Record, RecordArray, RecordElements, count, curve, nested

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
    # never: in the highest gear, in the vectors of a driver who follows a plan
    if now < m.gears and speed > lookup(m.line[above].up, throttle):
        wanted = now + 1
    # never: fast enough for the gear, likewise
    elif now > 1 and speed < lookup(m.line[below].down, throttle):
        wanted = now - 1
    return wanted


def shift_map(throttle: Floats, up: Floats, down: Floats) -> RecordArray:
    """Return a shift map, shape (1,), from lines over throttle.

    Args:
        throttle: 0..1, rising, shape (n,); up, down: vehicle speed, m/s, shape (gears - 1, n).
    """
    result = ShiftMap.zeros()
    result["gears"] = len(up) + 1
    for n, lines in enumerate(zip(up, down, strict=True)):
        for name, line in zip(("up", "down"), lines, strict=True):
            result["line"][name][0, n] = Curve.through(throttle.tolist(), line.tolist())[0]
    return result


def with_shift_map(parameters: RecordArray, shift_map: RecordArray) -> RecordArray:
    """Return the parameters of a driver who has a shift map, and follows it where the calibration says so."""
    changed = parameters.copy()
    changed["shift_map"] = shift_map
    return changed
