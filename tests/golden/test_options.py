"""Options: what is written beside a field is what is checked, and what the command line says."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, get_args, get_type_hints

import pytest

from golden.algorithm import Algorithm, Fit
from golden.options import check_options, option, options
from golden.parameters import Parameters
from golden.settings import Settings
from hdl.build import Build

Colour = Literal["red", "green"]


@dataclass(frozen=True)
class Paint:
    colour: Colour = option("red", "Colour of the paint.")
    coats: int = option(2, "How many.", low=1, high=4)
    share: float = option(0.5, "Share of water.", high=1)
    gloss: bool = option(False, "Shines.")
    base: Literal["water"] = option("water", "What it is thinned with.")
    name: str = ""

    def __post_init__(self) -> None:
        check_options(self)


def test_options_say_what_is_allowed() -> None:
    colour, coats, share, gloss = options(Paint).values()
    assert (colour.name, colour.kind, colour.choices, colour.default) == (
        "colour",
        str,
        ("red", "green"),
        "red",
    )
    assert (coats.kind, coats.low, coats.high, coats.default) == (int, 1, 4, 2)
    assert (share.kind, share.high, gloss.kind) == (float, 1, bool)
    assert gloss.help == "Shines."


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("colour", "blue", "colour is 'blue'; allowed: red, green"),
        ("coats", 5, "coats is 5; allowed: whole numbers from 1 to 4"),
        ("share", 1, "share is 1; allowed: 0 <= share < 1"),
        ("gloss", 1, "gloss is 1; allowed: True or False"),
        # no option, as there is nothing to choose, and yet checked
        ("base", "oil", "base is 'oil'; allowed: water"),
    ],
)
def test_each_kind_is_checked(field: str, value: object, message: str) -> None:
    with pytest.raises(ValueError) as caught:
        Paint(**{field: value})  # type: ignore[arg-type]
    assert str(caught.value) == message


@pytest.mark.parametrize("owner", [Algorithm, Parameters, Settings, Build])
def test_every_field_is_an_option_with_its_line_of_help(owner: type) -> None:
    found = options(owner)
    settled = {name for name, hint in get_type_hints(owner).items() if len(get_args(hint)) == 1}
    assert {field.name for field in fields(owner)} - {"algorithm"} - settled == set(found)
    for each in found.values():
        assert each.help.endswith(".") and "\n" not in each.help
        assert getattr(owner(), each.name) == each.default


def test_build_has_the_options_of_parameters_first() -> None:
    assert list(options(Build))[: len(options(Parameters))] == list(options(Parameters))
    assert options(Algorithm)["fit"].choices == get_args(Fit)
