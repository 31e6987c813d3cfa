"""What `psp` tells the user to do where the library, which has no options, can only say what is wrong."""

from __future__ import annotations

REMEDIES = {
    "no_room": "make room there and run the same command with --resume",
    "exists": "remove it or give --output another name",
    "unfinished": "go on with --resume, or remove that folder",
    "another_plan": "repeat the options that it was begun with, or remove that folder",
    "part_damaged": "remove it and run the same command with --resume",
    "no_scheduler": "start one, or leave --scheduler out to use this machine",
    "no_checkpoint": "remove it, or leave --resume out",
    "no_tables": "make it with --tables",
    "no_dataset": "make one with psp dataset",
    "unreadable_dataset": "make it again with psp dataset",
    "foreign_dataset": "give a file made by psp dataset",
}
"""Remedies by the keys of `OfflineError`, in the words of the command line."""


def said_of(error: BaseException) -> str:
    """What `psp` says of an error.

    Parameters
    ----------
    error : of the user's making
    """
    from psp_model.offline.errors import OfflineError

    if isinstance(error, OfflineError) and error.key in REMEDIES:
        error = OfflineError(error.problem, REMEDIES[error.key])
    return str(error)
