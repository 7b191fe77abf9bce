"""CHARACTERISTIC and MEASUREMENT blocks, and the COMPU_METHOD and RECORD_LAYOUT blocks that they refer to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from bitepoint.export.a2l_syntax import block, display_format, identifier, number, quoted
from bitepoint.export.a2l_variables import Variable
from bitepoint.kernels.c99 import Precision
from bitepoint.records import Axis, Field
from bitepoint.units import display


@dataclass
class Items:
    """The blocks of one module, as they are made.

    Attributes:
        addresses: where each variable of C lies.
        inputs: variables that a curve or a map can be over, by name and unit of the signal.
        conversions, layouts: the COMPU_METHOD and COMPU_VTAB, and the RECORD_LAYOUT blocks in use, by their name.
    """

    precision: Precision
    addresses: Mapping[str, int]
    inputs: Mapping[tuple[str, str], str]
    conversions: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    layouts: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    _units: dict[str, str] = field(default_factory=dict[str, str])

    def characteristic(self, variable: Variable) -> Iterator[str]:
        """Yield the block of a number to be calibrated: VALUE, VAL_BLK, or CURVE or MAP over axes of its own."""
        declared = variable.field
        if declared.axes:
            *over, last = declared.axes
            kind, layout, value = declared.kind.upper(), self._table_layout(declared), _axis_field(last)
            extra = [line for axis in over for line in self._axis_description(axis, declared.most_points)]
        else:
            kind, layout, value = "VAL_BLK" if declared.shape else "VALUE", self._value_layout(declared), declared
            extra = _matrix(declared)
        low, high = self._limits(value)
        head = f"{variable.name} {quoted(declared.meaning)} {kind} {self._address(variable)}"
        head = f"{head} {layout} 0 {self._conversion(variable, value)} {number(low)} {number(high)}"
        yield from block("CHARACTERISTIC", head, [*_common(variable, value, low, high), *extra])

    def measurement(self, variable: Variable) -> Iterator[str]:
        """Yield the block of a number, or an array of numbers, to be measured."""
        declared = variable.field
        low, high = self._limits(declared)
        head = (
            f"{variable.name} {quoted(declared.meaning)} {self._type(declared)} {self._conversion(variable, declared)}"
        )
        address = f"ECU_ADDRESS {self._address(variable)}"
        layout = ["LAYOUT ROW_DIR"] if len(declared.shape) > 1 else []
        body = [address, *_common(variable, declared, low, high), *layout, *_matrix(declared)]
        yield from block("MEASUREMENT", f"{head} 0 0 {number(low)} {number(high)}", body)

    def referred(self) -> Iterator[str]:
        """Yield the conversions and record layouts that the blocks made so far refer to."""
        for lines in self.conversions.values():
            yield from lines
        for name, lines in self.layouts.items():
            yield from block("RECORD_LAYOUT", name, lines)

    def _address(self, variable: Variable) -> str:
        base = self.addresses.get(variable.symbol)
        return "0x0" if base is None else f"0x{base + variable.offset:X}"

    def _type(self, declared: Field) -> str:
        reals, integers = {4: ("FLOAT32_IEEE", "SLONG"), 8: ("FLOAT64_IEEE", "A_INT64")}[self.precision.size]
        return integers if declared.kind == "int" else reals

    def _limits(self, declared: Field) -> tuple[float, float]:
        """Return the range of a field, within what the precision can hold."""
        if declared.kind == "int":
            whole = np.iinfo(self.precision.integer_dtype)
            return max(declared.low, int(whole.min)), min(declared.high, int(whole.max))
        largest = self.precision.largest
        return max(declared.low, -largest), min(declared.high, largest)

    def _conversion(self, variable: Variable, value: Field) -> str:
        """Return the name of the conversion of a value: of its states where it has such, or else of its unit."""
        if value.names:
            return self._table(f"{variable.name}.states", value)
        if value.unit not in self._units:
            plain = f"unit_{identifier(value.unit)}"
            candidates = (plain, *(f"{plain}_{again}" for again in range(2, 1000)))
            name = next(candidate for candidate in candidates if candidate not in self.conversions)
            self._units[value.unit] = name
            head = f"{name} {quoted('')} IDENTICAL {quoted('%15.6')} {quoted(display(value.unit))}"
            self.conversions[name] = list(block("COMPU_METHOD", head))
        return self._units[value.unit]

    def _table(self, name: str, value: Field) -> str:
        pairs = [f"{int(value.low) + place} {quoted(text)}" for place, text in enumerate(value.names)]
        method = f"{name} {quoted('')} TAB_VERB {quoted('%4.0')} {quoted('')}"
        table = block("COMPU_VTAB", f"{name} {quoted('')} TAB_VERB {len(pairs)}", pairs)
        self.conversions[name] = [*block("COMPU_METHOD", method, [f"COMPU_TAB_REF {name}"]), *table]
        return name

    def _value_layout(self, declared: Field) -> str:
        kind = self._type(declared)
        self.layouts[f"value_{kind}"] = [f"FNC_VALUES 1 {kind} ROW_DIR DIRECT"]
        return f"value_{kind}"

    def _table_layout(self, declared: Field) -> str:
        """Return the name of the layout of `Curve` or `Map`; static: all stays in its place, however many the points.

        C's `z[x][y]` has y run fastest. To ASAP2 x counts the columns of a map, so that it lies column by column.
        """
        points, real = self._type(Field("", "int", "")), self._type(Field("", "float", ""))
        names = "XY"[: len(declared.axes) - 1]
        order = "ROW_DIR" if declared.kind == "curve" else "COLUMN_DIR"
        members = [f"NO_AXIS_PTS_{name} {{}} {points}" for name in names]
        members += [f"AXIS_PTS_{name} {{}} {real} INDEX_INCR DIRECT" for name in names]
        members += [f"FNC_VALUES {{}} {real} {order} DIRECT"]
        layout = f"{declared.kind}_{real}"
        self.layouts[layout] = [*(m.format(place) for place, m in enumerate(members, 1)), "STATIC_RECORD_LAYOUT"]
        return layout

    def _axis_description(self, axis: Axis, most: int) -> Iterator[str]:
        x = _axis_field(axis)
        low, high = self._limits(x)
        quantity = self.inputs.get((axis.name, axis.unit), "NO_INPUT_QUANTITY")
        conversion = self._conversion(Variable("", "", 0, x), x)
        head = f"STD_AXIS {quantity} {conversion} {most} {number(low)} {number(high)}"
        body = ["MONOTONY STRICT_INCREASE", f"FORMAT {display_format(low, high, whole=False)}"]
        yield from block("AXIS_DESCR", head, body)


def _axis_field(axis: Axis) -> Field:
    return Field(axis.name, "float", "", axis.unit, axis.low, axis.high)


def _common(variable: Variable, value: Field, low: float, high: float) -> Iterator[str]:
    yield f"FORMAT {display_format(low, high, whole=value.kind == 'int')}"
    yield f"SYMBOL_LINK {quoted(variable.symbol)} {variable.offset}"


def _matrix(declared: Field) -> list[str]:
    """Return the dimensions of an array, x first.

    In the order ROW_DIR x runs fastest, so that x is the last dimension of C: `float a[rows][columns]` has the
    dimensions `columns rows`, and a tool shows it as C writes it.
    """
    return [f"MATRIX_DIM {' '.join(str(size) for size in reversed(declared.shape))}"] if declared.shape else []
