# SPDX-License-Identifier: AGPL-3.0-or-later
"""What a run needs of its case: numbers of config.xml, and the pre-inlet in its C++ code."""
from __future__ import annotations

import glob
import math
import os
import re
import xml.etree.ElementTree
from typing import Optional, Set, Tuple, Union

from packmesh.base.files import existing
from packmesh.errors import InputError


def config_of(case: Union[None, str, os.PathLike[str]]) -> Optional[str]:
    """Of a case: config.xml, or its folder."""
    if case is None:
        return None
    name = os.fspath(case)
    return os.path.join(name, "config.xml") if os.path.isdir(name) else existing(name)


def root_of(config: str) -> xml.etree.ElementTree.Element:
    """Of config.xml. Raises InputError"""
    try:
        return xml.etree.ElementTree.parse(config).getroot()
    except (OSError, ValueError, xml.etree.ElementTree.ParseError) as error:
        raise InputError(f"{config}: cannot be read: {error}") from None


def number_in_case(config: str, tag: str) -> Optional[float]:
    """That of a tag such as domain/rhoP, None without it. Raises InputError"""
    text = root_of(config).findtext(tag)
    try:
        value = None if text is None else float(text)
    except ValueError:
        value = math.nan
    if value is not None and not 0 <= value < 1e30:
        raise InputError(f"{config}: <{tag.split('/')[-1]}>: expected a number that is not negative, found '{text.strip()}'")
    return value


def inflow_of(config: str) -> Optional[Tuple[int, int]]:
    """Axis and side of the pre-inlet in the C++ code beside a case; None if it does not state one."""
    stated: Set[Tuple[str, str]] = set()
    for name in glob.glob(os.path.join(glob.escape(os.path.dirname(os.path.abspath(config))), "*.cpp")):
        with open(name, encoding="utf-8", errors="replace") as file:
            stated.update(re.findall(r"^[^/\n]*Direction::([XYZ])(neg|pos)", file.read(), re.M))
    if len(stated) != 1:
        return None
    axis, side = stated.pop()
    return "XYZ".index(axis), -1 if side == "neg" else 1
