"""How arguments become the arrays that the library reads: in place where they can, else by a copy that is counted."""

from __future__ import annotations

from typing import Any, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._checks import describe, fail
from ._taut import InputError

_copies = 0
_copied_bytes = 0


def copies() -> Tuple[int, int]:
    """How many arrays have been copied on their way into the library since it was imported, and how many bytes those copies have.

    Arrays of the type and layout that a function names (float32 and C-contiguous, say) are read where they are and do not count.
    What a Gloss or a Scene keeps for itself (rest shape, topology) is no input of a frame and does not count either.
    """
    return _copies, _copied_bytes


def _shape_text(shape: Sequence[int]) -> str:
    return "an array of shape (" + ", ".join(map(str, shape)) + ("," if len(shape) == 1 else "") + ")"


def take(what: str, values: ArrayLike, dtype: DTypeLike) -> NDArray[Any]:
    """`values` as a C-contiguous array of `dtype`; the very memory where it already is one."""
    global _copies, _copied_bytes
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "fiub":
            raise TypeError
        # No number may change its meaning: reals do not become indices.
        if np.dtype(dtype).kind in "iu" and given.dtype.kind == "f" and given.size:
            raise TypeError
        array = np.ascontiguousarray(given, dtype=dtype)
    except (TypeError, ValueError):
        kind = "whole numbers" if np.dtype(dtype).kind in "iu" else "numbers"
        raise InputError(f"{what}: found {_describe(values)}, expected an array of {kind}") from None
    if isinstance(values, np.ndarray) and array.size and not np.may_share_memory(array, values):
        _copies += 1
        _copied_bytes += array.nbytes
    return array if array.ndim == given.ndim else array.reshape(given.shape)


def _describe(values: object) -> str:
    return f"an array of {values.dtype}" if isinstance(values, np.ndarray) else describe(values)


def table(what: str, values: ArrayLike, columns: int, dtype: DTypeLike, rows: Optional[int] = None, row_name: str = "n") -> NDArray[Any]:
    """An array [rows, columns]."""
    array = take(what, values, dtype)
    if array.ndim != 2 or array.shape[1] != columns or (rows is not None and array.shape[0] != rows):
        wanted = row_name if rows is None else str(rows)
        fail(what, _shape_text(array.shape), f"({wanted}, {columns})")
    return array


def common_type(*values: ArrayLike) -> np.dtype[Any]:
    """float32 where an argument is an array of float32 and none is one of float64; else float64, numpy's own."""
    kinds = [v.dtype for v in values if isinstance(v, np.ndarray)]
    single = any(k == np.float32 for k in kinds) and not any(k == np.float64 for k in kinds)
    return np.dtype(np.float32 if single else np.float64)


class Broadcast:
    """Arguments of one call as rows: leading axes are broadcast as numpy does, the last axis is the row.

    An argument with the full leading shape is read in place, one without leading axes counts for every row; anything between is
    expanded, which is a copy.
    """

    def __init__(self, dtype: DTypeLike, **arguments: Tuple[ArrayLike, Tuple[int, ...]]) -> None:
        taken = {}
        for name, (values, widths) in arguments.items():
            array = take(name, values, dtype)
            if 0 in widths:  # a number a row
                taken[name] = (array, 0)
                continue
            if array.ndim == 0 or array.shape[-1] not in widths:
                fail(name, _shape_text(array.shape), "a last axis of " + " or ".join(map(str, widths)))
            taken[name] = (array, array.shape[-1])
        leading = [a.shape if width == 0 else a.shape[:-1] for a, width in taken.values()]
        try:
            self.shape = np.broadcast_shapes(*leading)
        except ValueError:
            parts = ", ".join(f"{name} {a.shape}" for name, (a, _) in taken.items())
            raise InputError(f"arguments: found shapes {parts}, expected shapes that broadcast") from None
        self.rows = [self._rows(name, a, width) for name, (a, width) in taken.items()]

    def _rows(self, name: str, array: NDArray[Any], width: int) -> NDArray[Any]:
        lead = array.shape if width == 0 else array.shape[:-1]
        if int(np.prod(lead)) != 1 and lead != self.shape:
            whole = self.shape if width == 0 else (*self.shape, width)
            array = take(name, np.broadcast_to(array, whole), array.dtype)
        return array.reshape(-1) if width == 0 else array.reshape(-1, width)

    def number(self, values: NDArray[Any]) -> Any:
        """A result of one number a row; a plain number where there are no leading axes."""
        return values.reshape(self.shape) if self.shape else values.reshape(())[()]

    def vector(self, values: NDArray[Any]) -> NDArray[Any]:
        return values.reshape(*self.shape, values.shape[-1])
