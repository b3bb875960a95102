"""Waveform files and the GTKWave save files beside them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from sim import EngineName, Stimulus
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
