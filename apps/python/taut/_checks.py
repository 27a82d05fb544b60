"""Single values as the library takes them; what is none is an InputError, one line."""

from __future__ import annotations

import math
import numbers
import os
from typing import Any, List, NoReturn, Optional

from ._taut import InputError


def fail(where: str, found: str, expected: str) -> NoReturn:
    """Raises InputError, one line as the command prints it."""
    raise InputError(f"{where}: found {found}, expected {expected}")


def describe(value: object) -> str:
    """A value in a message, however long."""
    text = repr(value).replace("\n", " ")
    return text if len(text) <= 40 else text[:37] + "..."


def number(where: str, value: Any, least: float = -math.inf, greatest: float = math.inf, expected: str = "a number") -> float:
    """A finite real number in [least, greatest]."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        array = getattr(value, "item", None)
        if array is None or getattr(value, "size", 0) != 1:
            fail(where, describe(value), expected)
        return number(where, array(), least, greatest, expected)
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found) or not least <= found <= greatest:
        fail(where, describe(value), expected)
    return found


def whole(where: str, value: Any, least: int, greatest: int) -> int:
    """A whole number in [least, greatest]."""
    expected = f"a whole number in [{least}, {greatest}]"
    found = number(where, value, least, greatest, expected)
    if found != int(found):
        fail(where, describe(value), expected)
    return int(value)


def seed(value: Optional[Any]) -> Optional[int]:
    """Of random numbers: 32 bits."""
    return None if value is None else whole("seed", value, 0, 0xFFFFFFFF)


def text(where: str, value: Any, expected: str = "a string") -> str:
    """A string or a path."""
    if not isinstance(value, (str, os.PathLike)):
        fail(where, describe(value), expected)
    path = os.fspath(value)
    return path if isinstance(path, str) else os.fsdecode(path)


def texts(where: str, values: Any) -> List[str]:
    """A string, or several."""
    if isinstance(values, (str, os.PathLike)):
        return [text(where, values)]
    try:
        return [text(f"{where}[{i}]", value) for i, value in enumerate(values)]
    except TypeError:
        fail(where, describe(values), "a string or a sequence of strings")
