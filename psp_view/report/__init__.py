"""The report: runs of a platoon in one HTML file that needs no network."""

from .page import report_html, write_report

__all__ = ["report_html", "write_report"]
