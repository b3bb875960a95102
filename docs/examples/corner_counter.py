"""The detector inside an Amaranth design of your own: a counter of the corners of each frame.

python corner_counter.py              simulate three frames and print their counts
python corner_counter.py counter.v    write the whole design as Verilog
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from amaranth.back import verilog
from amaranth.hdl import Module, Signal, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator, SimulatorContext
from numpy.typing import NDArray

from cornerstream import Build, Detector, Settings

Image = NDArray[np.uint8]

WIDTH, HEIGHT = 48, 32
BUILD = Build(max_width=WIDTH, max_height=HEIGHT)
SETTINGS = Settings.default(BUILD, sigma1=0.1)


class CornerCounter(wiring.Component):
    """Counts the corners of each frame; nothing of a corner but that it is there is used.

    Members
    -------
    pixels
        Stream of pixels in raster order, frame after frame, one per clock at most.
    count
        Corners of the last frame that has ended.
    done
        High for one clock when ``count`` is new.
    """

    def __init__(self) -> None:
        super().__init__(
            {
                "pixels": In(stream.Signature(unsigned(BUILD.pixel_bits))),
                "count": Out(24),
                "done": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.detector = detector = Detector(BUILD)
        wiring.connect(m, wiring.flipped(self.pixels), detector.i)

        # whatever can change from frame to frame is an input of the detector; here it is constant
        m.d.comb += [detector.width.eq(WIDTH), detector.height.eq(HEIGHT)]
        for name, value in SETTINGS.fixed(BUILD).items():
            m.d.comb += getattr(detector, name).eq(value)

        # one record per corner, then one that ends the frame
        running = Signal.like(self.count)
        m.d.comb += detector.o.ready.eq(1)
        m.d.sync += self.done.eq(0)
        with m.If(detector.o.valid & ~detector.o.payload.last):
            m.d.sync += running.eq(running + 1)
        with m.If(detector.o.valid & detector.o.payload.last):
            m.d.sync += [self.count.eq(running), self.done.eq(1), running.eq(0)]
        return m


def frames(count: int) -> list[Image]:
    """Bright squares on a dark ground, one more in each frame."""
    result = []
    for number in range(1, count + 1):
        image = np.full((HEIGHT, WIDTH), 30, np.uint8)
        for square in range(number):
            image[11:20, 9 + 12 * square : 16 + 12 * square] = 200
        result.append(image)
    return result


def simulate(images: list[Image]) -> list[int]:
    """Counts of the frames, by Amaranth's simulator."""
    counter = CornerCounter()
    counts: list[int] = []

    async def send(ctx: SimulatorContext) -> None:
        ctx.set(counter.pixels.valid, 1)
        for image in images:
            for pixel in image.ravel().tolist():
                ctx.set(counter.pixels.payload, pixel)
                await ctx.tick().until(counter.pixels.ready)
        ctx.set(counter.pixels.valid, 0)

    async def receive(ctx: SimulatorContext) -> None:
        while len(counts) < len(images):
            (count,) = await ctx.tick().sample(counter.count).until(counter.done)
            counts.append(count)

    simulator = Simulator(counter)
    simulator.add_clock(1e-8)
    simulator.add_testbench(send, background=True)
    simulator.add_testbench(receive)
    simulator.run()
    return counts


def main() -> None:
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(verilog.convert(CornerCounter(), name="corner_counter"))
    else:
        for number, count in enumerate(simulate(frames(3))):
            print(f"frame {number}: {count} corners")


if __name__ == "__main__":
    main()
