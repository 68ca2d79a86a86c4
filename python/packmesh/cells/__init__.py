# SPDX-License-Identifier: AGPL-3.0-or-later
"""Cells by species, whatever packed them, and what is measured of their membranes."""
