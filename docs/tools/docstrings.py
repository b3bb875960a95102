"""How mkdocstrings reads this project's docstrings.

Their section *Members* lists the ports of a hardware block, as in Amaranth's library. Griffe, which
reads docstrings, knows this section only under the name *Attributes*. Cross-references such as
``:class:`name``` become plain code, and a field made by ``option(default, help)`` shows its default
alone.
"""

from __future__ import annotations

import re
from typing import Any

from griffe import Attribute, DocstringSectionKind, ExprCall, Extension, Object

_MEMBERS = re.compile(r"^Members\n-+$", re.MULTILINE)
_SHARED = re.compile(r"^(\w+(?:, \w+)+)\n((?:    .*(?:\n|$))+)", re.MULTILINE)
_ROLE = re.compile(r":(?:class|data|func|meth|mod):`~?([^`]+)`")


class Docstrings(Extension):
    """Prepares each docstring before it is parsed, and the defaults of options."""

    def on_attribute_instance(self, *, attr: Attribute, **_: Any) -> None:
        if isinstance(attr.value, ExprCall) and str(attr.value.function) == "option":
            attr.value = attr.value.arguments[0]

    def on_object(self, *, obj: Object, **_: Any) -> None:
        docstring = obj.docstring
        if docstring is None:
            return
        docstring.value = _ROLE.sub(r"`\1`", docstring.value)
        # names that share a description would get the type and the default of the first
        docstring.value = _SHARED.sub(
            lambda shared: "".join(f"{name}\n{shared[2]}\n" for name in shared[1].split(", ")),
            docstring.value,
        )
        if not _MEMBERS.search(docstring.value):
            return
        docstring.value = _MEMBERS.sub("Attributes\n----------", docstring.value)
        sections = docstring.parse("numpy", warn_missing_types=False)
        for section in sections:
            if section.kind is DocstringSectionKind.attributes:
                section.title = "Members:"
        # the parsed form is a cached property: this one is kept
        docstring.__dict__["parsed"] = sections
