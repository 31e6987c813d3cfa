"""`python -m psp_cli` is `psp`."""

from .entry import main

main()
