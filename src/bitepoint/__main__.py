"""`python -m bitepoint` is `bitepoint`."""

from bitepoint.cli import main

main()
