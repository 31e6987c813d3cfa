"""`python -m torture`."""

from psp_cli.interrupt import run


def _main() -> int:
    from .runner import main

    return main()


run("torture", _main, all_groups=True)
