"""What every driver of this folder shares: the FMU, what to read, and how to say it."""

import json
import sys
from importlib.metadata import version

STOP, STEP = 5.0, 0.01  # [s]
NAMES = ["x[7]", "v[1]", "a[5]", "s[4]", "T_max", "J"]
STEPS = round(STOP / STEP)

fmu = sys.argv[1]


def report(host_version, columns, first=0):
    """Print version and columns for the table; `first` is the sampling instant that the columns begin at."""
    print("RESULT " + json.dumps({"version": host_version, "first": first, "columns": columns}), flush=True)


def installed(package):
    return version(package)
