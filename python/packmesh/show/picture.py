# SPDX-License-Identifier: AGPL-3.0-or-later
"""A picture of the cells of a packing for notebooks, by NumPy alone: points on the membranes, the nearest of each pixel."""
from __future__ import annotations

import base64
import struct
import zlib
from typing import Any, Optional, Sequence, Tuple

import numpy as np

from packmesh.io.packing_file import matrices_of
from packmesh.show.plot import COLOURS

#: Name, vertices of the template [µm] and triangles, and the membranes if cells have meshes of their own.
Kind = Tuple[str, Tuple[np.ndarray, np.ndarray], Optional[np.ndarray]]
WIDTH, HEIGHT, MARGIN = 600, 420, 0.03
POINTS_PER_PIXEL = 1.4  # of a membrane that is seen from the front, in each direction
AT_A_TIME = 400_000  # points
SLENDER = 3  # triangles longer than this, in heights, get fewer points across than along
PALETTE = ("#1f5fa8", "#2f855a", "#7b4397", "#d9730d", "#12848c", "#a0516b")
KEY, FILL = np.array([[-0.462, 0.693, 0.554], [0.843, -0.105, 0.527]], np.float32)  # lights: right, up, to the eye


def colour_of(name: str, number: int) -> np.ndarray:
    """Red, green, blue, 0 to 255, as on the page of reports."""
    found = [colour for prefix, colour in COLOURS.items() if name.startswith(prefix)] or [PALETTE[number % len(PALETTE)]]
    return np.array([int(found[0][i:i + 2], 16) for i in (1, 3, 5)], float)


def directions(size: np.ndarray) -> np.ndarray:
    """Of a camera from the front and above, with the longer horizontal axis across: right, up, to the eye, shape (3, 3)."""
    azimuth, elevation = np.radians([22.8 if size[1] > size[0] else -67.2, 20.2])
    eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return np.array([right, np.cross(eye, right), eye])


def even_weights(n: int) -> np.ndarray:
    """Of the corners of a triangle, shape (n², 3): middles of the small triangles into which n cuts of each edge divide it."""
    i, j = (grid.ravel() for grid in np.mgrid[:n, :n])
    upright = np.stack([i, j], axis=1)[i + j < n] + 1 / 3
    shares = np.concatenate([upright, np.stack([i, j], axis=1)[i + j < n - 1] + 2 / 3]) / n
    return np.column_stack([1 - shares.sum(axis=1), shares])


def weights_in_rows(n: int, rows: int) -> np.ndarray:
    """The same, shape (n rows, 3), of a slender triangle: rows along its first edge, which is the longest."""
    up, along = (grid.ravel() + 0.5 for grid in np.mgrid[:rows, :n])
    up, along = up / rows, along / n
    return np.column_stack([(1 - up) * (1 - along), (1 - up) * along, up])


def points_on(vertices: np.ndarray, triangles: np.ndarray, spacing: float) -> Tuple[np.ndarray, np.ndarray]:
    """Points on a mesh about so far apart, and smooth unit normals there, shape (n, 3) each."""
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, triangles[:, k], faces)
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    turn = (lengths.argmax(axis=1)[:, None] + np.arange(3)) % 3  # the longest edge becomes the first
    corners, triangles = np.take_along_axis(corners, turn[:, :, None], axis=1), np.take_along_axis(triangles, turn, axis=1)
    height = np.linalg.norm(faces, axis=1) / np.maximum(lengths.max(axis=1), 1e-300)
    cuts = np.maximum(1, np.ceil(np.column_stack([lengths.max(axis=1), height]) / spacing)).astype(int)
    cuts[cuts[:, 0] <= SLENDER * cuts[:, 1], 1] = 0  # of these, all edges are cut equally
    points, slopes = [], []
    for n, rows in np.unique(cuts, axis=0):
        weights = weights_in_rows(n, rows) if rows else even_weights(n)
        here = (cuts == [n, rows]).all(axis=1)
        points.append((weights @ corners[here]).reshape(-1, 3))
        slopes.append((weights @ normals[triangles[here]]).reshape(-1, 3))
    slope = np.concatenate(slopes)
    slope /= np.maximum(np.linalg.norm(slope, axis=1)[:, None], 1e-12)
    return np.concatenate(points).astype(np.float32), slope.astype(np.float32)


class Canvas:
    """Pixels, of which each keeps the nearest point: colour and height towards the eye."""

    def __init__(self, low: np.ndarray, high: np.ndarray) -> None:
        """low, high: corners of what is shown [µm], right and up"""
        size = high - low
        self.pixel = max(size[0] / WIDTH, size[1] / HEIGHT, 1e-9) / (1 - 2 * MARGIN)
        self.width, self.height = (int(np.ceil(extent / self.pixel * (1 + 2 * MARGIN))) + 1 for extent in size)
        self.low = 0.5 * (low + high) - 0.5 * self.pixel * np.array([self.width, self.height])
        self.nearest = np.full(self.width * self.height, -np.inf, np.float32)
        self.colours = np.full((self.width * self.height, 3), 255, np.uint8)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Indices of the pixels of points."""
        column, row = ((points[:, :2] - self.low) / self.pixel).astype(np.int32).T
        return np.clip(self.height - 1 - row, 0, self.height - 1) * self.width + np.clip(column, 0, self.width - 1)

    def add(self, points: np.ndarray, normals: np.ndarray, colour: np.ndarray) -> None:
        """Lit points, right, up and towards the eye [µm], shape (n, 3) each."""
        pixels = self.at(points)
        seen = np.flatnonzero(points[:, 2] > self.nearest[pixels])
        seen = seen[np.argsort(points[seen, 2])]
        last = np.empty(len(self.nearest), np.intp)
        last[pixels[seen]] = seen
        seen = seen[last[pixels[seen]] == seen]  # of the points of a pixel, the nearest
        normal, pixels = normals[seen], pixels[seen]
        lit = 0.30 + 0.72 * np.maximum(normal @ KEY, 0) + 0.22 * np.maximum(normal @ FILL, 0) + 0.12 * normal[:, 2]
        self.nearest[pixels] = points[seen, 2]
        self.colours[pixels] = np.minimum(lit[:, None] * colour[seen], 255)

    def covers(self, centres: np.ndarray, radius: float) -> np.ndarray:
        """Whether what is drawn covers balls [µm], shape (n,)."""
        edge = max(1, int(radius / self.pixel / 2))
        rows, columns = -(-self.height // edge), -(-self.width // edge)
        padded = np.full((rows * edge, columns * edge), np.inf, np.float32)
        padded[:self.height, :self.width] = self.nearest.reshape(self.height, self.width)
        least = np.pad(padded.reshape(rows, edge, columns, edge).min(axis=(1, 3)), 3, constant_values=np.inf)
        row, column = np.divmod(self.at(centres), self.width)
        blocks = [least[row // edge + i, column // edge + k] for i in range(7) for k in range(7)]
        return np.min(blocks, axis=0) > centres[:, 2] + radius

    def png(self) -> bytes:
        rows = np.zeros((self.height, 1 + 3 * self.width), np.uint8)  # each begins with 0: unfiltered
        rows[:, 1:] = self.colours.reshape(self.height, -1)

        def chunk(kind: bytes, data: bytes) -> bytes:
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        head = struct.pack(">IIBBBBB", self.width, self.height, 8, 2, 0, 0, 0)
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(
            b"IEND", b"")


def picture_of(kinds: Sequence[Kind], species: np.ndarray, positions: np.ndarray, rotations: np.ndarray) -> Optional[str]:
    """Cells as a PNG in a data: URL; None without cells. species: indices into kinds, ascending; rotations: quaternions x, y, z, w"""
    if len(positions) == 0:
        return None
    reach = np.array([np.linalg.norm(vertices, axis=1).max() for _, (vertices, _), _ in kinds])[species][:, None]
    low, high = (positions - reach).min(axis=0), (positions + reach).max(axis=0)
    camera = directions(high - low)
    centres = (positions @ camera.T).astype(np.float32)
    canvas = Canvas((centres[:, :2] - reach).min(axis=0), (centres[:, :2] + reach).max(axis=0))
    turned = (camera @ matrices_of(np.asarray(rotations))).astype(np.float32)
    spacing = canvas.pixel / POINTS_PER_PIXEL
    surfaces = [points_on(*template, spacing) for _, template, _ in kinds]
    number_of = np.arange(len(positions)) - np.searchsorted(species, species)  # within the species
    colours = [colour_of(name, number) for number, (name, _, _) in enumerate(kinds)]
    order = np.argsort(-centres[:, 2])  # from the nearest on: most points of those behind are not needed
    species = species[order]
    while len(order):
        kind = int(species[0])
        points, normals = surfaces[kind]
        chosen = np.flatnonzero(species == kind)[:max(1, AT_A_TIME // len(points))]
        cells = order[chosen]
        order, species = np.delete(order, chosen), np.delete(species, chosen)
        seen = cells[~canvas.covers(centres[cells], float(reach[cells[0], 0]))]
        _, (_, triangles), own = kinds[kind]
        if own is None:
            draw(canvas, centres[seen], turned[seen], points, normals, colours[kind], seen)
            continue
        for cell in seen:
            surface = points_on(own[number_of[cell]] @ camera.T, triangles, spacing)
            draw(canvas, np.zeros((1, 3), np.float32),
                 np.eye(3, dtype=np.float32)[None], *surface, colours[kind], np.array([cell]))
    return "data:image/png;base64," + base64.b64encode(canvas.png()).decode()


def draw(canvas: Canvas, centres: np.ndarray, turned: np.ndarray, points: np.ndarray, normals: np.ndarray, colour: Any,
         numbers: np.ndarray) -> None:
    """The sides of cells of a species that face the eye, each in a brightness of its own."""
    shades = (colour * (0.84 + 0.3 * ((numbers * 0.6180339887) % 1))[:, None]).astype(np.float32)
    placed, slopes, tints = [], [], []
    for centre, matrix, shade in zip(centres, turned, shades):
        facing = normals @ matrix[2] > 0
        placed.append(points[facing] @ matrix.T + centre)
        slopes.append(normals[facing] @ matrix.T)
        tints.append(np.broadcast_to(shade, placed[-1].shape))
    if placed:
        canvas.add(np.concatenate(placed), np.concatenate(slopes), np.concatenate(tints))
