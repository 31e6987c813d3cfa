"""`python -m psp_cli` is `psp`."""

from .main import app

app(prog_name="psp")
