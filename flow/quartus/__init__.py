"""Quartus: the project that is exported for it, and the reports that it leaves behind."""

from flow.quartus.memories import Memory, find_memories, with_attributes
from flow.quartus.project import DEVICE, FAMILY, Port, ports_of, project_files, split_modules
from flow.quartus.summaries import QuartusReport, ReportError, read_report

__all__ = [
    "DEVICE",
    "FAMILY",
    "Memory",
    "Port",
    "QuartusReport",
    "ReportError",
    "find_memories",
    "ports_of",
    "project_files",
    "read_report",
    "split_modules",
    "with_attributes",
]
