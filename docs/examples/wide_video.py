"""Four pixels per clock in an Amaranth design of your own: the strongest corner of each frame.

python wide_video.py               simulate three frames and print their strongest corners
python wide_video.py strongest.v   write the whole design as Verilog
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from amaranth.back import verilog
from amaranth.hdl import Module, Signal, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator, SimulatorContext
from numpy.typing import NDArray

from cornerstream import Build, Detector, Settings

Image = NDArray[np.uint8]

# a line of 50 pixels is 13 beats: two of the last one's lanes do not count
WIDTH, HEIGHT, LANES = 50, 32, 4
BUILD = Build(max_width=WIDTH, max_height=HEIGHT, pixels_per_clock=LANES)
SETTINGS = Settings.default(BUILD, sigma1=0.1)
BEAT = data.ArrayLayout(unsigned(BUILD.pixel_bits), LANES)


class StrongestCorner(wiring.Component):
    """Keeps the corner with the largest response.

    Members
    -------
    beats
        Stream of four pixels side by side, the leftmost first; every line begins with a beat of its
        own.
    x, y, response
        Of the strongest corner of the last frame that has ended: x and y in 1/128 pixel; all 0 if
        the frame had none.
    done
        High for one clock when these are new.
    """

    def __init__(self) -> None:
        super().__init__(
            {
                "beats": In(stream.Signature(BEAT)),
                "x": Out(20),
                "y": Out(20),
                "response": Out(21),
                "done": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.detector = detector = Detector(BUILD)
        wiring.connect(m, wiring.flipped(self.beats), detector.i)
        m.d.comb += [detector.width.eq(WIDTH), detector.height.eq(HEIGHT), detector.o.ready.eq(1)]
        for name, value in SETTINGS.fixed(BUILD).items():
            m.d.comb += getattr(detector, name).eq(value)

        # docs/reference/record.md: 20 bits each of x and y, 21 of the response
        record = detector.o.payload.record
        best = Signal(61)
        m.d.sync += self.done.eq(0)
        with m.If(detector.o.valid & detector.o.payload.last):
            m.d.sync += [
                self.x.eq(best[:20]),
                self.y.eq(best[20:40]),
                self.response.eq(best[40:]),
                self.done.eq(1),
                best.eq(0),
            ]
        with m.Elif(detector.o.valid & (record[40:61] > best[40:])):
            m.d.sync += best.eq(record)
        return m


def beats(image: Image) -> list[list[int]]:
    """The lines of an image, four pixels to a beat; what fills a line's last beat is ignored."""
    padded = np.pad(image, [(0, 0), (0, -image.shape[1] % LANES)], constant_values=255)
    return padded.reshape(-1, LANES).tolist()  # type: ignore[no-any-return]


def frames(count: int) -> list[Image]:
    """A bright square and a brighter one, which is further to the right in each frame."""
    result = []
    for number in range(count):
        image = np.full((HEIGHT, WIDTH), 30, np.uint8)
        image[8:16, 8:16] = 120
        image[17:25, 20 + 5 * number : 28 + 5 * number] = 220
        result.append(image)
    return result


def simulate(images: list[Image]) -> list[tuple[float, float, int]]:
    """Position and response of each frame's strongest corner, by Amaranth's simulator."""
    design = StrongestCorner()
    found: list[tuple[float, float, int]] = []

    async def send(ctx: SimulatorContext) -> None:
        ctx.set(design.beats.valid, 1)
        for image in images:
            for beat in beats(image):
                ctx.set(design.beats.payload, beat)
                await ctx.tick().until(design.beats.ready)
        ctx.set(design.beats.valid, 0)

    async def receive(ctx: SimulatorContext) -> None:
        while len(found) < len(images):
            values = (design.x, design.y, design.response)
            x, y, response = await ctx.tick().sample(*values).until(design.done)
            found.append((x / 128, y / 128, response))

    simulator = Simulator(design)
    simulator.add_clock(1e-8)
    simulator.add_testbench(send, background=True)
    simulator.add_testbench(receive)
    simulator.run()
    return found


def main() -> None:
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(verilog.convert(StrongestCorner(), name="strongest_corner"))
    else:
        for number, (x, y, response) in enumerate(simulate(frames(3))):
            print(f"frame {number}: corner at ({x:.2f}, {y:.2f}), response {response}")


if __name__ == "__main__":
    main()
