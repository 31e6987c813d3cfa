"""Torture tests: the long form is `make torture`, the short form is test_short_form.py with small counts.

A file per trial; registry.py lists them, runner.py runs them in chunks, each in a process of its own.
"""
