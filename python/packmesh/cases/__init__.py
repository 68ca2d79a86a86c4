# SPDX-License-Identifier: AGPL-3.0-or-later
"""New cases of HemoCell."""
