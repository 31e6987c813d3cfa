"""First on PYTHONPATH, this hides the modules that PSP_HIDDEN names from a Python and from all that it starts."""

from __future__ import annotations

import os
import sys

HIDDEN = set(os.environ.get("PSP_HIDDEN", "").split())


class Hide:
    """Finds none of them."""

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        """What the import system asks first."""
        if name.partition(".")[0] in HIDDEN:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


sys.meta_path.insert(0, Hide())
