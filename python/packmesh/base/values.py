# SPDX-License-Identifier: AGPL-3.0-or-later
"""Equality and hashes of dataclasses whose members may be arrays."""
from __future__ import annotations

import dataclasses
from typing import Any, Mapping

import numpy as np


def _comparable(value: Any) -> Any:
    """What is equal and has the same hash for arrays, lists and tuples of the same numbers."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, Mapping):
        return frozenset((name, _comparable(one)) for name, one in value.items())
    return tuple(map(_comparable, value)) if isinstance(value, (list, tuple)) else value


class ByValue:
    """Dataclasses that derive from it, with eq=False, are equal if their members are: arrays as a whole, not element by element."""

    def _members(self) -> Any:
        return tuple(_comparable(getattr(self, field.name)) for field in dataclasses.fields(self))  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ByValue) or type(other) is not type(self):
            return NotImplemented
        return self._members() == other._members()

    def __hash__(self) -> int:
        return hash(self._members())
