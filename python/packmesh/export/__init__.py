# SPDX-License-Identifier: AGPL-3.0-or-later
"""Cells as files of other programs."""
