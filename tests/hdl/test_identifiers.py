"""Names that VHDL and Verilog take."""

from __future__ import annotations

import pytest

from hdl.identifiers import LONGEST, check_name, plain_port


@pytest.mark.parametrize("name", ["a", "cornerstream", "corners_b", "Corners2", "x1_y2", "a" * LONGEST])
def test_plain_names_are_allowed(name: str) -> None:
    check_name(name)


@pytest.mark.parametrize(
    "name",
    [
        *(
            "",
            "_a",
            "a_",
            "a__b",
            "2a",
            "a-b",
            "a b",
            "a.v",
            "a$",
            "\u00e9t\u00e9",
            "a\n",
            "a" * (LONGEST + 1),
        ),
        # of the modules of an example
        *("corners_tb", "Corners_Example"),
        # of Verilog, SystemVerilog and VHDL; VHDL knows no capitals
        *("module", "reg", "logic", "entity", "Signal", "CONSTANT"),
    ],
)
def test_other_names_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"name is '.*'; allowed: a letter, then letters, digits"):
        check_name(name)


def test_ports_get_names_that_vhdl_has() -> None:
    names = ("i__valid", "constant", "use_constant", "o__payload", "clk")
    assert [*map(plain_port, names)] == ["i_valid", "reference_constant", "use_constant", "o_payload", "clk"]
