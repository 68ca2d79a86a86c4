# SPDX-License-Identifier: AGPL-3.0-or-later
"""What HemoCell has written: its files, steps, lumen, cells and what becomes of them."""
