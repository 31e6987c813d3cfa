"""Which FMI function may be called in which state: the table of the standard, and nothing of ours."""

from __future__ import annotations

# FMI 2.0.1, section 4.2.4, for a slave without asynchronous steps; "live" is every state but "fatal"
_LIVE = ("instantiated", "initialization", "stepped", "terminated", "error")
_VARIABLES = [f"{kind}" for kind in ("Real", "Integer", "Boolean", "String")]
ALLOWED: dict[str, tuple[str, ...]] = {
    "SetDebugLogging": _LIVE,
    "SetupExperiment": ("instantiated",),
    "EnterInitializationMode": ("instantiated",),
    "ExitInitializationMode": ("initialization",),
    "Terminate": ("stepped",),
    "Reset": _LIVE,
    **{f"Get{kind}": ("initialization", "stepped", "terminated", "error") for kind in _VARIABLES},
    **{f"Set{kind}": ("instantiated", "initialization", "stepped") for kind in _VARIABLES},
    **{f"{how}FMUstate": _LIVE for how in ("Get", "Set", "Free", "Serialize", "DeSerialize")},
    "SerializedFMUstateSize": _LIVE,
    "GetDirectionalDerivative": ("initialization", "stepped", "terminated", "error"),
    "SetRealInputDerivatives": ("instantiated", "initialization", "stepped"),
    "GetRealOutputDerivatives": ("stepped", "terminated", "error"),
    "DoStep": ("stepped",),
    "CancelStep": (),
    **{f"Get{kind}Status": ("stepped", "terminated", "error") for kind in ("", "Real", "Integer", "Boolean", "String")},
}

LEADS_TO = {
    "EnterInitializationMode": "initialization",
    "ExitInitializationMode": "stepped",
    "Terminate": "terminated",
    "Reset": "instantiated",
}
