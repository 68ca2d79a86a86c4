# SPDX-License-Identifier: AGPL-3.0-or-later
"""Surfaces of vessels: their ends, their place in HemoCell's lattice, the flow through them."""
