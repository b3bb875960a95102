"""cocotb against Verilog: that good parts pass, and that each kind of trouble is told."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Literal

import find_libpython
import pytest
from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from flow.verilog import convert
from hdl.parts.stream import SkidBuffer
from sim.cocotb_bench import Bench, BenchError, CocotbNotFoundError, Result, build_bench, check

MODULE = "tests.benches.bench_skid"
Fault = Literal["", "data", "unstable", "hasty"]


class Skid(wiring.Component):
    """A skid buffer and four registers behind ports as the core has them."""

    def __init__(self, fault: Fault = "") -> None:
        self._fault = fault
        stream_in = {"tdata": In(8), "tvalid": In(1), "tready": Out(1), "tuser": In(1), "tlast": In(1)}
        stream_out = {"tdata": Out(64), "tvalid": Out(1), "tready": In(1), "tuser": Out(1), "tlast": Out(1)}
        lite = {"awaddr": In(8), "awprot": In(3), "awvalid": In(1), "awready": Out(1)}
        lite |= {"wdata": In(32), "wstrb": In(4), "wvalid": In(1), "wready": Out(1)}
        lite |= {"bresp": Out(2), "bvalid": Out(1), "bready": In(1)}
        lite |= {"araddr": In(8), "arprot": In(3), "arvalid": In(1), "arready": Out(1)}
        lite |= {"rdata": Out(32), "rresp": Out(2), "rvalid": Out(1), "rready": In(1)}
        members: dict[str, Any] = {}
        for prefix, ports in {"s_axis": stream_in, "m_axis": stream_out, "s_axil": lite}.items():
            members |= {f"{prefix}_{name}": port for name, port in ports.items()}
        super().__init__(members)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.skid = skid = SkidBuffer(data.StructLayout({"data": 8, "user": 1, "last": 1}))
        i, o = skid.i, skid.o
        m.d.comb += [
            i.payload.eq(Cat(self.s_axis_tdata, self.s_axis_tuser, self.s_axis_tlast)),
            i.valid.eq(self.s_axis_tvalid),
            self.s_axis_tready.eq(i.ready),
            self.m_axis_tdata.eq(o.payload.data),
            Cat(self.m_axis_tuser, self.m_axis_tlast).eq(Cat(o.payload.user, o.payload.last)),
            self.m_axis_tvalid.eq(o.valid),
            o.ready.eq(self.m_axis_tready),
        ]
        stalled = Signal()
        m.d.sync += stalled.eq(o.valid & ~o.ready)
        match self._fault:
            case "data":
                m.d.comb += self.m_axis_tdata.eq(o.payload.data ^ 8)
            case "unstable":
                m.d.comb += self.m_axis_tdata.eq(o.payload.data ^ stalled)
            case "hasty":
                m.d.comb += self.m_axis_tvalid.eq(o.valid & ~(stalled & ~o.ready))
        self._registers(m)
        return m

    def _registers(self, m: Module) -> None:
        words = [Signal(32, name=f"word_{k}") for k in range(4)]
        write, read = Signal(), Signal()
        m.d.comb += [
            write.eq(self.s_axil_awvalid & self.s_axil_wvalid & ~self.s_axil_bvalid),
            Cat(self.s_axil_awready, self.s_axil_wready).eq(write.replicate(2)),
            read.eq(self.s_axil_arvalid & ~self.s_axil_rvalid),
            self.s_axil_arready.eq(read),
        ]
        with m.If(self.s_axil_bready):
            m.d.sync += self.s_axil_bvalid.eq(0)
        with m.If(write):
            m.d.sync += [self.s_axil_bvalid.eq(1), self.s_axil_bresp.eq(Mux(self.s_axil_awaddr < 16, 0, 2))]
        with m.If(self.s_axil_rready):
            m.d.sync += self.s_axil_rvalid.eq(0)
        with m.If(read):
            m.d.sync += [self.s_axil_rvalid.eq(1), self.s_axil_rdata.eq(0)]
            m.d.sync += self.s_axil_rresp.eq(Mux(self.s_axil_araddr < 16, 0, 2))
        for k, word in enumerate(words):
            with m.If(read & (self.s_axil_araddr[2:] == k)):
                m.d.sync += self.s_axil_rdata.eq(word)
            for lane in range(4):
                byte = slice(8 * lane, 8 * lane + 8)
                with m.If(write & (self.s_axil_awaddr[2:] == k) & self.s_axil_wstrb[lane]):
                    m.d.sync += word[byte].eq(self.s_axil_wdata[byte])


def bench_of(fault: Fault = "", told: list[str] | None = None) -> Bench:
    text = convert(Skid(fault), "skid", [])
    return build_bench(text, notify=([] if told is None else told).append)


def failure(bench: Bench, folder: Path, test: str) -> str:
    [result] = bench.run(MODULE, folder=folder, tests=[test])
    assert not result.passed
    with pytest.raises(AssertionError, match=r"^1 of 1 tests failed"):
        check([result])
    return result.message


@pytest.fixture(scope="module")
def bench() -> Bench:
    return bench_of()


def test_frames_pass_whatever_pauses(bench: Bench, tmp_path: Path) -> None:
    results = bench.run(MODULE, folder=tmp_path, tests=["frames", "reset_amid_a_frame"], seed=5)
    check(results)
    assert len(results) == 5
    still, *_, paused = results[:4]
    assert still.name == "frames/source_pauses=0.0/sink_pauses=0.0"
    assert 180 < still.clocks < 220
    assert paused.clocks > 1.5 * still.clocks
    assert still.seconds < 60
    assert "frames 3, beats 180, stalls 0\n" in still.output


def test_parameters_come_in_the_environment(bench: Bench, tmp_path: Path) -> None:
    [result] = bench.run(
        MODULE,
        folder=tmp_path,
        tests=["frames/source_pauses=0.0/sink_pauses=0.5"],
        environment={"FRAMES": "1"},
    )
    check([result])
    assert "frames 1, beats 60, stalls" in result.output


def test_runs_with_one_seed_are_the_same(bench: Bench, tmp_path: Path) -> None:
    def clocks(seed: int) -> list[int]:
        return [result.clocks for result in bench.run(MODULE, folder=tmp_path, tests=["frames"], seed=seed)]

    first = clocks(1)
    assert clocks(1) == first
    assert clocks(2) != first


def test_registers_are_read_and_written(bench: Bench, tmp_path: Path) -> None:
    check(bench.run(MODULE, folder=tmp_path, tests=["registers"]))


def test_the_environment_of_whoever_runs_it_is_no_matter(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COCOTB_TEST_FILTER", "nothing")
    monkeypatch.setenv("PYTEST_ADDOPTS", "--no-such-option")
    monkeypatch.setenv("PYTHONWARNINGS", "error")
    check(bench.run(MODULE, folder=tmp_path, tests=["registers"]))


def test_only_ports_are_visible(bench: Bench, tmp_path: Path) -> None:
    assert {"clk", "rst", "m_axis_tdata", "s_axil_awaddr"} <= bench.ports
    (tmp_path / "bench_inside.py").write_text(
        "import cocotb\n@cocotb.test()\nasync def inside(dut):\n    print('sees', sorted(dut._name for dut in dut))\n"
    )
    [result] = bench.run("bench_inside", folder=tmp_path)
    assert f"sees {sorted(bench.ports)}" in result.output


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("data", "assert ["),
        ("unstable", "m_axis_tdata changed from "),
        ("hasty", "m_axis_tvalid fell before the beat was taken"),
    ],
)
def test_a_wrong_component_fails(tmp_path: Path, fault: Fault, message: str) -> None:
    text = failure(bench_of(fault), tmp_path, "frames/source_pauses=0.5/sink_pauses=0.5")
    assert text.startswith(f"AssertionError: {message}")
    assert "Traceback" in text


def test_an_unexpected_answer_fails(bench: Bench, tmp_path: Path) -> None:
    text = failure(bench, tmp_path, "unexpected_answer")
    assert "read of 0x10: <AxiResp.SLVERR: 2> instead of <AxiResp.OKAY: 0>" in text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import nowhere_to_be_found\n", r"no results(.|\n)*No module named 'nowhere_to_be_found'"),
        (
            "import cocotb, os\n@cocotb.test()\nasync def falls(dut):\n    print('here')\n    os.abort()\n",
            r"no results \(exit code -6\)(.|\n)*here",
        ),
        ("answer = 42\n", "no tests|no results"),
    ],
)
def test_a_crash_is_told(bench: Bench, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "bench_crash.py").write_text(text)
    with pytest.raises(BenchError, match=message):
        bench.run("bench_crash", folder=tmp_path)


def test_a_test_that_does_not_exist(bench: Bench, tmp_path: Path) -> None:
    with pytest.raises(BenchError, match="no test 'flames'"):
        bench.run(MODULE, folder=tmp_path, tests=["registers", "flames"])


def test_a_bench_that_hangs(bench: Bench, tmp_path: Path) -> None:
    (tmp_path / "bench_hang.py").write_text(
        "import cocotb, time\n@cocotb.test()\nasync def hang(dut):\n    print('asleep')\n    time.sleep(600)\n"
    )
    with pytest.raises(BenchError, match=r"longer than 4 s(.|\n)*asleep"):
        bench.run("bench_hang", folder=tmp_path, timeout=4)


def test_each_text_is_built_once(bench: Bench) -> None:
    told: list[str] = []
    assert bench_of(told=told) == bench
    assert told == []
    assert bench_of("data").executable != bench.executable


def test_check_names_each_failed_test() -> None:
    good = Result("good", True, "", 10, 0.1, "")
    bad = [Result(name, False, f"trouble {name}", 10, 0.1, "") for name in ("first", "second")]
    check([good])
    with pytest.raises(
        AssertionError, match="2 of 3 tests failed\nfirst: trouble first\n\nsecond: trouble second"
    ):
        check([good, *bad])


def test_missing_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cocotb_tools", None)
    with pytest.raises(CocotbNotFoundError, match=r"pip install 'cornerstream\[test\]'"):
        bench_of()


def test_a_python_without_library(bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LIBPYTHON_LOC", raising=False)
    monkeypatch.setattr(find_libpython, "find_libpython", lambda: None)
    with pytest.raises(CocotbNotFoundError, match="allowed: a Python built with --enable-shared"):
        bench.run(MODULE, folder=tmp_path)
