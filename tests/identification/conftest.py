"""Logs that several tests read, made once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import bitepoint

Logs = Callable[..., Path]


@pytest.fixture(scope="session")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Logs:
    """The folder of logs of dct-excitation with settings, made once for each."""
    made: dict[str, Path] = {}

    def folder(seed: int = 0, **settings: Any) -> Path:
        key = f"{seed} {sorted(settings.items())}"
        if key not in made:
            made[key] = tmp_path_factory.mktemp("logs")
            result = bitepoint.run("dct-excitation", seed=seed, **settings)
            for name, log in result.logs.items():
                log.to_parquet(made[key] / f"{name}.parquet")
        return made[key]

    return folder


@pytest.fixture(scope="session")
def training(logs: Logs) -> Path:
    """The logs as the library makes them."""
    return logs()


@pytest.fixture(scope="session")
def validation(logs: Logs) -> Path:
    """1700 kg on 15 %: 10 to 50 % throttle; the one of 10 % cannot hold the grade, and slows down from 160 rad/s."""
    return logs(seed=5, road__grade="15 %", vehicle__mass="1700 kg")
