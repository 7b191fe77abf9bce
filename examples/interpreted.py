"""Step through a kernel: in its interpreted life it is ordinary Python, with the lines of its own file.

A debugger does the same as the tracer below: set a breakpoint in the kernel's file and run it with
life="interpreted". The result has the same bits as that of the compiled life.
"""

from __future__ import annotations

import linecache
import sys
from types import FrameType
from typing import Any

from bitepoint.assembly import assemble
from bitepoint.parts.engine import throttle_for


def print_line(frame: FrameType, event: str, argument: Any) -> Any:  # noqa: ARG001 - the signature of a tracer
    """Print each line of throttle_for before it runs, and the numbers that its locals have by then."""
    if frame.f_code.co_name != throttle_for.name:
        return None
    if event == "line":
        numbers = {name: value for name, value in frame.f_locals.items() if isinstance(value, float)}
        print(linecache.getline(frame.f_code.co_filename, frame.f_lineno).strip())
        print("   ", ", ".join(f"{name} {value:.4g}" for name, value in numbers.items()))
    return print_line


def main() -> None:
    """Find the throttle at which the library engine gives 120 N m at 1500 rpm, line by line."""
    engine = assemble("dct-launch", {}).system.plant.parameters["engine"].copy()
    before = sys.gettrace()
    sys.settrace(print_line)
    slow = throttle_for.run(engine, 120.0, 157.08, life="interpreted")
    sys.settrace(before)
    fast = throttle_for.run(engine, 120.0, 157.08, life="compiled")
    print(f"throttle {slow[0]:.1%}, the same bits in both lives: {slow[0] == fast[0]}")


if __name__ == "__main__":
    main()
