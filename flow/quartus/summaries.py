"""Quartus' reports: ``*.fit.summary``, ``*.sta.summary``, and ``*.fit.rpt`` for M9Ks.

All are plain text. The Fitter's has one line per figure, ``name : used / available ( percent )``,
the Timing Analyzer's three per clock, check and operating condition: type, slack in ns, total
negative slack. Blocks of RAM are counted in the Fitter's long report only, which may be missing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

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
_M9K = re.compile(r"^; M9Ks +; ([\d,]{1,20}) / ", re.MULTILINE)
_PERIOD = re.compile(r"^\s*set period (\d+(?:\.\d+)?)\s*$", re.MULTILINE)


class ReportError(ValueError):
    """There are no reports of Quartus, or not the expected ones; the message names the file."""


@dataclass(frozen=True)
class QuartusReport:
    """Figures of one compilation, as Quartus gives them.

    Parameters
    ----------
    revision, device, version
        Revision and device of the project, version of Quartus.
    le, lut4, ff
        Logic elements: in all, with their LUT used, with their flip-flop used.
    memory_bits, multipliers
        Used; multipliers in elements of 9x9 bits.
    m9k
        Blocks of RAM; None without the Fitter's long report.
    setup_slack, hold_slack
        The smallest of all clocks and operating conditions, in ns; None where the analyzer gives
        none.
    period
        Period of the clock in the project's constraints, in ns; None if it is not found.
    missed
        Checks of a clock with negative slack, in words, each for the worst operating condition.
    no_timing
        Why there are no slacks; None if there are slacks.
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
    missed: tuple[str, ...]
    no_timing: str | None

    @property
    def timing_met(self) -> bool | None:
        """Whether no slack is negative; None if there are no slacks."""
        return None if self.no_timing else not self.missed

    @property
    def no_fmax(self) -> str | None:
        """Why there is no Fmax; None if there is one."""
        if self.no_timing is not None:
            return self.no_timing
        if self.setup_slack is None:
            return "the Timing Analyzer's summary has no setup slack"
        if self.period is None:
            return "no .sdc file of the project sets a period"
        return None if self.fmax_mhz else f"setup slack is {self.setup_slack:g} of {self.period:g} ns"

    @property
    def fmax_mhz(self) -> float | None:
        """The clock at which the setup slack would be zero; None without slack or period.

        The Timing Analyzer reports the same where one clock launches and captures all data.
        """
        if self.setup_slack is None or self.period is None or self.setup_slack >= self.period:
            return None
        return 1000 / (self.period - self.setup_slack)


class _Slack(NamedTuple):
    check: str
    clock: str
    condition: str
    slack: float

    def __str__(self) -> str:
        return f"{self.check} of {self.clock} by {-self.slack:.3f} ns ({self.condition})"


def read_report(folder: Path) -> QuartusReport:
    """The reports in a project's folder, or in its ``output_files``.

    Reports of the Timing Analyzer may be missing.

    Raises
    ------
    ReportError
        The Fitter's report is missing, there are several, or it is not one for a device with logic
        elements.
    """
    fit_path = _find(folder, "fit")
    fit = _read(fit_path)
    values = dict(re.findall(r"^ *([^:\n]+?) *: (.*?)\s*$", fit, re.MULTILINE))
    status = values.get("Fitter Status", "missing")
    if not status.startswith("Successful"):
        raise ReportError(f"{fit_path}: Fitter Status is {status!r}; allowed: a successful compilation")
    figures = {field: _figure(values, name, fit_path) for field, name in _FIGURES.items()}
    version = next((values[name] for name in values if name.endswith(" Version")), "unknown")
    slacks, no_timing = _timing(folder)
    return QuartusReport(
        revision=values.get("Revision Name", "unknown"),
        device=values.get("Device", "unknown"),
        version=f"Quartus {version}",
        setup_slack=_smallest(slacks, "Setup"),
        hold_slack=_smallest(slacks, "Hold"),
        m9k=_blocks(fit_path.with_suffix(".rpt")),
        period=_period(fit_path.parent, folder),
        missed=_missed(slacks),
        no_timing=no_timing,
        **figures,
    )


def _timing(folder: Path) -> tuple[list[_Slack], str | None]:
    """All slacks; or the reason why there are none."""
    try:
        path = _find(folder, "sta")
        found = [
            _Slack(match["check"], match["clock"], match["condition"], float(match["slack"]))
            for match in _CHECK.finditer(_read(path))
        ]
    except ReportError as error:
        return [], str(error)
    if not found:
        return [], f"{path}: no slack of any clock; allowed: a summary of the Timing Analyzer"
    return found, None


def _smallest(slacks: list[_Slack], check: str) -> float | None:
    return min((each.slack for each in slacks if each.check == check), default=None)


def _missed(slacks: list[_Slack]) -> tuple[str, ...]:
    worst: dict[tuple[str, str], _Slack] = {}
    for each in slacks:
        known = worst.setdefault((each.check, each.clock), each)
        worst[each.check, each.clock] = min(known, each, key=lambda slack: slack.slack)
    return tuple(str(each) for each in worst.values() if each.slack < 0)


def _find(folder: Path, kind: str) -> Path:
    if not folder.is_dir():
        raise ReportError(f"{folder} is not a folder; allowed: the folder of a compiled Quartus project")
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
        raise ReportError(f"cannot read {path}: {error.strerror}; allowed: a report of Quartus") from error


def _figure(values: dict[str, str], name: str, path: Path) -> int:
    match = re.match(r"([\d,]{1,20})(?: /|$)", values.get(name, ""))
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
