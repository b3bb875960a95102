"""Timing diagrams of the AXI edges, from a simulation; ``python docs/tools/timing.py`` prints them.

A frame of 17x17 pixels with a bright square goes through a small core. The source pauses once, and
the records have to wait once. Then it goes through a core of four pixels per clock.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from amaranth.sim import Simulator, SimulatorContext

from cornerstream import AxiCore, Build

SIDE = 17
SOURCE = ("s_axis_tvalid", "s_axis_tready", "s_axis_tdata", "s_axis_tuser", "s_axis_tlast")
BEATS = ("s_axis_tvalid", "s_axis_tready", "s_axis_tdata", "s_axis_tkeep", "s_axis_tuser", "s_axis_tlast")
RECORDS = ("m_axis_tvalid", "m_axis_tready", "m_axis_tdata", "m_axis_tlast")
PAUSE_AT = 2
"""Pixels before the source pauses for two clocks."""
WAIT = 3
"""Clocks that the first record waits for."""
END_OF_FRAME = 0b11 << 61
LANES = 4


def core(lanes: int = 1) -> AxiCore:
    return AxiCore(Build(max_width=SIDE, max_height=SIDE, autostart=True, pixels_per_clock=lanes))


def picture() -> np.ndarray:
    image = np.full((SIDE, SIDE), 16, np.uint8)
    image[8:, 8:] = 200
    return image


def run() -> list[dict[str, int]]:
    """Each clock's values at the ports, from the first pixel to the end of the packet."""
    design, samples = core(), []
    image = picture()

    async def bench(ctx: SimulatorContext) -> None:
        ctx.set(design.m_axis_tready, 1)
        await ctx.tick().repeat(4)
        sent, paused, waited = 0, 0, 0
        while True:
            pause = sent == PAUSE_AT and paused < 2
            valid = sent < image.size and not pause
            paused += pause
            row, column = divmod(min(sent, image.size - 1), SIDE)
            ctx.set(design.s_axis_tvalid, valid)
            ctx.set(design.s_axis_tdata, int(image[row, column]) if valid else 0)
            ctx.set(design.s_axis_tuser, valid and sent == 0)
            ctx.set(design.s_axis_tlast, valid and column == SIDE - 1)
            waiting = ctx.get(design.m_axis_tvalid) and waited < WAIT
            waited += bool(waiting)
            ctx.set(design.m_axis_tready, not waiting)
            sample = {name: int(ctx.get(getattr(design, name))) for name in (*SOURCE, *RECORDS)}
            samples.append(sample)
            sent += sample["s_axis_tvalid"] and sample["s_axis_tready"]
            await ctx.tick()
            if sample["m_axis_tvalid"] and sample["m_axis_tready"] and sample["m_axis_tlast"]:
                return

    simulator = Simulator(design)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return samples


def told(port: str, sample: dict[str, int]) -> str:
    """What stands on a data port: a pixel's number, a corner's record or the frame's end."""
    if not sample[port.replace("tdata", "tvalid")]:
        return "·"
    data = sample[port]
    if port.startswith("s_"):
        return str(data)
    return "END" if data & END_OF_FRAME == END_OF_FRAME else "REC"


def columns(first: int, pixels: int) -> str:
    """Which pixels of a line are in a beat."""
    return f"{first}-{first + pixels - 1}" if pixels > 1 else str(first)


def beats() -> list[dict[str, Any]]:
    """Each clock's values at the input of a core of four pixels per clock, for two lines.

    In place of the data there are the columns of the pixels.
    """
    design, samples = core(LANES), []
    image = picture()

    async def bench(ctx: SimulatorContext) -> None:
        await ctx.tick().repeat(4)
        sent = 0
        while sent < 2 * -(-SIDE // LANES):
            row, beat = divmod(sent, -(-SIDE // LANES))
            pixels = image[row, LANES * beat : LANES * (beat + 1)].tolist()
            ctx.set(design.s_axis_tvalid, 1)
            ctx.set(design.s_axis_tdata, int.from_bytes(bytes(pixels), "little"))
            ctx.set(design.s_axis_tkeep, (1 << len(pixels)) - 1)
            ctx.set(design.s_axis_tuser, sent == 0)
            ctx.set(design.s_axis_tlast, len(pixels) < LANES)
            sample: dict[str, Any] = {name: int(ctx.get(getattr(design, name))) for name in BEATS}
            sample["s_axis_tdata"] = columns(LANES * beat, len(pixels))
            samples.append(sample)
            sent += sample["s_axis_tready"]
            await ctx.tick()

    simulator = Simulator(design)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return samples


def diagram(samples: list[dict[str, Any]], ports: tuple[str, ...], clocks: range, wide: int = 4) -> str:
    """One line per port, ``wide`` characters per clock."""
    lines = ["clock".ljust(14) + "".join(f"{clock:^{wide}}" for clock in clocks)]
    for port in ports:
        line = port.ljust(14)
        for clock in clocks:
            sample = samples[clock]
            if port.endswith("tdata"):
                line += f"{told(port, sample):^{wide}}"
            elif port.endswith("tkeep"):
                line += f"{sample[port]:0{LANES}b}".center(wide)
            else:
                line += ("▆" if sample[port] else "▁") * wide
        lines.append(line)
    return "\n".join(line.rstrip() for line in lines)


def diagrams() -> list[str]:
    """The start of the frame, the end of its first line, its packet of records, and beats."""
    samples = run()
    record = next(clock for clock, sample in enumerate(samples) if sample["m_axis_tvalid"])
    return [
        diagram(samples, SOURCE, range(8)),
        diagram(samples, SOURCE, range(SIDE - 2, SIDE + 6)),
        diagram(samples, RECORDS, range(record - 1, len(samples))),
        diagram(beats(), BEATS, range(7), wide=7),
    ]


if __name__ == "__main__":
    print("\n\n".join(diagrams()))
