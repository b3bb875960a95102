"""The version, in one place: of the Python packages and of every file that leaves the house."""

VERSION = "0.3.0"
