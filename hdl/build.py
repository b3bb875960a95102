"""How a detector is built: the options that only hardware has, beside the golden model's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Self

from golden.algorithm import FIT_REACH, RESPONSE_FILTER_REACH
from golden.options import option
from golden.parameters import Parameters

Buffering = Literal["banked", "lean"]

PIXELS_PER_CLOCK = (1, 2, 4, 8)

MAX_MULTIPLIERS = 1024

BUILDS: dict[str, dict[str, Any]] = {
    "paper": {"buffering": "banked"},
    "robust": {"buffering": "lean"},
    "precise": {"buffering": "lean"},
}
"""Fields in which a profile differs from the defaults of :class:`Build`."""


@dataclass(frozen=True, kw_only=True)
class Build(Parameters):
    """A detector as hardware: its parameters, and options that never change a record.

    Those change memory, delay or edges.

    Parameters
    ----------
    pixels_per_clock
        Pixels that come in each clock, side by side: 1, 2, 4 or 8, called a beat. A row is a whole
        number of beats; of its last one only the pixels that the width asks for count.
    buffering
        ``"banked"``: N+1 block RAMs per N×N window (Sec. 4.1); ``"lean"``: N-1 rows, one row
        sooner. Changes memory and delay, never a record.
    sqrt_bits_per_stage
        Result bits per pipeline stage of the square root, 1 to 17. Hardware only.
    queue_depth
        Corners that can wait for the subpixel refinement, 8 to 1024, before the input has to. With
        several pixels per clock, twice as many beats with candidates can wait, too. Hardware only:
        changes delays, never a record.
    refinement_units
        Units that refine corners, 1 to 4. 0: as many as photographs need, one, or two with 8 pixels
        per clock. With 4 or 8 pixels per clock each of them is faster. Hardware only: changes
        delays, never a record. Gradient steps have one.
    multipliers
        Squares of gradients, then of the response, that embedded multipliers may find: even, 0 to
        1024; what is beyond is not used. Two of them take the place of a table in block RAM. Each
        takes an element of 9×9 bits, or two where the number has more than 9. Hardware only:
        changes no record and no delay.
    video_out
        Pass the pixels on, as they came, with a corner flag. Hardware only; takes as many rows of
        block RAM as the algorithm's margin has, and with ``"banked"`` one more for each buffer.
    autostart
        Start enabled, with the settings of ``Settings.default`` and the largest frame, for designs
        that write no register. Hardware only.

    Raises
    ------
    ValueError
        A field has a value that is not allowed; the message names the field, its value and what is
        allowed.
    """

    pixels_per_clock: int = option(
        1,
        "Pixels that come in each clock, side by side: 1, 2, 4 or 8.",
        low=PIXELS_PER_CLOCK[0],
        high=PIXELS_PER_CLOCK[-1],
    )
    buffering: Buffering = option(
        "lean",
        "Line buffers of an NxN window: N+1 memories, as the paper has it, or N-1, with less delay.",
    )
    sqrt_bits_per_stage: int = option(
        1, "Result bits per pipeline stage of the square root, 1 to 17.", low=1, high=17
    )
    queue_depth: int = option(
        16,
        "Corners that can wait for the subpixel step before the input has to wait, 8 to 1024.",
        low=8,
        high=1024,
    )
    refinement_units: int = option(
        0, "Units that refine corners, 1 to 4; 0: as many as photographs need.", high=4
    )
    multipliers: int = option(
        0,
        "Embedded multipliers for squares, two in the place of a table in block RAM: even, 0 to 1024.",
        high=MAX_MULTIPLIERS,
    )
    video_out: bool = option(
        False, "Pass the pixels on, too, each with a corner flag; with the AXI edge only."
    )
    autostart: bool = option(
        False, "Start enabled, for designs that write no register; with the AXI or the Avalon edge."
    )

    def __post_init__(self) -> None:
        if self.pixels_per_clock not in PIXELS_PER_CLOCK:
            allowed = ", ".join(map(str, PIXELS_PER_CLOCK))
            raise ValueError(f"pixels_per_clock is {self.pixels_per_clock!r}; allowed: {allowed}")
        super().__post_init__()
        if self.multipliers % 2:
            raise ValueError(
                f"multipliers is {self.multipliers}; allowed: even numbers, 0 to {MAX_MULTIPLIERS}"
            )
        if self.refinement_units > 1 and FIT_REACH[self.algorithm.fit]:
            raise ValueError(
                f"refinement_units is {self.refinement_units}; allowed with fit {self.algorithm.fit!r}: 0, 1"
            )

    @property
    def min_width(self) -> int:
        """Narrowest frame: the algorithm's window, and with several pixels per clock a beat more.

        That is three beats and a pixel at least, or four where gradients and convolution lose most
        of that.
        Heights are from ``Algorithm.support``.
        """
        support, lanes = self.algorithm.support, self.pixels_per_clock
        if lanes == 1:
            return support
        # line buffers need three beats, that of responses, too, which has lost the most
        lost = 2 * self.algorithm.response_margin // lanes
        return max(support + lanes, 3 * lanes + 1, (lost + 2) * lanes + 1)

    @property
    def beats(self) -> int:
        """Beats of the widest row."""
        return -(-self.max_width // self.pixels_per_clock)

    @property
    def units(self) -> int:
        """Units that refine corners."""
        if FIT_REACH[self.algorithm.fit]:
            return 1
        return self.refinement_units or (2 if self.pixels_per_clock == 8 else 1)

    @property
    def multiplied_pairs(self) -> int:
        """Pairs of squares that multipliers find; tables find the others."""
        return self.multipliers // 2

    @property
    def refinement_bits(self) -> int:
        """Bits of a mantissa that a unit multiplies per clock: see ``hdl.subpixel.Subpixel``."""
        return 2 if self.pixels_per_clock >= 4 else 1

    @property
    def sums_halves(self) -> bool:
        """Are a candidate's textures summed up by halves of its window?

        See ``hdl.candidate_texture.CandidateTexture``; other filters read columns from the left.
        """
        algorithm = self.algorithm
        unsmoothed = algorithm.texture == "patches" and algorithm.response_filter == "none"
        return self.pixels_per_clock > 1 and unsmoothed

    @property
    def window_reads(self) -> int:
        """Columns of a candidate's window that are read in each clock.

        With 8 pixels per clock a photograph has a candidate every 6 to 7 clocks, and half a window
        has 5 columns.
        """
        return 2 if self.sums_halves and self.pixels_per_clock == 8 else 1

    @property
    def candidate_beats(self) -> int:
        """Beats with candidates that can wait."""
        return 2 * self.queue_depth

    @property
    def ring_beats(self) -> int:
        """Beats of columns that are kept for candidates that wait, a power of two.

        A block RAM has 256 places at its widest. Twice as many are needed where windows are read
        nearly as slowly as candidates come.
        """
        return 512 if self.sums_halves and self.pixels_per_clock == 4 else 256

    @property
    def rows_late(self) -> int:
        """Rows by which windows come later than with ``"lean"`` buffers: one for each buffer."""
        buffers = self.algorithm.pixel_passes + 2 + self.buffers_smoothed
        return 0 if self.buffering == "lean" else buffers

    @property
    def is_wide(self) -> bool:
        """Are beats so wide that the registers of one lie far apart?

        Then what enables them comes out of a register, also where that takes another row of them.
        """
        return self.pixels_per_clock > 4

    @property
    def buffers_smoothed(self) -> bool:
        """Are responses smoothed once and then buffered, not made anew for each row of a window?

        So it is with several pixels per clock, unless textures are judged by responses as they are.
        """
        algorithm = self.algorithm
        smooths = RESPONSE_FILTER_REACH[algorithm.response_filter] > 0
        return smooths and self.pixels_per_clock > 1 and algorithm.texture == "none"

    @classmethod
    def profile(cls, name: str, **changes: Any) -> Self:
        """The named profile as it is built by default, with changes: see ``Parameters.profile``."""
        return super().profile(name, **{**BUILDS.get(name, {}), **changes})
