"""Quartus: the project that is exported for it, and the reports that it leaves behind."""

from flow.quartus.memories import Memory, find_memories, with_attributes
from flow.quartus.project import project_files
from flow.quartus.summaries import QuartusReport, ReportError, read_report

__all__ = [
    "Memory",
    "QuartusReport",
    "ReportError",
    "find_memories",
    "project_files",
    "read_report",
    "with_attributes",
]
