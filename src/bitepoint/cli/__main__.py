"""`python -m bitepoint.cli` is `bitepoint`."""

from bitepoint.cli import main

main()
