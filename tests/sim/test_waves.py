"""Waveform files and the GTKWave save files beside them."""

from __future__ import annotations

import re
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from golden import Settings, decode
from golden.frame import response_map
from hdl.build import Build
from hdl.detector import Detector
from sim import EngineName, Stalls, Stimulus, make_engine, simulate_frames
from tests.sim.conftest import EngineFor


@pytest.mark.parametrize("kind", ["amaranth", "compiled"])
def test_waves_of_the_first_clocks(engine_for: EngineFor, kind: EngineName, tmp_path: Path) -> None:
    path = tmp_path / "slice.vcd"
    values = np.arange(100, dtype=np.uint64)
    stimulus = Stimulus({"i": values}, [(0, {"offset": 1})])
    engine = engine_for(kind, "slice")
    capture = engine.run(stimulus, vcd=path, vcd_clocks=20, quiet=5)
    assert capture.clocks == 106
    np.testing.assert_array_equal(capture.outputs["o"], values + 1)

    header, body = path.read_text().split("$enddefinitions $end")
    names = dict(re.findall(r"\$var \w+ 8 (\S+) (\w+)(?: \[7:0\])? \$end", header))
    codes = {name: code for code, name in names.items()}
    shown = re.findall(rf"^b([01]+) {re.escape(codes['o__payload'])}$", body, re.MULTILINE)
    seen = [int(bits, 2) for bits in dict.fromkeys(shown)]
    assert seen[:10] == list(range(10)) and len(seen) in (20, 21)

    # later runs without waves are as before
    np.testing.assert_array_equal(engine.run(stimulus, quiet=5).outputs["o"], values + 1)


def variables(path: Path) -> set[str]:
    """Full names of everything in a VCD file."""
    scope: list[str] = []
    names = set()
    for line in path.read_text().split("$enddefinitions")[0].splitlines():
        words = line.split()
        if words[:1] == ["$scope"]:
            scope.append(words[2])
        elif words[:1] == ["$upscope"]:
            scope.pop()
        elif words[:1] == ["$var"]:
            names.add(".".join([*scope, words[4]]))
    return names


@pytest.mark.parametrize("kind", ["amaranth", "compiled", "verilog"])
def test_save_file_shows_the_handshakes_first(
    engine_for: EngineFor, kind: EngineName, tmp_path: Path
) -> None:
    path = tmp_path / "slice.vcd"
    engine_for(kind, "slice").run(Stimulus({"i": np.zeros(3, np.uint64)}), vcd=path, quiet=5)
    save = (tmp_path / "slice.gtkw").read_text()
    traces = re.findall(r"^((?:\w+\.)+\w+)(?:\[7:0\])?$", save, re.MULTILINE)
    names = [trace.rpartition(".")[2] for trace in traces]
    handshakes = [f"{stream}__{field}" for stream in "io" for field in ("valid", "ready", "payload")]
    assert [name for name in names if name != "clk"] == [*handshakes, "offset"]
    assert set(traces) <= variables(path)


def listed(path: Path) -> dict[tuple[str, str], tuple[str, slice]]:
    """Per group and trace of a save file: the signal, and the bits, counted from the left."""
    traces: dict[tuple[str, str], tuple[str, slice]] = {}
    group = ""
    for line in path.read_text().splitlines():
        if line.startswith("-"):
            group = "" if group == line[1:] else line[1:]
        elif named := re.fullmatch(r"#\{(.*)\} (.*)", line):
            bits = re.findall(r"\((\d+)\)([\w.$]+)", named[2])
            first, last = int(bits[0][0]), int(bits[-1][0])
            assert bits == [(str(bit), bits[0][1]) for bit in range(first, last + 1)]
            traces[group, named[1]] = (bits[0][1], slice(first, last + 1))
        elif whole := re.fullmatch(r"((?:\w+\.)+[\w$]+)(?:\[\d+:0\])?", line):
            traces[group, whole[1].rpartition(".")[2]] = (whole[1], slice(None))
    return traces


def changes(path: Path) -> dict[str, set[str]]:
    """All values that each signal of a VCD file takes, as bits."""
    header, body = path.read_text().split("$enddefinitions")
    codes: dict[str, tuple[str, int]] = {}
    scope: list[str] = []
    for line in header.splitlines():
        words = line.split()
        if words[:1] == ["$scope"]:
            scope.append(words[2])
        elif words[:1] == ["$upscope"]:
            scope.pop()
        elif words[:1] == ["$var"] and words[1] == "wire":
            codes[".".join([*scope, words[4]])] = (words[3], int(words[2]))
    values: dict[str, set[str]] = {}
    for bits, code in re.findall(r"^(?:b([01]+) |(?=[01]))(\S+)$", body, re.MULTILINE):
        number, code = (bits, code) if bits else (code[0], code[1:])
        values.setdefault(code, set()).add(number)
    return {name: {value.zfill(width) for value in values[code]} for name, (code, width) in codes.items()}


@pytest.mark.parametrize("lanes", [1, 4])
def test_save_file_shows_what_the_detector_does(tmp_path: Path, lanes: int) -> None:
    size = {"max_width": 20, "max_height": 18}
    parameters = Build.profile("paper", **size, buffering="lean", pixels_per_clock=lanes)
    settings = Settings(sigma1=0.001, sigma2=0.8, floor=1, report_rejected=True)
    image = np.random.default_rng(27).integers(0, 256, (18, 20), np.uint8)
    path = tmp_path / "detector.vcd"
    engine = make_engine("amaranth", Detector(parameters))
    stalls = Stalls(0.1, 0.3, seed=1)
    result = simulate_frames(engine, [(image, settings)], parameters, stalls=stalls, vcd=path, vcd_clocks=600)
    corners = decode(result.frames[0].records)
    assert 0 < np.count_nonzero(corners.accepted) < len(corners)

    traces, values = listed(path.with_suffix(".gtkw")), changes(path)
    shown = {trace: {int(value[bits], 2) for value in values[name]} for trace, (name, bits) in traces.items()}
    groups = {group for group, _ in traces}
    assert groups >= {"pixels", "responses", "thresholds", "largest response", "candidates", "records"}
    # settings stay, all rows have the same width, and so few corners make nothing wait
    steady = {trace for trace, seen in shown.items() if len(seen) < 2} - {("thresholds", "last_lanes")}
    assert all(group == "inputs" or name.partition("$")[0].endswith("__ready") for group, name in steady)
    assert shown["records", "x (1/128 px)"] >= set((128 * corners.x).astype(int).tolist())
    assert shown["records", "y (1/128 px)"] >= set((128 * corners.y).astype(int).tolist())
    assert shown["records", "response"] >= set(corners.response.tolist())
    assert shown["records", "textured"] == {0, 1}
    responses = response_map(image, parameters)
    if lanes == 1:
        assert shown["responses", "response"] >= set(responses.ravel().tolist())
    for lane in range(lanes if lanes > 1 else 0):
        assert shown["pixels", f"lane {lane}"] >= set(image[:, lane::lanes].ravel().tolist())
        # a place's response comes with the column that its window ends in
        columns = (np.arange(responses.shape[1]) + 2 * parameters.algorithm.response_margin) % lanes == lane
        assert shown["responses", f"response, lane {lane}"] >= set(responses[:, columns].ravel().tolist())


@pytest.mark.parametrize(
    ("kind", "full"),
    # Amaranth's simulator cannot be put away before it has begun, which is where its waves fail
    [("amaranth", False), *((kind, full) for kind in ("compiled", "verilog") for full in (False, True))],
)
def test_waves_are_whole_or_not_there(
    engine_for: EngineFor, kind: EngineName, full: bool, tmp_path: Path
) -> None:
    """A link stays, and where it leads to are waves; and a full disk is told."""
    path = tmp_path / "waves.vcd"
    path.symlink_to("/dev/full" if full else "there.vcd")
    stimulus = Stimulus({"i": np.zeros(3, np.uint64)})
    engine = engine_for(kind, "slice")
    with pytest.raises(OSError, match="No space left on device") if full else nullcontext():
        engine.run(stimulus, vcd=path, quiet=5)
    assert path.is_symlink()
    assert {each.name for each in tmp_path.iterdir()} == {
        path.name,
        *([] if full else ["there.vcd", "waves.gtkw"]),
    }
    if not full:
        assert f'[dumpfile] "{tmp_path / "there.vcd"}"' in (tmp_path / "waves.gtkw").read_text()


@pytest.mark.parametrize("kind", ["amaranth", "compiled"])
def test_an_interrupted_run_leaves_no_waves(engine_for: EngineFor, kind: EngineName, tmp_path: Path) -> None:
    def interrupt(done: int, total: int) -> None:
        raise KeyboardInterrupt

    engine = engine_for(kind, "slice")
    with pytest.raises(KeyboardInterrupt):
        engine.run(Stimulus({"i": np.zeros(2000, np.uint64)}), interrupt, vcd=tmp_path / "waves.vcd", quiet=5)
    assert list(tmp_path.iterdir()) == []
