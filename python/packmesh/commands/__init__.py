# SPDX-License-Identifier: AGPL-3.0-or-later
"""Commands that no other module uses."""
