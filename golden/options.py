"""Options: fields of a frozen dataclass, each with its default, allowed values and help text.

All of this is written beside the field and nowhere else. The checks and the command line are made
from it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from golden.checks import check_choice, check_fraction, check_switch, plain_integer
from golden.formats import SIGMA_BITS

T = TypeVar("T")


@dataclass(frozen=True)
class Option:
    """One option of a dataclass, as :func:`options` lists it.

    Parameters
    ----------
    name, default
        Those of the field.
    kind
        ``str`` (one of ``choices``), ``int``, ``float`` or ``bool``.
    help
        One line, which can be understood by itself.
    choices
        What a ``str`` may be.
    low, high
        An ``int`` is from ``low`` to ``high``, a ``float`` from 0 to just below ``high``.
    """

    name: str
    default: Any
    kind: type
    help: str
    choices: tuple[str, ...]
    low: int
    high: int

    def check(self, frozen: object) -> None:
        """Raise ``ValueError`` unless the field's value is allowed.

        Whole numbers of other types become Python's ``int``.
        """
        value = getattr(frozen, self.name)
        if self.kind is str:
            check_choice(self.name, value, self.choices)
        elif self.kind is bool:
            check_switch(self.name, value)
        elif self.kind is float:
            check_fraction(self.name, value, self.high, SIGMA_BITS)
        else:
            plain_integer(frozen, self.name, self.low, self.high)


def option(default: T, help: str, *, low: int = 0, high: int = 0) -> T:
    """A field that is an option.

    Its annotation, a ``Literal``, int, float or bool, is its kind; the bounds are those of
    :class:`Option`.
    """
    return field(default=default, metadata={"help": help, "low": low, "high": high})


def options(owner: type) -> dict[str, Option]:
    """The options of a dataclass by name, in the order of its fields, its parents' first.

    A field that allows only one value is not an option: there is nothing to choose.
    """
    return {name: each for name, each in _fields(owner).items() if len(each.choices) != 1}


@cache
def _fields(owner: type) -> dict[str, Option]:
    annotations = get_type_hints(owner)
    found: dict[str, Option] = {}
    for each in fields(owner):
        if "help" in each.metadata:
            annotation = annotations[each.name]
            choices = get_args(annotation) if get_origin(annotation) is Literal else ()
            kind = str if choices else annotation
            found[each.name] = Option(each.name, each.default, kind, choices=choices, **each.metadata)
    return found


def check_options(frozen: object) -> None:
    """Raise ``ValueError`` for the first option whose value is not allowed."""
    # the type of any object is hashable, which mypy does not see
    for each in _fields(type(frozen)).values():  # type: ignore[arg-type]
        each.check(frozen)
