"""What can go wrong, as types: every message says what, where, and the mend in one line."""

from __future__ import annotations

import reprlib

_BRIEF = reprlib.Repr()
_BRIEF.maxlevel, _BRIEF.maxlist, _BRIEF.maxtuple, _BRIEF.maxdict = 1, 3, 3, 3
_BRIEF.maxstring = _BRIEF.maxother = _BRIEF.maxlong = 40


def brief(value: object) -> str:
    """Return a value as an error names it: one line of bounded length, whatever was read."""
    if value is None:
        return "nothing"
    text = " ".join(_BRIEF.repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


class BitepointError(Exception):
    """Base of all errors that Bitepoint raises on purpose."""


class InputError(BitepointError):
    """Bad input from outside: a file, an option or an argument. The command line exits with status 2."""

    def __init__(self, where: str, problem: str, mend: str) -> None:
        self.where = where
        self.problem = problem
        self.mend = mend
        super().__init__(" ".join(f"{where}: {problem}; {mend}".split()))


class SubsetError(BitepointError):
    """A kernel uses Python outside the subset that all of its lives share."""

    def __init__(self, file: str, line: int, problem: str, mend: str) -> None:
        self.file = file
        self.line = line
        super().__init__(f"{file}:{line}: {problem}; {mend}")


class WiringError(BitepointError):
    """Two parts cannot be put together: a signal is missing or its units differ."""
