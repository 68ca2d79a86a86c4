# SPDX-License-Identifier: AGPL-3.0-or-later
"""Cells by species, and pictures of them: what packings of undeformed and of deformed cells have in common."""
from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any, Dict, List, Tuple

import numpy as np
import numpy.typing as npt

from packmesh.errors import UnknownCellsError
from packmesh.show.picture import picture_of

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[Any]


class Cells:
    """The cells of one species of a packing: ``packing["RBC"]``; on several ranks those of this rank."""

    def __init__(self, packing: CellPacking, name: str) -> None:
        self.packing, self.name = packing, name

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"<packmesh.Cells: {len(self)} {self.name}>"

    @property
    def numbers(self) -> Integers:
        """Numbers of these cells among all of the packing, from 0, shape (n,)."""
        return self.packing._first_number + self._rows

    @property
    def _rows(self) -> Integers:
        """Indices into the arrays of the packing."""
        return np.flatnonzero(self.packing.species == self.packing.index_of(self.name))

    @property
    def deformed(self) -> bool:
        """Whether some of them, on any rank, have meshes of their own (collective)."""
        return self.packing._is_deformed(self.name)

    def _of_all_ranks(self, own: Floats) -> Floats:
        """The values of these cells, on all ranks that share them."""
        comm = self.packing._comm
        return own if comm is None else np.concatenate(comm.allgather(own))

    @property
    def positions(self) -> Floats:
        """Centres [µm], shape (n, 3)."""
        return self.packing.positions[self._rows]

    @property
    def rotations(self) -> Floats:
        """Unit quaternions x, y, z, w, shape (n, 4)."""
        return self.packing.rotations[self._rows]

    @property
    def vertices(self) -> Floats:
        """The membranes [µm], shape (n, V, 3); not wrapped at periodic faces."""
        return self.packing.vertices(self.name)

    @property
    def template(self) -> Tuple[Floats, Integers]:
        """The mesh of the species: vertices [µm], shape (V, 3), and triangles, shape (T, 3), outwards."""
        return self.packing.template(self.name)

    @property
    def pos_lines(self) -> Floats:
        """The lines of ``<name>.pos``: x y z [µm] a b c [degrees], shape (n, 6)."""
        return self.packing.pos_lines(self.name)


class CellPacking:
    """Cells of several species, in the order of species: ``packing["RBC"]`` are those of one."""

    _first_number = 0  # of the cells here among those of all ranks
    _comm: Any = None  # of ranks that share them

    if TYPE_CHECKING:  # of those that derive from it
        @property
        def deformed(self) -> bool: ...
        @property
        def counts(self) -> Dict[str, int]: ...
        @property
        def species(self) -> Integers: ...
        @property
        def positions(self) -> Floats: ...
        @property
        def rotations(self) -> Floats: ...
        def template(self, name: str) -> Tuple[Floats, Integers]: ...
        def vertices(self, name: str) -> Floats: ...
        def pos_lines(self, name: str) -> Floats: ...

    def _is_deformed(self, name: str) -> bool:
        """Whether cells of a species have meshes of their own."""
        return self.deformed

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, name: str) -> Cells:
        self.index_of(name)
        return Cells(self, name)

    def __contains__(self, name: object) -> bool:
        return name in self.species_names

    __iter__ = None  # neither species nor cells: p.species_names, p.positions

    def __repr__(self) -> str:
        return f"<packmesh.{type(self).__name__}: {self._counts_text()}>"

    def _counts_text(self) -> str:
        return ", ".join(f"{count} {name}" for name, count in self.counts.items())

    def _repr_html_(self) -> str:
        """For notebooks: numbers, and a picture of the cells of this rank."""
        kinds = [(name, self.template(name), self.vertices(name) if self.deformed else None) for name in self.species_names]
        picture = picture_of(kinds, self.species, self.positions, self.rotations)
        image = f'<img alt="{html.escape(self._counts_text())}" style="max-width: 100%; width: 480px" src="{picture}">' if picture else ""
        return f"<figure style='margin: 0'>{image}<figcaption>packmesh.{type(self).__name__}: {html.escape(self._counts_text())}</figcaption></figure>"

    @property
    def species_names(self) -> List[str]:
        """Names of the species; `species` has indices into it."""
        return list(self.counts)

    def index_of(self, name: str) -> int:
        """Index of a species into `species_names`. Raises InputError, which is a KeyError, if there is none of this name."""
        names = self.species_names
        if name not in names:
            raise UnknownCellsError(f"there are no cells {name!r}; expected one of {', '.join(names)}")
        return names.index(name)
