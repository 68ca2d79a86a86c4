# SPDX-License-Identifier: AGPL-3.0-or-later
"""What all else is built on: arguments, files, messages and exit codes, progress."""
