"""Where `psp` starts: Ctrl-C is looked after before anything is imported that takes time."""

try:
    from .interrupt import run
except KeyboardInterrupt:
    import os

    os.write(2, b"psp: interrupted\n")
    os._exit(130)


def main() -> None:
    """`psp`."""
    run("psp", _app)


def _app() -> None:
    from .main import app

    app(prog_name="psp")
