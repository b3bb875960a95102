"""What a compilation with Quartus leaves behind: ``*.fit.summary``, ``*.sta.summary``, and ``*.fit.rpt`` for M9Ks.

All are plain text. The Fitter's has one line per figure, ``name : used / available ( percent )``, the Timing
Analyzer's three per clock, check and operating condition: type, slack in ns, total negative slack. Blocks of RAM are
counted in the Fitter's long report only, which may be missing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

_FOLDERS = (".", "output_files")
_FIGURES = {
    "le": "Total logic elements",
    "lut4": "Total combinational functions",
    "ff": "Dedicated logic registers",
    "memory_bits": "Total memory bits",
    "multipliers": "Embedded Multiplier 9-bit elements",
}
_CHECK = re.compile(
    r"^Type\s*: (?P<condition>.*?) ?(?P<check>Setup|Hold|Recovery|Removal|Minimum Pulse Width) '(?P<clock>[^']*)'\s*$"
    r"\s*^Slack\s*: (?P<slack>-?\d+(?:\.\d+)?)\s*$",
    re.MULTILINE,
)
_M9K = re.compile(r"^; M9Ks +; ([\d,]+) / ", re.MULTILINE)
_PERIOD = re.compile(r"^\s*set period (\d+(?:\.\d+)?)\s*$", re.MULTILINE)


class ReportError(ValueError):
    """There are no reports of Quartus, or not the expected ones; the message names the file."""


@dataclass(frozen=True)
class QuartusReport:
    """Figures of one compilation, as Quartus gives them.

    Parameters
    ----------
    revision, device, version
        Of the project, and of Quartus.
    le, lut4, ff
        Logic elements: in all, with their LUT used, with their flip-flop used.
    memory_bits, multipliers
        Used; multipliers in elements of 9x9 bits.
    m9k
        Blocks of RAM; None without the Fitter's long report.
    setup_slack, hold_slack
        The smallest of all clocks and operating conditions, in ns; None where the analyzer gives none.
    period
        The clock's, from the project's constraints, in ns; None if it is not found.
    """

    revision: str
    device: str
    version: str
    le: int
    lut4: int
    ff: int
    memory_bits: int
    multipliers: int
    m9k: int | None
    setup_slack: float | None
    hold_slack: float | None
    period: float | None

    @property
    def fmax_mhz(self) -> float | None:
        """The clock at which the setup slack would be zero; None without slack or period.

        With one clock, whose edges alone launch and capture, that is what the Timing Analyzer reports.
        """
        if self.setup_slack is None or self.period is None:
            return None
        return 1000 / (self.period - self.setup_slack)


def read_report(folder: Path) -> QuartusReport:
    """The reports in a project's folder, or in its ``output_files``.

    Raises
    ------
    ReportError
        A report is missing, there are several, or it is no such report of a device with logic elements.
    """
    fit_path, sta_path = (_find(folder, kind) for kind in ("fit", "sta"))
    fit, sta = _read(fit_path), _read(sta_path)
    values = dict(re.findall(r"^ *([^:\n]+?) *: (.*?)\s*$", fit, re.MULTILINE))
    status = values.get("Fitter Status", "missing")
    if not status.startswith("Successful"):
        raise ReportError(f"{fit_path}: Fitter Status is {status!r}; allowed: a successful compilation")
    figures = {field: _figure(values, name, fit_path) for field, name in _FIGURES.items()}
    slacks = [(match["check"], float(match["slack"])) for match in _CHECK.finditer(sta)]
    if not slacks:
        raise ReportError(f"{sta_path}: no slack of any clock; allowed: a summary of the Timing Analyzer")
    version = next((values[name] for name in values if name.endswith(" Version")), "unknown")
    return QuartusReport(
        revision=values.get("Revision Name", "unknown"),
        device=values.get("Device", "unknown"),
        version=f"Quartus {version}",
        setup_slack=min((slack for check, slack in slacks if check == "Setup"), default=None),
        hold_slack=min((slack for check, slack in slacks if check == "Hold"), default=None),
        m9k=_blocks(fit_path.with_suffix(".rpt")),
        period=_period(fit_path.parent, folder),
        **figures,
    )


def _find(folder: Path, kind: str) -> Path:
    if not folder.is_dir():
        raise ReportError(f"{folder} is no folder; allowed: the folder of a compiled Quartus project")
    pattern = f"*.{kind}.summary"
    found = [path for place in _FOLDERS for path in sorted((folder / place).glob(pattern))]
    if len(found) != 1:
        places = " and ".join(str(folder / place) for place in _FOLDERS)
        number = "no" if not found else f"{len(found)} files"
        raise ReportError(f"{number} {pattern} in {places}; allowed: one, of a compiled Quartus project")
    return found[0]


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise ReportError(f"cannot read {path}: {error.strerror}") from error


def _figure(values: dict[str, str], name: str, path: Path) -> int:
    match = re.match(r"([\d,]+)(?: /|$)", values.get(name, ""))
    if match is None:
        raise ReportError(f"{path}: no figure {name!r}; allowed: a Fitter summary of a Cyclone IV device")
    return int(match[1].replace(",", ""))


def _blocks(path: Path) -> int | None:
    if not path.is_file():
        return None
    match = _M9K.search(_read(path))
    return None if match is None else int(match[1].replace(",", ""))


def _period(*folders: Path) -> float | None:
    places = [place for folder in folders for place in (folder, folder.parent)]
    for place in dict.fromkeys(places):
        for path in sorted(place.glob("*.sdc")):
            if match := _PERIOD.search(_read(path)):
                return float(match[1])
    return None
