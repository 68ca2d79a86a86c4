# SPDX-License-Identifier: AGPL-3.0-or-later
"""Files that are read or written: HDF5, cells of packings, reports, surfaces, .pos."""
