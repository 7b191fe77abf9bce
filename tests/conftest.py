"""Fixtures that tests in several rooms share."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from bitepoint import api
from bitepoint.cli import main
from bitepoint.errors import InputError
from bitepoint.export.c import toolchain

# the first example of a test may have to compile; every run tries the same examples, so that a failure comes back
settings.register_profile("bitepoint", deadline=None, derandomize=True)
settings.load_profile("bitepoint")

REPOSITORY = Path(__file__).parents[1]


def needs(*programs: str, packages: str) -> pytest.MarkDecorator:
    """Skip a test, saying what to install, where a program is not on the path."""
    missing = [program for program in programs if shutil.which(program) is None]
    return pytest.mark.skipif(bool(missing), reason=f"no {', '.join(missing)}: install Debian's {packages}")


needs_c = needs("gcc", packages="gcc")


def needs_target(test: Any) -> Any:
    """Mark a test as processor in the loop; it is skipped where the tool chain is missing."""
    return pytest.mark.pil(needs("make", toolchain.CROSS, toolchain.EMULATOR, packages=toolchain.PACKAGES)(test))


OTHER_LIVES = [pytest.param("interpreted"), pytest.param("c", marks=needs_c)]
"""The lives that are held to the compiled one."""


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of measured data."""
    named = os.environ.get("BITEPOINT_DATA")
    folder = Path(named).absolute() if named else REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("no measured data: neither $BITEPOINT_DATA nor ../shared/data is a folder")
    return folder


def names_in(folder: Path) -> list[str]:
    """The names of all that is in a folder, sorted."""
    return sorted(path.name for path in folder.iterdir())


Refused = Callable[..., str]


@pytest.fixture(scope="session")
def refused() -> Refused:
    """Check that a call raises InputError, whose message is one line that has all the given parts; return it."""

    def check(call: Callable[[], Any], *parts: str) -> str:
        with pytest.raises(InputError) as caught:
            call()
        message = str(caught.value)
        assert len(message.splitlines()) == 1
        missing = [part for part in parts if part not in message]
        assert not missing, f"{missing} not in: {message}"
        return message

    return check


@dataclass(frozen=True)
class Outcome:
    """How a command ended and what it printed."""

    status: int
    out: str
    err: str

    def refusal(self, *parts: str) -> str:
        """Check that bad input was refused: status 2, nothing on stdout, one line on stderr that has the parts."""
        assert (self.status, self.out) == (2, ""), self
        assert self.err.startswith("error: "), self.err
        assert self.err.endswith("\n"), self.err
        assert len(self.err.splitlines()) == 1, self.err
        missing = [part for part in parts if part not in self.err]
        assert not missing, f"{missing} not in: {self.err}"
        return self.err


Command = Callable[..., Outcome]


@pytest.fixture(scope="session")
def ready_kernels() -> None:
    """Compile what launches need, so that no later run announces it on stderr."""
    for controller in ("launch_pid", "none", "excitation"):
        api.run("dct-launch", controller=controller)


@pytest.fixture
def bitepoint(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ready_kernels: None) -> Command:
    """The command line, run in this process."""

    def call(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["bitepoint", *arguments])
        capsys.readouterr()
        status: Any = 0
        try:
            main()
        except SystemExit as stop:
            status = 0 if stop.code is None else stop.code
        printed = capsys.readouterr()
        return Outcome(status, printed.out, printed.err)

    return call


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Say how many of the tests on measured data ran: a skipped one proves nothing."""
    counts = {
        outcome: sum("real_data" in report.keywords for report in terminalreporter.stats.get(outcome, []))
        for outcome in ("passed", "failed", "skipped")
    }
    ran = counts["passed"] + counts["failed"]
    terminalreporter.write_line(f"tests on measured data: {ran} ran, {counts['skipped']} skipped")
