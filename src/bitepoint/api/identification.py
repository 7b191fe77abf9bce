"""Identification from Python: models of launches and of fuel, with files and reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from bitepoint.cache import write_atomically
from bitepoint.errors import InputError, brief
from bitepoint.identification import fuel
from bitepoint.identification.fuel import FuelIdentified, LogOptions
from bitepoint.identification.identify import Identified, Options, identify_launch
from bitepoint.models.arx import ArxModel
from bitepoint.models.fuel_model import FuelModel
from bitepoint.units import UnitError, parse


@dataclass(frozen=True)
class Identification(Identified):
    """An identified model with its errors, warnings and runs."""

    def save(self, model: str | Path | None = None, report: str | Path | None = None) -> list[Path]:
        """Write the model file, and the report in HTML, beside the model if it has no place of its own.

        Raises:
            InputError: a file cannot be written, or both are one.
        """
        from bitepoint.report.identification import identification_page

        return _save(self.model, model, report, lambda: identification_page(self))


@dataclass(frozen=True)
class FuelIdentification(FuelIdentified):
    """An identified fuel model with its errors, warnings and runs."""

    def save(self, model: str | Path | None = None, report: str | Path | None = None) -> list[Path]:
        """Write the model file and the report, as `Identification.save` does."""
        from bitepoint.report.fuel import fuel_page

        return _save(self.model, model, report, lambda: fuel_page(self))


def identify(
    files: str | Path | Sequence[str | Path],
    *,
    validate: str | Path | Sequence[str | Path] = (),
    model: str = "arx",
    orders: Sequence[int] | str = (2, 1, 1),
    method: str = "auto",
    columns: Mapping[str, str] | None = None,
    delays: Mapping[str, str | float] | None = None,
    dbc: str | Path | Sequence[str | Path] = (),
    period: str | float | None = None,
    ratio: float | None = None,
) -> Identification:
    """Identify the model of a launch from logs.

    Args:
        files: logs to train on, files or folders; validate: logs to validate on, likewise.
        model: "arx" or "armax".
        orders: n_a, n_b, n_g (and n_c), as numbers or as text "2,1,1"; "auto": searched by AIC.
        method: how an ARX model is fitted: "least squares", "instruments", or "auto", whichever simulates better.
        columns: channel -> its name in the logs, a unit may follow: {"engine_speed": "EngSpd rpm"}.
        delays: channel -> how late it is in the logs: {"clutch_torque": "20 ms"}.
        dbc: databases for CAN frames.
        period: raster of the model; None: that of the first log.
        ratio: engine side speed over wheel speed: the slip is then formed from engine_speed and wheel_speed.

    Raises:
        InputError: whatever in files or options is not as it should be.
    """
    options = Options(
        model=model,
        orders=_orders(orders),
        method=method,
        columns=columns,
        delays={name: _time("--delay", f"{name}: ", value) for name, value in (delays or {}).items()},
        databases=tuple(map(Path, _several(dbc))),
        period=None if period is None else _time("--period", "", period),
        ratio=ratio,
    )
    found = identify_launch(_several(files), _several(validate), options)
    return Identification(**{each.name: getattr(found, each.name) for each in fields(found)})


def identify_fuel(
    files: str | Path | Sequence[str | Path],
    *,
    validate: str | Path | Sequence[str | Path] = (),
    columns: Mapping[str, str] | None = None,
    delays: Mapping[str, str | float] | None = None,
    dbc: str | Path | Sequence[str | Path] = (),
    period: str | float | None = None,
    density: str | float | None = None,
    vehicle: str | Path | None = None,
    engine_map: str | Path | None = None,
) -> FuelIdentification:
    """Identify the fuel of a vehicle from logs of a drive.

    Args:
        files: logs to train on, files or folders.
        validate: logs to validate on, likewise.
        columns: as in `identify`.
        delays: as in `identify`.
        dbc: databases for CAN frames.
        period: raster of the model; None: one second.
        density: of the fuel, where logs or the engine map hold its volume; None: 0.743 g/mL for logs.
        vehicle: name or file of the vehicle, for a steady map and a correction; None: speed and acceleration only.
        engine_map: table of measured points, engine speed, torque and fuel flow, for the steady map; None: the map is
            made of the logs.

    Raises:
        InputError: whatever in files or options is not as it should be.
    """
    options = LogOptions(
        columns or {},
        {name: _time("--delay", f"{name}: ", value) for name, value in (delays or {}).items()},
        tuple(map(Path, _several(dbc))),
        None if period is None else _time("--period", "", period),
        None if density is None else _quantity("--density", "", density, "kg/m^3", "a density, such as 0.743 g/mL"),
    )
    of = [None if each is None else str(each) for each in (vehicle, engine_map)]
    found = fuel.identify_fuel(_several(files), _several(validate), options, *of)
    return FuelIdentification(**{each.name: getattr(found, each.name) for each in fields(found)})


def _save(
    found: ArxModel | FuelModel, model: str | Path | None, report: str | Path | None, page: Callable[[], str]
) -> list[Path]:
    if report is None and model is not None:
        report = Path(model).with_suffix(".html")
    paths = [Path(path) for path in (model, report) if path is not None]
    for path in paths:
        if not path.parent.is_dir() or path.is_dir():
            raise InputError(str(path), "cannot be written", "expected a file in a folder that exists")
    if len(set(paths)) < len(paths):
        raise InputError(str(model), "is model and report", "expected a model that ends in .json")
    if report is not None:
        try:
            write_atomically(Path(report), page().encode(errors="backslashreplace"))
        except OSError as error:
            raise InputError(str(report), f"cannot be written ({error.strerror})", "choose another place") from None
    if model is not None:
        found.save(model)
    return paths


def _several(paths: str | Path | Sequence[str | Path]) -> list[str | Path]:
    return [paths] if isinstance(paths, str | Path) else list(paths)


def _orders(orders: Sequence[int] | str) -> tuple[int, ...] | None:
    if orders == "auto":
        return None
    try:
        return tuple(int(order) for order in (orders.split(",") if isinstance(orders, str) else orders))
    except (TypeError, ValueError):
        raise InputError("--orders", f"got {brief(orders)}", "expected auto, or numbers such as 2,1,1") from None


def _time(option: str, prefix: str, value: str | float) -> float:
    return _quantity(option, prefix, value, "s", "a time, such as 20 ms")


def _quantity(option: str, prefix: str, value: str | float, unit: str, expected: str) -> float:
    try:
        return parse(value, unit)
    except UnitError as error:
        raise InputError(option, f"{prefix}{error}", f"expected {expected}") from None
