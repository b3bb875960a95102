"""The version of the Python packages and of every generated file, in one place."""

VERSION = "0.6.0"
