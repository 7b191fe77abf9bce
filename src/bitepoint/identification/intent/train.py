"""Training of the intention network: `python -m bitepoint.identification.intent.train`.

Draws launches of synthetic drivers (for training, for choosing the epoch, and for the figures: no driver is in two of
them), trains the network with PyTorch, tunes the pedal rule on the same training launches, and writes both with their
figures into the file that ships. PyTorch is needed here and nowhere else: `pip install 'bitepoint[intent]'`.
"""

from __future__ import annotations

import argparse
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bitepoint.cache import write_atomically
from bitepoint.controllers.launch_intent import CONTROLLER, LaunchIntentCalibration
from bitepoint.errors import BitepointError, InputError
from bitepoint.files import library_folder
from bitepoint.identification.intent.assessment import (
    DRIVERS,
    EACH,
    SEEDS,
    Lot,
    assess,
    assess_discriminant,
    draw_lot,
    first_decision,
)
from bitepoint.identification.intent.baselines import Rule, tune_rule
from bitepoint.identification.intent.drivers import VERSION
from bitepoint.numerics.lstm import CLASSES, HIDDEN, INPUTS
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

FILE = library_folder("controllers") / "launch_intent_trained.yaml"

EPOCHS, BATCH, LEARNING_RATE = 50, 200, 5e-3
EARLY_WEIGHT, LATE, LATE_WEIGHT = 0.1, 100, 0.3
"""Weights, in training, of samples before the first decision and of those from sample LATE on; the others have 1.

A launch is over 1.2 to 1.6 s after pedal onset, so what is decided late serves least.
"""

REFERENCES, REFERENCE_SAMPLES = 3, (0, 27, 99, 199)
"""Test launches, and samples of their windows, whose scores by PyTorch are kept to hold the kernel to."""

DIGITS = 7


BLANK = LaunchIntentCalibration.to_mapping(LaunchIntentCalibration.zeros()[0])
NO_RULE: dict[str, float] = dict.fromkeys(("rule_lead", "rule_normal", "rule_urgent"), 0.0)


def train(lots: dict[str, Lot], first: int, seed: int, epochs: int, torch: Any) -> dict[str, Any]:
    """Return the weights, rounded, of the epoch that decides most of the validation rightly, samples weighed.

    Args:
        lots: launches for training and validation.
        first: sample of the first decision.
        seed: of initial weights and of the order of launches.
        epochs: passes over the training launches.
        torch: the library.
    """
    torch.manual_seed(seed)
    scale = lots["training"].windows.inputs.std(axis=(0, 1))
    used = ("training", "validation")
    scaled = {purpose: _tensor(torch, lots[purpose].windows.inputs / scale) for purpose in used}
    truth = {purpose: torch.as_tensor(lots[purpose].launches.intention) for purpose in used}
    network = torch.nn.ModuleDict({"lstm": torch.nn.LSTM(INPUTS, HIDDEN, batch_first=True)})
    network["scores"] = torch.nn.Linear(HIDDEN, CLASSES)
    optimiser = torch.optim.Adam(network.parameters(), lr=LEARNING_RATE)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, epochs)
    weight = torch.ones(scaled["training"].shape[1])
    weight[:first], weight[LATE:] = EARLY_WEIGHT, LATE_WEIGHT
    best, weights = 0.0, {}
    for epoch in range(epochs):
        for rows in torch.randperm(len(truth["training"])).split(BATCH):
            optimiser.zero_grad()
            scores = _scores(network, scaled["training"][rows])
            wanted = truth["training"][rows][:, None].expand(scores.shape[:2])
            loss = torch.nn.functional.cross_entropy(scores.transpose(1, 2), wanted, reduction="none")
            (loss * weight).mean().backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
        schedule.step()
        with torch.no_grad():
            decided = _scores(network, scaled["validation"])[:, first:].argmax(dim=2)
        right = (decided == truth["validation"][:, None]).double().mean(dim=0)
        accuracy = float((right * weight[first:]).sum() / weight[first:].sum())
        if accuracy > best:
            best, weights = accuracy, _weights(network, scale)
        print(f"epoch {epoch + 1:3d}: {accuracy:.4f} of the validation, best {best:.4f}", flush=True)
    return weights


def _tensor(torch: Any, values: Floats) -> Any:
    return torch.as_tensor(values, dtype=torch.float32)


def _scores(network: Any, inputs: Any) -> Any:
    return network["scores"](network["lstm"](inputs)[0])


def _weights(network: Any, scale: Floats) -> dict[str, Any]:
    """Return the weights for inputs that are not scaled, as the record has them."""
    lstm, scores = network["lstm"], network["scores"]
    arrays = {
        "input_weights": lstm.weight_ih_l0.detach().double().numpy() / scale,
        "recurrent_weights": lstm.weight_hh_l0.detach().double().numpy(),
        "biases": (lstm.bias_ih_l0 + lstm.bias_hh_l0).detach().double().numpy(),
        "score_weights": scores.weight.detach().double().numpy(),
        "score_biases": scores.bias.detach().double().numpy(),
    }
    return {name: np.vectorize(_rounded)(values).tolist() for name, values in arrays.items()}


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def reference_scores(weights: dict[str, Any], inputs: Floats, torch: Any) -> list[list[list[float]]]:
    """Return the scores of PyTorch in float64 for the rounded weights: launches, samples, classes."""
    lstm = torch.nn.LSTM(INPUTS, HIDDEN, batch_first=True).double()
    values = {name: torch.as_tensor(value, dtype=torch.float64) for name, value in weights.items()}
    with torch.no_grad():
        lstm.weight_ih_l0.copy_(values["input_weights"])
        lstm.weight_hh_l0.copy_(values["recurrent_weights"])
        lstm.bias_ih_l0.copy_(values["biases"])
        lstm.bias_hh_l0.zero_()
        outputs = lstm(torch.as_tensor(inputs))[0]
        scores = outputs @ values["score_weights"].T + values["score_biases"]
    return scores[:, list(REFERENCE_SAMPLES)].tolist()


def tuned_rule(lot: Lot, first: int) -> Rule:
    """Return the rule tuned on the training launches, over all samples from the first decision on."""
    w, samples = lot.windows, lot.windows.highest_pedal.shape[1] - first
    truth = np.repeat(lot.launches.intention[:, None], samples, axis=1)
    return tune_rule(w.highest_pedal[:, first:], w.highest_rate[:, first:], truth)


def _settings(calibration: str, rule: dict[str, float], weights: dict[str, Any]) -> RecordArray:
    """Return a calibration that ships with another rule and other weights."""
    shipped = {key: value for key, value in CONTROLLER.calibrations()[calibration].items() if key != "source"}
    return LaunchIntentCalibration.parse({**shipped, **rule, "network": weights}, "training")


def main() -> None:
    """Train and write the file."""
    parser = argparse.ArgumentParser(prog="python -m bitepoint.identification.intent.train", description=__doc__)
    parser.add_argument("--out", type=Path, default=FILE, help="file to write")
    parser.add_argument("--seed", type=int, default=5, help="of initial weights and of the order of launches")
    parser.add_argument("--epochs", type=int, default=EPOCHS, help="passes over the training launches")
    options = parser.parse_args()
    if options.epochs < 1:
        raise InputError("--epochs", f"got {options.epochs}", "expected 1 or more")
    if not options.out.parent.is_dir():
        raise InputError(str(options.out), "its folder is not there", "name a file in one that is")
    try:
        torch: Any = import_module("torch")
    except ImportError:
        raise InputError("training", "PyTorch is not installed", "pip install 'bitepoint[intent]'") from None
    blank = _settings("trained", NO_RULE, BLANK["network"])
    lots = {purpose: draw_lot(purpose, blank) for purpose in DRIVERS}
    first = first_decision(blank)
    weights = train(lots, first, options.seed, options.epochs, torch)
    found = tuned_rule(lots["training"], first)
    rule = {"rule_lead": found.lead, "rule_normal": found.normal, "rule_urgent": found.urgent}
    rule = {name: round(value, 4) for name, value in rule.items()}
    figures = assess(_settings("trained", rule, weights), _settings("rule", rule, weights))
    figures["discriminant"] = {"accuracy_at": assess_discriminant(lots["training"], lots["test"])}
    scores = reference_scores(weights, lots["test"].windows.inputs[:REFERENCES], torch)
    content = {
        "provenance": _provenance(options.seed, options.epochs, torch.__version__),
        "figures": figures,
        "rule": rule,
        "network": weights,
        "reference": {"samples": list(REFERENCE_SAMPLES), "scores": scores},
    }
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=118)
    write_atomically(options.out, (HEADER + text).encode())
    print(f"right: network {figures['network']['accuracy']}, rule {figures['rule']['accuracy']}; wrote {options.out}")


def _provenance(seed: int, epochs: int, version: str) -> dict[str, Any]:
    return {
        "generator": f"bitepoint.identification.intent, version {VERSION}",
        "drivers": DRIVERS,
        "launches": {purpose: EACH * number for purpose, number in DRIVERS.items()},
        "seeds": {**SEEDS, "weights": seed},
        "epochs": epochs,
        "library": f"PyTorch {version}",
    }


HEADER = "# Written by python -m bitepoint.identification.intent.train; not to be edited by hand.\n"


if __name__ == "__main__":
    try:
        main()
    except BitepointError as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(2) from None
