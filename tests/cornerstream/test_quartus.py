"""The commands around Quartus: a folder written whole or not at all, and reports read back."""

from __future__ import annotations

import json
import os
import re
import shlex
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from flow import quartus
from flow.devices import DEFAULT_DEVICE, DEVICES
from hdl.build import Build
from tests.support.runner import contents
from tests.support.runner import run_or_refuse as run

SIZE = ("--max-width", "40", "--max-height", "32")

# each project takes seconds to make
project_files = cache(quartus.project_files)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cornerstream.quartus.project_files", project_files)
    return tmp_path


def test_export_writes_the_project() -> None:
    result = run("quartus", "export", "-o", "deep/project", *SIZE, "--profile", "robust", "--clock", "150")
    parameters = Build.profile("robust", max_width=40, max_height=32)
    assert contents(Path("deep/project")) == project_files(
        parameters, DEVICES[DEFAULT_DEVICE], clock_mhz=150.0, name="cornerstream"
    )
    assert "set period 6.6667\n" in Path("deep/project/cornerstream.sdc").read_text()
    assert result.stdout == "" and "Written: deep/project, " in result.stderr
    assert "quartus_sh -t compile.tcl" in Path("deep/project/README.md").read_text()
    # nothing else, such as folders half made
    assert [path.name for path in Path("deep").iterdir()] == ["project"]
    assert os.stat("deep/project").st_mode & 0o777 == 0o777 & ~_umask()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_a_named_project_and_the_command_that_writes_it() -> None:
    run("quartus", "export", "-o", "project", *SIZE, "--name", "corners_b", "--clock", "133.25")
    found = contents(Path("project"))
    assert {"rtl/corners_b.v", "corners_b.qpf", "corners_b.qsf", "corners_b.sdc"} <= found.keys()
    assert "set_global_assignment -name TOP_LEVEL_ENTITY corners_b\n" in found["corners_b.qsf"]
    assert "project_open -revision corners_b corners_b\n" in found["compile.tcl"]
    assert not any("cornerstream_" in text for text in found.values())
    (line,) = re.findall(r"^cornerstream (quartus export .*)$", found["README.md"], re.MULTILINE)
    run(*shlex.split(line), "-o", "again")
    assert contents(Path("again")) == found
    # the next one may be called otherwise
    run("quartus", "export", "-o", "project", *SIZE)
    assert not Path("project/corners_b.qpf").exists() and Path("project/cornerstream.qpf").is_file()


def test_another_device_and_one_that_quartus_does_not_know() -> None:
    result = run("quartus", "export", "-o", "project", *SIZE, "--device", "ep4ce115f29c7")
    assert " files: EP4CE115F29C7, " in result.stderr
    settings = Path("project/cornerstream.qsf").read_text()
    assert "-name DEVICE EP4CE115F29C7\n" in settings and '-name FAMILY "Cyclone IV E"\n' in settings
    for device in ("lfe5u-45f", "EP4CE115F29"):
        refused = run("quartus", "export", "-o", "other", *SIZE, "--device", device, code=2).stderr
        assert f"device is '{device}'; allowed: ep4ce6, " in refused and "lfe5u-85f" not in refused
    assert not Path("other").exists()


def test_another_export_replaces_the_first_and_keeps_what_quartus_made() -> None:
    run("quartus", "export", "-o", "project", *SIZE)
    Path("project/output_files").mkdir()
    Path("project/output_files/cornerstream.fit.summary").write_text("of Quartus")
    # a block that the earlier export had, and one that is none of ours
    manifest = json.loads(Path("project/cornerstream.json").read_text())
    manifest["files"] += ["rtl/cornerstream_gone.v", "../outside.v"]
    Path("project/cornerstream.json").write_text(json.dumps(manifest))
    for name in ("project/rtl/cornerstream_gone.v", "project/rtl/mine.v", "outside.v"):
        Path(name).write_text("module gone; endmodule\n")
    run("quartus", "export", "-o", "project", *SIZE, "--buffering", "banked")
    found = contents(Path("project"))
    assert found.pop("output_files/cornerstream.fit.summary") == "of Quartus"
    assert found.pop("rtl/mine.v") and Path("outside.v").exists()
    assert found == project_files(
        Build(buffering="banked", max_width=40, max_height=32),
        DEVICES[DEFAULT_DEVICE],
        clock_mhz=100.0,
        name="cornerstream",
    )


@pytest.mark.parametrize("manifest", [None, "{}", '{"files": 3}', "[]", "no JSON"])
def test_a_foreign_folder_is_left_alone(manifest: str | None) -> None:
    Path("mine").mkdir()
    Path("mine/thesis.tex").write_text("years of work")
    if manifest is not None:
        Path("mine/cornerstream.json").write_text(manifest)
    before = contents(Path("mine"))
    result = run("quartus", "export", "-o", "mine", *SIZE, code=2)
    assert (
        "mine holds files that are not an earlier export; allowed: an empty or a new folder" in result.stderr
    )
    assert contents(Path("mine")) == before
    run("quartus", "export", "-o", "mine", *SIZE, "--force")
    assert Path("mine/thesis.tex").read_text() == "years of work"
    assert Path("mine/compile.tcl").is_file()


def test_an_empty_folder_will_do() -> None:
    Path("empty").mkdir()
    run("quartus", "export", "-o", "empty", *SIZE)
    assert Path("empty/cornerstream.qpf").is_file()


def test_nothing_is_half_written(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    replace, calls = os.replace, 0

    def full(source: Any, target: Any) -> None:
        nonlocal calls
        calls += 1
        if calls > 5:
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    result = run("quartus", "export", "-o", "project", *SIZE, code=2)
    assert calls > 5 and "No space left on device" in result.stderr
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--clock", "0"), "clock is 0.0; allowed: MHz, more than 0"),
        (("--clock", "fast"), "'fast' is not a valid float"),
        (("--max-width", "12"), "max_width is 12; allowed: whole numbers from 13"),
        (("--fit", "printed"), "fit is 'printed', which only the golden model has"),
        (("-o", "file"), "file is not a folder"),
    ],
)
def test_bad_input(options: tuple[str, ...], message: str, folder: Path) -> None:
    Path("file").touch()
    result = run("quartus", "export", "-o", "project", *SIZE, *options, code=2)
    assert message in result.stderr
    assert [path.name for path in folder.iterdir()] == ["file"]


# Written by hand after the published form of these files: no compilation of this core has been
# seen.
FIT = """\
Fitter Status : Successful - Sun Nov 22 12:00:00 2026
Quartus Prime Version : 22.1std.0 Build 915 10/25/2022 SC Lite Edition
Revision Name : cornerstream
Top-level Entity Name : cornerstream
Family : Cyclone IV GX
Device : EP4CGX150CF23C8
Timing Models : Final
Total logic elements : 5,123 / 149,760 ( 3 % )
    Total combinational functions : 4,100 / 149,760 ( 3 % )
    Dedicated logic registers : 3,456 / 149,760 ( 2 % )
Total registers : 3456
Total pins : 1 / 287 ( < 1 % )
Total virtual pins : 186
Total memory bits : 591,699 / 6,635,520 ( 9 % )
Embedded Multiplier 9-bit elements : 0 / 720 ( 0 % )
Total GXB Receiver Channel PCS : 0 / 4 ( 0 % )
Total GXB Receiver Channel PMA : 0 / 4 ( 0 % )
Total PLLs : 0 / 6 ( 0 % )
"""
STA = """\
------------------------------------------------------------
Timing Analyzer Summary
------------------------------------------------------------

Type  : Slow 1200mV 85C Model Setup 'clk'
Slack : 1.250
TNS   : 0.000

Type  : Slow 1200mV 85C Model Hold 'clk'
Slack : 0.402
TNS   : 0.000

Type  : Slow 1200mV 85C Model Minimum Pulse Width 'clk'
Slack : 0.100
TNS   : 0.000

Type  : Slow 1200mV 0C Model Setup 'clk'
Slack : 1.981
TNS   : 0.000

Type  : Fast 1200mV 0C Model Setup 'clk'
Slack : 5.627
TNS   : 0.000

Type  : Fast 1200mV 0C Model Hold 'clk'
Slack : 0.153
TNS   : 0.000

------------------------------------------------------------
"""


def compiled(fit: str = FIT, sta: str = STA, place: str = "project/output_files") -> None:
    """Leave an exported project as a compilation does."""
    if not Path("project").exists():
        run("quartus", "export", "-o", "project", *SIZE, "--clock", "125")
    Path(place).mkdir(exist_ok=True)
    Path(place, "cornerstream.fit.summary").write_text(fit)
    Path(place, "cornerstream.sta.summary").write_text(sta)


@pytest.mark.parametrize("given", ["project", "project/output_files"])
def test_report_as_json(given: str) -> None:
    compiled()
    assert json.loads(run("quartus", "report", given, "--json").stdout) == {
        "revision": "cornerstream",
        "device": "EP4CGX150CF23C8",
        "version": "Quartus 22.1std.0 Build 915 10/25/2022 SC Lite Edition",
        "le": 5123,
        "lut4": 4100,
        "ff": 3456,
        "memory_bits": 591699,
        "multipliers": 0,
        "m9k": None,
        # the worst of all operating conditions
        "setup_slack": 1.25,
        "hold_slack": 0.153,
        "period": 8.0,
        "fmax_mhz": pytest.approx(1000 / 6.75),
        "no_fmax": None,
        "missed": [],
        "timing_met": True,
    }


def test_keys_are_those_of_the_page() -> None:
    compiled()
    page = (Path(__file__).parents[2] / "docs" / "howto" / "quartus.md").read_text(encoding="utf-8")
    (paragraph,) = re.findall(r"^`quartus report --json` prints .*?\n\n", page, re.MULTILINE | re.DOTALL)
    found = json.loads(run("quartus", "report", "project", "--json").stdout)
    assert set(re.findall(r"`(\w+)`", paragraph)) == set(found)


RPT = """\
+-----------------------------------------------------------+
; Fitter Resource Usage Summary                             ;
+-----------------------------------+-----------------------+
; Resource                          ; Usage                 ;
+-----------------------------------+-----------------------+
; Total LABs:  partially or completely used ; 400 / 9,360 ( 4 % ) ;
; M9Ks                              ; 1,034 / 7,200 ( 14 % ) ;
; Total block memory bits           ; 591,699 / 6,635,520 ( 9 % ) ;
"""


def test_blocks_of_ram_are_in_the_long_report() -> None:
    compiled()
    Path("project/output_files/cornerstream.fit.rpt").write_text(RPT)
    assert json.loads(run("quartus", "report", "project", "--json").stdout)["m9k"] == 1034
    assert "1,034" in run("quartus", "report", "project").stdout
    Path("project/output_files/cornerstream.fit.rpt").write_text("something else")
    assert json.loads(run("quartus", "report", "project", "--json").stdout)["m9k"] is None


def test_report_as_table() -> None:
    compiled()
    # a line may go on in the next one
    text = " ".join(run("quartus", "report", "project").stdout.split())
    for part in (
        "EP4CGX150CF23C8",
        "5,123",
        "4,100",
        "3,456",
        "591,699",
        "1.250 ns",
        "0.153 ns",
        "148.1 MHz",
    ):
        assert part in text
    assert "at a period of 8 ns" in text


def test_older_versions() -> None:
    older = FIT.replace("Quartus Prime Version : 22.1std.0", "Quartus II 64-Bit Version : 10.1")
    compiled(older, STA.replace("Timing Analyzer", "TimeQuest Timing Analyzer"))
    found = json.loads(run("quartus", "report", "project", "--json").stdout)
    assert found["version"].startswith("Quartus 10.1 ") and found["setup_slack"] == 1.25


@pytest.mark.parametrize(
    ("slack", "missed"),
    [
        # 1.981 ns at 0 degrees is the better one
        (" 1.250", "Setup of clk by 2.500 ns (Slow 1200mV 85C Model)"),
        (" 0.153", "Hold of clk by 2.500 ns (Fast 1200mV 0C Model)"),
        (" 0.100", "Minimum Pulse Width of clk by 2.500 ns (Slow 1200mV 85C Model)"),
    ],
)
def test_missed_timing_is_said_and_is_a_failure(slack: str, missed: str) -> None:
    compiled(sta=STA.replace(slack, " -2.500"))
    result = run("quartus", "report", "project", code=1)
    assert result.stderr == f"Error: timing is not met: {missed}\n" and "5,123" in result.stdout
    found = json.loads(run("quartus", "report", "project", "--json", code=1).stdout)
    assert (found["timing_met"], found["missed"]) == (False, [missed])
    assert found["fmax_mhz"] == pytest.approx(1000 / (10.5 if slack == " 1.250" else 6.75))


def test_without_a_period_there_is_slack_but_no_fmax() -> None:
    Path("project").mkdir()
    compiled()
    found = json.loads(run("quartus", "report", "project", "--json").stdout)
    reason = "no .sdc file of the project sets a period"
    assert (found["fmax_mhz"], found["no_fmax"], found["timing_met"]) == (None, reason, True)
    result = run("quartus", "report", "project")
    assert "1.250 ns" in result.stdout and "MHz" not in result.stdout
    assert result.stderr == f"No Fmax: {reason}\n"


def test_without_setup_slack_there_is_no_fmax() -> None:
    compiled(sta=STA.replace("Setup", "Recovery"))
    found = json.loads(run("quartus", "report", "project", "--json").stdout)
    assert found["no_fmax"] == "the Timing Analyzer's summary has no setup slack"


@pytest.mark.parametrize(
    ("sta", "reason"),
    [
        (None, "no *.sta.summary in project and project/output_files; allowed: one, of a compiled"),
        ("", "cornerstream.sta.summary: no slack of any clock; allowed: a summary of the Timing Analyzer"),
        (FIT, "cornerstream.sta.summary: no slack of any clock"),
    ],
)
def test_without_timing_there_is_area_and_the_reason(sta: str | None, reason: str) -> None:
    compiled(sta=sta or "")
    if sta is None:
        Path("project/output_files/cornerstream.sta.summary").unlink()
    result = run("quartus", "report", "project", code=1)
    assert "5,123" in result.stdout and "MHz" not in result.stdout
    (line,) = result.stderr.splitlines()
    assert line.startswith("Error: timing is not known: ") and reason in line
    found = json.loads(run("quartus", "report", "project", "--json", code=1).stdout)
    assert (found["le"], found["fmax_mhz"], found["timing_met"]) == (5123, None, None)
    assert reason in found["no_fmax"]


def without(text: str, line: str) -> str:
    assert line in text
    return "".join(kept for kept in text.splitlines(keepends=True) if line not in kept)


@pytest.mark.parametrize(
    ("fit", "sta", "message"),
    [
        ("", STA, "Fitter Status is 'missing'; allowed: a successful compilation"),
        (FIT.replace("Successful", "Failed"), STA, "Fitter Status is 'Failed - Sun Nov"),
        (without(FIT, "Total logic elements"), STA, "no figure 'Total logic elements'; allowed: a Fitter"),
        (FIT.replace(" 5,123 /", f" {'9' * 5000} /"), STA, "no figure 'Total logic elements'"),
        (FIT.replace(" 591,699 /", " some /"), STA, "no figure 'Total memory bits'"),
    ],
)
def test_foreign_reports(fit: str, sta: str, message: str) -> None:
    compiled(fit, sta)
    assert message in run("quartus", "report", "project", code=2).stderr


def test_missing_reports() -> None:
    assert "nowhere is not a folder" in run("quartus", "report", "nowhere", code=2).stderr
    run("quartus", "export", "-o", "project", *SIZE)
    message = "no *.fit.summary in project and project/output_files; allowed: one, of a compiled"
    assert message in run("quartus", "report", "project", code=2).stderr
    compiled()
    Path("project/other.fit.summary").write_text(FIT)
    assert "2 files *.fit.summary in" in run("quartus", "report", "project", code=2).stderr
