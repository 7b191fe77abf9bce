"""`bitepoint warmup`: compile ahead."""

from __future__ import annotations

import typer


def warmup() -> None:
    """Compile every plant, controller and filter for this machine, so that the first run need not."""
    from rich.progress import Progress

    from bitepoint.assembly import all_kernels
    from bitepoint.kernels.compiled import is_compiled

    missing = [kernel for kernel in all_kernels() if not is_compiled(kernel)]
    with Progress(transient=True) as progress:
        for kernel in progress.track(missing, description="compiling"):
            kernel.entry("compiled")
    typer.echo(f"{len(missing)} kernels compiled, {len(all_kernels()) - len(missing)} were ready")
