"""The package: all that makes the core usable in other designs, tools and programs."""

from flow.package.project import MANIFEST, PackageInterface, package_files, registers_page, software_files
from flow.package.registers import driver_map

__all__ = ["MANIFEST", "PackageInterface", "driver_map", "package_files", "registers_page", "software_files"]
