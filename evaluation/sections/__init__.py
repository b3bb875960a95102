"""Sections of the study, one per file."""
