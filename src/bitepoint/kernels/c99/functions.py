"""Statements of a kernel as a C function."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from bitepoint.kernels.c99.expressions import Term, Terms, Uses
from bitepoint.kernels.c99.names import Names
from bitepoint.kernels.c99.precision import Precision
from bitepoint.kernels.c99.text import WIDTH, comment, indented
from bitepoint.kernels.kernel import Kernel
from bitepoint.kernels.source import loaded
from bitepoint.kernels.subset import check
from bitepoint.kernels.values import Value

Path = tuple[int, ...]
"""Where a block of statements stands: the numbers of the blocks that it lies in, and its own."""


@dataclass
class Local:
    """A local of the kernel: its name in C, its type once that is known, and where it is declared."""

    name: str
    block: Path
    first: ast.stmt
    stores: int = 0
    loads: int = 0
    value: Value | None = None
    holder: ast.stmt | None = None


@dataclass
class Scopes:
    """Finds for each local the innermost block that holds all of its uses, and the first statement there."""

    locals: dict[str, Local] = field(default_factory=dict[str, Local])
    loops: set[str] = field(default_factory=set[str])
    blocks: dict[ast.stmt, Path] = field(default_factory=dict[ast.stmt, Path])
    _count: int = 0

    def body(self, statements: Sequence[ast.stmt], path: Path = ()) -> None:
        """Walk a block of statements."""
        self._count += 1
        path = (*path, self._count)
        for statement in statements:
            self.blocks[statement] = path
            inner = [getattr(statement, part) for part in ("body", "orelse") if getattr(statement, part, None)]
            if isinstance(statement, ast.For):
                self._loop(statement)
                self._expression(statement.iter, path, statement)
            else:
                parts = [part for part in ast.iter_child_nodes(statement) if not isinstance(part, ast.stmt)]
                for part in parts:
                    self._expression(part, path, statement)
            for block in inner:
                self.body(block, path)

    def _loop(self, statement: ast.For) -> None:
        assert isinstance(statement.target, ast.Name)
        self.loops.add(statement.target.id)

    def _expression(self, part: ast.AST, path: Path, statement: ast.stmt) -> None:
        for node in ast.walk(part):
            if isinstance(node, ast.Name):
                self._use(node, path, statement)

    def _use(self, node: ast.Name, path: Path, statement: ast.stmt) -> None:
        local = self.locals.setdefault(node.id, Local(node.id, path, statement))
        shared = 0
        for a, b in zip(local.block, path, strict=False):
            if a != b:
                break
            shared += 1
        local.block = local.block[:shared]
        local.stores += isinstance(node.ctx, ast.Store) + isinstance(statement, ast.AugAssign)
        local.loads += isinstance(node.ctx, ast.Load)


class Function:
    """One kernel as a C function."""

    def __init__(
        self, kernel: Kernel[..., Any], names: Names, precision: Precision, uses: Uses, public: str | None = None
    ) -> None:
        self.kernel = kernel
        self.names = names
        self.precision = precision
        self.public = public
        self.source = kernel.source
        self.node = ast.parse(kernel.source.text).body[0]
        assert isinstance(self.node, ast.FunctionDef)
        ast.increment_lineno(self.node, kernel.source.node.lineno - 1)
        self.written = frozenset[str]() if kernel.trusted else check(kernel).written
        self.terms = Terms(kernel, names, precision, uses, self._look_up)
        self.scopes = Scopes()
        self.statements = self.node.body[1:] if ast.get_docstring(self.node) is not None else self.node.body
        self.scopes.body(self.statements)
        self._identify()

    def _identify(self) -> None:
        """Give every parameter, loop variable and local its name, apart from all names at file scope."""
        used = {node.id for node in ast.walk(self.node) if isinstance(node, ast.Name)}
        self.parameters: dict[str, Term] = {}
        self.own: set[str] = set()
        for parameter in self.kernel.parameters:
            if parameter.kind in ("floats", "ints"):
                mend = "put the array into a record"
                raise self.source.fail(self.node, f"{self.kernel.name} takes a bare array, which C cannot", mend)
            name = self._free(parameter.name)
            value = Value(parameter.kind, record=parameter.record)
            self.parameters[parameter.name] = Term(name, value, pointer=parameter.record is not None)
        self.unused = [term.text for name, term in self.parameters.items() if name not in used]
        self.loops = {name: self._free(name.lstrip("_") or "i") for name in sorted(self.scopes.loops)}
        stored = {n.id for n in ast.walk(self.node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        for name in list(self.scopes.locals):
            if name not in stored or name in self.parameters or name in self.loops:
                del self.scopes.locals[name]
            else:
                self.scopes.locals[name].name = self._free(name.lstrip("_"))

    def _free(self, name: str) -> str:
        while name in self.own or name in self.names.taken:
            name += "_"
        self.own.add(name)
        return name

    def _look_up(self, name: str) -> Term | None:
        if name in self.parameters:
            return self.parameters[name]
        if name in self.loops:
            return Term(self.loops[name], Value("int"))
        local = self.scopes.locals.get(name)
        if local is None:
            return None
        assert local.value is not None
        return Term(local.name, local.value)

    def signature(self) -> str:
        """Return the head of the function, without the semicolon of a prototype."""
        parts: list[str] = []
        for parameter, term in zip(self.kernel.parameters, self.parameters.values(), strict=True):
            if parameter.record is not None:
                constant = "" if parameter.name in self.written else "const "
                parts.append(f"{constant}{self.names.type(parameter.record)} *{term.text}")
            else:
                parts.append(f"{self.ctype(parameter.kind)} {term.text}")
        head = f"{self.ctype(self.kernel.result)} {self.public or self.names.function(self.kernel)}"
        head = f"{'' if self.public else 'static '}{head}("
        line = f"{head}{', '.join(parts) or 'void'})"
        return line if len(line) < WIDTH else head + ",\n    ".join(["\n    " + parts[0], *parts[1:]]) + ")"

    def ctype(self, kind: str) -> str:
        """Return the C type of a scalar."""
        return {"float": self.precision.real, "int": self.precision.integer, "bool": "bool", "none": "void"}[kind]

    def about(self) -> Iterator[str]:
        """Yield the comment above the function: what its docstring says."""
        yield from comment(ast.get_docstring(self.node) or "")  # pyright: ignore[reportArgumentType]

    def text(self) -> Iterator[str]:
        """Yield the lines of the function."""
        yield from self.about()
        yield self.signature()
        yield "{"
        yield from indented(f"(void){name};" for name in self.unused)
        yield from indented(self._body(self.statements))
        yield "}"

    def _remarks(self, node: ast.stmt) -> Iterator[str]:
        """Yield the source's comments that belong to a statement: beside it, and on lines of their own above it."""
        header = [part for part in ast.iter_child_nodes(node) if not isinstance(part, ast.stmt)]
        last = max([node.lineno, *(getattr(part, "end_lineno", node.lineno) for part in header)])
        comments = self.source.comments
        beside = [comments[line] for line in range(node.lineno, last + 1) if line in comments]
        yield from comment(" ".join([*self.source.above(node.lineno), *beside]), len(self.scopes.blocks[node]))

    def _body(self, statements: Sequence[ast.stmt]) -> Iterator[str]:
        for statement in statements:
            yield from self._remarks(statement)
            yield from self._declarations(statement)
            yield from self._statement(statement)

    def _declarations(self, statement: ast.stmt) -> Iterator[str]:
        """Yield the declarations, without a value, of locals whose block begins to use them inside this statement."""
        for name, local in self.scopes.locals.items():
            inside = self._holder(local) is statement
            if inside and not self._declares(statement, name):
                yield f"{self.ctype(self._kind(name, statement))} {local.name};"

    def _holder(self, local: Local) -> ast.stmt:
        """Return the statement of the local's block that holds its first use."""
        if local.holder is None:
            candidates = [s for s, path in self.scopes.blocks.items() if path == local.block]
            local.holder = next(s for s in candidates if any(part is local.first for part in ast.walk(s)))
        return local.holder

    def _declares(self, statement: ast.stmt, name: str) -> bool:
        """Whether the assignment can be the declaration: it is the first use, in the very block of all uses."""
        if not isinstance(statement, ast.Assign) or not isinstance(statement.targets[0], ast.Name):
            return False
        local = self.scopes.locals[name]
        own_block = self.scopes.blocks[statement] == local.block
        return statement.targets[0].id == name and local.first is statement and own_block

    def _kind(self, name: str, statement: ast.stmt) -> str:
        """Return the type of a local from its first assignment inside a statement."""
        if self.kernel.trusted:
            raise self.source.fail(statement, f"{name} gets its value inside a branch", "assign it before")
        kind = check(self.kernel).locals[name].kind
        self.scopes.locals[name].value = Value(kind)
        return kind

    def _statement(self, node: ast.stmt) -> Iterator[str]:
        if isinstance(node, ast.Assign):
            yield self._assign(node)
        elif isinstance(node, ast.AugAssign):
            yield f"{self._place(node.target)} = {self._augmented(node)};"
        elif isinstance(node, ast.If):
            yield from self._if(node, "if")
        elif isinstance(node, ast.For):
            yield from self._for(node)
        elif isinstance(node, ast.Return):
            if node.value is not None:
                yield f"return {self.terms.term(node.value).text};"
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            term = self.terms.term(node.value)
            yield f"{'' if term.kind == 'none' else '(void)'}{term.text};"
        elif isinstance(node, ast.Break):
            yield "break;"
        elif not isinstance(node, ast.Pass):
            mend = "write it within the subset, see kernels/subset.py"
            raise self.source.fail(node, f"{type(node).__name__} cannot be translated to C", mend)

    def _assign(self, node: ast.Assign) -> str:
        target, term = node.targets[0], self.terms.term(node.value)
        if not isinstance(target, ast.Name):
            return f"{self._place(target)} = {term.text};"
        local = self.scopes.locals[target.id]
        if local.value is None:
            local.value = Value(term.kind)
        if not self._declares(node, target.id):
            return f"{local.name} = {term.text};"
        constant = "const " if local.stores == 1 else ""
        ignored = "" if local.loads else f" (void){local.name};"
        return f"{constant}{self.ctype(term.kind)} {local.name} = {term.text};{ignored}"

    def _place(self, target: ast.expr) -> str:
        return self.terms.term(loaded(target)).text

    def _augmented(self, node: ast.AugAssign) -> str:
        return self.terms.binary(node.op, loaded(node.target), node.value).text

    def _if(self, node: ast.If, keyword: str) -> Iterator[str]:
        yield f"{keyword} ({self.terms.term(node.test).text})"
        yield "{"
        yield from indented(self._body(node.body))
        yield "}"
        other = node.orelse
        if len(other) == 1 and isinstance(other[0], ast.If) and not list(self._declarations(other[0])):
            yield from self._elif(other[0])
        elif other:
            yield "else"
            yield "{"
            yield from indented(self._body(other))
            yield "}"
        elif keyword == "else if":
            yield "else"
            yield "{"
            yield "    /* nothing else to do */"
            yield "}"

    def _elif(self, node: ast.If) -> Iterator[str]:
        yield from self._remarks(node)
        yield from self._if(node, "else if")

    def _for(self, node: ast.For) -> Iterator[str]:
        assert isinstance(node.iter, ast.Call)
        assert isinstance(node.target, ast.Name)
        bounds = node.iter.args
        name = self.loops[node.target.id]
        start = "0" if len(bounds) == 1 else self.terms.term(bounds[0]).text
        stop = bounds[0] if len(bounds) == 1 else bounds[1]
        step = ast.literal_eval(bounds[2]) if len(bounds) == 3 else 1
        end = self.terms.term(stop)
        limit = end.inside()
        integer = self.precision.integer
        if not self._constant(stop, node):
            limit = self._free(f"{name}_end")
            yield f"const {integer} {limit} = {end.text};"
        sign = "<" if step > 0 else ">"
        change = {1: f"{name}++", -1: f"{name}--"}.get(step, f"{name} += {step}" if step > 0 else f"{name} -= {-step}")
        yield f"for ({integer} {name} = {start}; {name} {sign} {limit}; {change})"
        yield "{"
        yield from indented(self._body(node.body))
        yield "}"

    def _constant(self, stop: ast.expr, loop: ast.For) -> bool:
        """Whether the end of a loop surely stays what it was: Python looks at it once, C every turn.

        A field may change under another name, where one record is passed twice.
        """
        stored = {
            n.id for s in loop.body for n in ast.walk(s) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        }
        reads = [node for node in ast.walk(stop) if isinstance(node, ast.Name)]
        moving = any(isinstance(node, ast.Call | ast.Attribute) for node in ast.walk(stop))
        return not moving and not any(node.id in stored for node in reads)
