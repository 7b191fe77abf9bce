"""The public face: run a scenario, get figures, a recording, a picture.

import bitepoint
result = bitepoint.run("dct-launch", intent="urgent")
result.metrics["launch_time"].value
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import numpy.typing as npt

from bitepoint.api.identification import FuelIdentification, Identification, identify, identify_fuel
from bitepoint.assembly import Assembly, Comparer, Lanes, assemble, at_the_end, bound_ratio, solve_times
from bitepoint.cache import write_atomically
from bitepoint.errors import InputError, brief
from bitepoint.files import write_json
from bitepoint.identification.logs import LEAST_ROWS, slip_log
from bitepoint.kernels import Life
from bitepoint.metrics import Metric, Metrics, excitation_set
from bitepoint.parts.gears import overall_ratio
from bitepoint.recording import Floats, Recording
from bitepoint.scenarios import load_scenario
from bitepoint.simulation.run import LaneResult, Simulation
from bitepoint.version import __version__


@dataclass(frozen=True)
class Result:
    """One run.

    Attributes:
        scenario: its name.
        status: "launched", "stalled", "rolled back", "timed out" or "not finite" for a launch.
        reason: a sentence that says why it ended.
        metrics: figures of merit by name, each with .value (None where it does not exist) and .unit.
        recording: all signals over time; of the first run where there are many.
        logs: of a scenario of many runs: their logs by name.
        compared: of a scenario that is planned: the recordings of the drives beside it by name.
        family: of its figures: "launch", "driveline", "driving" or "excitation".
    """

    scenario: str
    status: str
    reason: str
    metrics: Metrics
    recording: Recording
    logs: Mapping[str, Recording] = field(default_factory=dict[str, Recording])
    family: str = "launch"
    compared: Mapping[str, Recording] = field(default_factory=dict[str, Recording])

    def figure(self) -> Any:
        """Return the interactive picture, a plotly Figure."""
        from bitepoint.report.driveline import driveline_figure
        from bitepoint.report.driving import driving_figure
        from bitepoint.report.excitation import excitation_figure
        from bitepoint.report.launch import launch_figure

        if self.logs:
            return excitation_figure(self.logs)
        draw = {"driveline": driveline_figure, "driving": driving_figure}.get(self.family, launch_figure)
        return draw(self.recording, f"{self.scenario}: {self.status}, {self.reason}")

    def to_json(self) -> dict[str, Any]:
        """Return what `bitepoint run --json` prints."""
        metrics = {name: _metric_to_json(metric) for name, metric in self.metrics.items()}
        return {"scenario": self.scenario, "status": self.status, "reason": self.reason, "metrics": metrics}

    def save(self, folder: str | Path) -> list[Path]:
        """Write recordings, metrics.json and an HTML page into `folder`, made if needed; return their paths.

        One run is recording.parquet and launch.html, driveline.html or driving.html; a planned drive has a file for
        each drive beside it too. Many runs are a Parquet file for each log, and excitation.html. Logs that an earlier
        call wrote there are replaced, all of them.

        Raises:
            InputError: the folder cannot be written.
        """
        target = Path(folder)
        page = self._page()
        recordings = self.logs or {"recording": self.recording, **self.compared}
        files = {target / f"{each}.parquet": recording for each, recording in recordings.items()}
        paths = [*files, target / "metrics.json", target / f"{self.family}.html"]
        try:
            target.mkdir(parents=True, exist_ok=True)
            if self.logs:
                for old in set(target.glob("run-[0-9]*.parquet")) - set(files):
                    old.unlink()
            for path, recording in files.items():
                recording.to_parquet(path)
            write_json(paths[-2], self.to_json())
            write_atomically(paths[-1], page.encode(errors="backslashreplace"))
        except OSError as error:
            raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose another folder") from None
        return paths

    def _page(self) -> str:
        from bitepoint.report.driveline import driveline_page
        from bitepoint.report.driving import driving_page
        from bitepoint.report.excitation import excitation_page
        from bitepoint.report.launch import launch_page

        if self.logs:
            return excitation_page(self.logs, self.metrics, self.status, self.reason)
        if self.family == "driving":
            return driving_page(self.recording, self.metrics, self.status, self.reason, self.compared)
        write = driveline_page if self.family == "driveline" else launch_page
        return write(self.recording, self.metrics, self.status, self.reason)


@dataclass(frozen=True)
class BatchResult:
    """Many runs.

    Attributes:
        scenario: its name.
        status: one per lane.
        reason: a sentence per lane.
        metrics: figures of merit by name, shape (lanes,), NaN where a figure does not exist.
        units: their units.
        recordings: of the lanes that were asked for, by lane.
    """

    scenario: str
    status: Sequence[str]
    reason: Sequence[str]
    metrics: Mapping[str, Floats]
    units: Mapping[str, str]
    recordings: Mapping[int, Recording]

    def __repr__(self) -> str:
        """Return one line: how many lanes ended how."""
        counts = ", ".join(f"{self.status.count(status)} {status}" for status in dict.fromkeys(self.status))
        return f"<BatchResult of {self.scenario}: {counts}>"

    @property
    def launched(self) -> npt.NDArray[np.bool_]:
        """Which lanes ended as "launched", shape (lanes,): the others may have synced, and then failed."""
        return np.array([status == "launched" for status in self.status])


def run(
    scenario: str = "dct-launch",
    settings: Mapping[str, Any] | None = None,
    /,
    *,
    seed: int = 0,
    life: Life = "compiled",
    **more: Any,
) -> Result:
    """Run a scenario once; one of many runs, all of them, and log them.

    Args:
        scenario: name in the library, or path of a scenario file.
        settings: as `--set` takes them: {"road.grade": "20 %", "intent": "urgent"}.
        seed: of the noise.
        life: "compiled", or "interpreted" to step through kernels in a debugger (slow).
        more: settings too, a dot written as two underscores: intent="urgent", vehicle__mass="1900 kg".

    Raises:
        InputError: whatever in the files or the settings is not as it should be.
    """
    chosen = {**(settings or {}), **_dotted(more)}
    _check_options(seed, life)
    manoeuvre = load_scenario(scenario)
    if manoeuvre.runs is not None:
        own = chosen.get("controller", manoeuvre.controller) == manoeuvre.controller
        over = manoeuvre.runs.lanes(chosen, own, seed)
        return _logged(assemble(scenario, chosen, over), over, seed, life)
    assembly = assemble(scenario, chosen)
    lane = Simulation(assembly.system, life=life).run(assembly.figures, seed=seed)[0]
    return _result(assembly, lane, seed, life)


def run_batch(
    scenario: str,
    over: Mapping[str, Sequence[Any] | npt.NDArray[Any]],
    settings: Mapping[str, Any] | None = None,
    /,
    *,
    record: Collection[int] = (),
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    **more: Any,
) -> BatchResult:
    """Run a scenario in many lanes at once, over all processors, in bounded memory.

    Args:
        scenario: name in the library, or path of a scenario file.
        over: what differs: dotted keys of plant or controller, each with one value per lane.
        settings: what all lanes share, as in `run`.
        more: settings too, as in `run`.
        record: lanes whose recordings are kept; the figures are kept of all.
        seed: of the noise; lane n has its own stream whatever the other lanes are.
        threads: how many run at once; by default as many as there are processors.
        progress: called with the number of lanes that have just ended.

    Raises:
        InputError: whatever in the files, the settings or the lanes is not as it should be.
    """
    assembly = assemble(scenario, {**(settings or {}), **_dotted(more)}, over)
    _check_options(seed, "compiled", threads)
    for lane in record:
        if not 0 <= lane < assembly.lanes:
            raise InputError("record", f"got lane {lane}", f"expected lanes of 0..{assembly.lanes - 1}")
    family = assembly.figures
    units: dict[str, str] = {}

    def figures(recording: Recording) -> Floats:
        found = family(recording)
        if not units:
            units.update({name: metric.unit for name, metric in found.items()})
        return np.array([np.nan if metric.value is None else metric.value for metric in found.values()])

    simulation = Simulation(assembly.system)
    lanes = simulation.run(figures, lanes=assembly.lanes, record=record, seed=seed, threads=threads, progress=progress)
    table = np.array([lane.figures for lane in lanes])
    recordings = {n: lane.recording for n, lane in enumerate(lanes) if lane.recording is not None}
    return BatchResult(
        assembly.scenario.name, [lane.status for lane in lanes], [lane.reason for lane in lanes],
        {name: table[:, k] for k, name in enumerate(units)}, units, recordings,
    )  # fmt: skip


def _logged(assembly: Assembly, over: Lanes, seed: int, life: Life) -> Result:
    """Run all lanes of a scenario of many runs, and make their logs."""
    assert assembly.log is not None
    period, noise = float(assembly.log["period"][0]), float(assembly.log["noise"][0])
    if abs(period / assembly.system.tick - round(period / assembly.system.tick)) > 1e-6:
        mend = f"expected a multiple of the tick, {assembly.system.tick:g} s"
        raise InputError("log.period", f"got {period:g} s", mend)
    lanes = range(assembly.lanes)
    family = assembly.figures
    done = Simulation(assembly.system, life=life).run(family, lanes=assembly.lanes, record=lanes, seed=seed)
    ratios = overall_ratio.run(np.ascontiguousarray(assembly.system.plant.parameters["gearbox"]), life="interpreted")
    logs: dict[str, Recording] = {}
    for n, lane in enumerate(done):
        about = {f"run.{key}": str(values[n]) for key, values in over.items()}
        result = _result(assembly, lane, seed, life)
        recording = replace(result.recording, about={**result.recording.about, **about})
        log = slip_log(recording, float(ratios[n % len(ratios)]), period, noise, (seed, n))
        if len(log.time) >= LEAST_ROWS:
            logs[f"run-{n + 1:0{len(str(assembly.lanes))}}"] = log
    metrics = excitation_set(list(logs.values()), [lane.figures for lane in done])
    rows = sum(len(log.time) for log in logs.values())
    left = assembly.lanes - len(logs)
    reason = f"{len(logs)} of {assembly.lanes} runs have {rows} rows in which the vehicle moves and the clutch slips"
    status = "logged" if not left else "partly logged" if logs else "not logged"
    return replace(_result(assembly, done[0], seed, life), status=status, reason=reason, metrics=metrics, logs=logs)


def _metric_to_json(metric: Metric) -> dict[str, Any]:
    value = {"value": metric.value, "unit": metric.unit}
    return {**value, "reason": metric.reason} if metric.reason else value


def _check_options(seed: Any, life: Any, threads: Any = None) -> None:
    if not isinstance(seed, int) or seed < 0:
        raise InputError("seed", f"got {brief(seed)}", "expected a whole number of 0 or more")
    if life not in get_args(Life):
        raise InputError("life", f"got {brief(life)}", f"expected one of {', '.join(get_args(Life))}")
    if threads is not None and (not isinstance(threads, int) or threads < 1):
        raise InputError("threads", f"got {brief(threads)}", "expected a whole number of 1 or more")


def _dotted(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {key.replace("__", "."): value for key, value in settings.items()}


def _result(assembly: Assembly, lane: LaneResult[Metrics], seed: int, life: Life) -> Result:
    assert lane.recording is not None
    about = {**assembly.about, "status": lane.status, "reason": lane.reason, "seed": str(seed), "version": __version__}
    recording, metrics = replace(lane.recording, about=about), lane.figures
    if assembly.report.bound:
        ratio = bound_ratio(assembly.system.plant.parameters, lane.status, metrics, recording)
        metrics = {**metrics, "bound_ratio": ratio}
    if assembly.report.solve_time:
        metrics = {**metrics, **solve_times(assembly.system.controllers[-1], recording, life)}
    compared: Mapping[str, Recording] = {}
    if assembly.planned is not None:
        metrics, compared = _compared(assembly, metrics, recording, seed, life)
    family = assembly.scenario.metrics
    return Result(
        assembly.scenario.name, lane.status, lane.reason, metrics, recording, family=family, compared=compared
    )


def _compared(
    assembly: Assembly, metrics: Metrics, recording: Recording, seed: int, life: Life
) -> tuple[Metrics, Mapping[str, Recording]]:
    """Return the figures of a planned drive with those of the drives beside it, and their recordings."""
    assert assembly.planned is not None
    planned = assembly.planned
    comparer = Comparer(planned, assembly.system, assembly.baseline, seed, life)
    found = comparer.compare(recording)
    metrics = at_the_end(metrics, recording, planned.length, planned.target)
    about = recording.about
    drives = {name: replace(each, about={**about, "drive": name}) for name, each in found.recordings.items()}
    return {**metrics, **found.metrics}, drives


__all__ = [
    "BatchResult", "FuelIdentification", "Identification", "Metric", "Result", "identify", "identify_fuel", "run",
    "run_batch",
]  # fmt: skip
