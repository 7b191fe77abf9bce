"""The papers that can be reproduced."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from bitepoint.cache import write_atomically
from bitepoint.errors import InputError
from bitepoint.files import write_json
from bitepoint.studies import dct_launch, eco_launch, p2_damping
from bitepoint.studies.reproduction import Reproduction

Progress = Callable[[str], object]
"""Called with a few words on what is being run."""


@dataclass(frozen=True)
class Paper:
    """A paper, and what reproduces it."""

    source: str
    reproduce: Callable[[Progress], Reproduction]


PAPERS: Mapping[str, Paper] = {
    study.NAME: Paper(study.SOURCE, study.reproduce) for study in (dct_launch, p2_damping, eco_launch)
}
"""All of them, by name."""


def reproduce(name: str, progress: Progress = lambda _text: None) -> Reproduction:
    """Return the figures of a paper beside ours.

    Raises:
        InputError: there is no paper of that name.
    """
    if name not in PAPERS:
        raise InputError("reproduce", f"got {name}", f"expected one of {', '.join(PAPERS)}")
    return PAPERS[name].reproduce(progress)


def made(folder: str | Path) -> Path:
    """Make a folder if it is needed, before a minute of runs rather than after it.

    Raises:
        InputError: it cannot be made.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose another folder") from None
    return Path(folder)


def save(found: Reproduction, folder: str | Path) -> list[Path]:
    """Write rows.json and reproduction.html into `folder`, made if needed; return their paths.

    Raises:
        InputError: the folder cannot be written.
    """
    from bitepoint.report.reproduction import reproduction_page

    target = made(folder)
    paths = [target / name for name in ("rows.json", "reproduction.html")]
    page = reproduction_page(found.name, found.source, found.rows, found.notes, found.figures)
    try:
        write_json(paths[0], found.to_json())
        write_atomically(paths[1], page.encode(errors="backslashreplace"))
    except OSError as error:
        raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose another folder") from None
    return paths
