"""Which FMI function may be called in which state: the table of the standard, and nothing of ours."""

from __future__ import annotations

# FMI 2.0.1, section 4.2.4, for a slave without asynchronous steps; "live" is every state but "fatal"
_LIVE = ("instantiated", "initialization", "stepped", "failed", "terminated", "error")
_VARIABLES = [f"{kind}" for kind in ("Real", "Integer", "Boolean", "String")]
ALLOWED: dict[str, tuple[str, ...]] = {
    "SetDebugLogging": _LIVE,
    "SetupExperiment": ("instantiated",),
    "EnterInitializationMode": ("instantiated",),
    "ExitInitializationMode": ("initialization",),
    "Terminate": ("stepped", "failed"),
    "Reset": _LIVE,
    **{f"Get{kind}": ("initialization", "stepped", "failed", "terminated", "error") for kind in _VARIABLES},
    **{f"Set{kind}": ("instantiated", "initialization", "stepped") for kind in _VARIABLES},
    **{f"{how}FMUstate": _LIVE for how in ("Get", "Set", "Free", "Serialize", "DeSerialize")},
    "SerializedFMUstateSize": _LIVE,
    "GetDirectionalDerivative": ("initialization", "stepped", "failed", "terminated", "error"),
    "SetRealInputDerivatives": ("instantiated", "initialization", "stepped"),
    "GetRealOutputDerivatives": ("stepped", "failed", "terminated", "error"),
    "DoStep": ("stepped",),
    "CancelStep": (),
    **dict.fromkeys([f"Get{kind}Status" for kind in ("", *_VARIABLES)], ("stepped", "failed", "terminated", "error")),
}

LEADS_TO = {
    "EnterInitializationMode": "initialization",
    "ExitInitializationMode": "stepped",
    "Terminate": "terminated",
    "Reset": "instantiated",
}
