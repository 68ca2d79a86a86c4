# SPDX-License-Identifier: AGPL-3.0-or-later
"""Any text as a part of a file in another language: words of the shell, comments of XML, comments of scripts and of C++, lines of Markdown."""
from __future__ import annotations

import re
import shlex
from typing import Callable, Dict


def one_line(text: str) -> str:
    """Line breaks, other control characters and bytes that are no UTF-8 become "?"; enough for a comment that begins with # and ends with its line."""
    return "".join(c if c.isprintable() else "?" for c in text)


def shell(word: str) -> str:
    """One word of bash, in one line."""
    if word.isprintable():
        return shlex.quote(word)
    escaped = ("".join(f"\\x{byte:02x}" for byte in c.encode("utf-8", "surrogateescape")) for c in word)
    return "$'" + "".join(c if c.isprintable() and c not in "\\'" else code for c, code in zip(word, escaped)) + "'"


def cpp_comment(text: str) -> str:
    """After //: a backslash at the end, or its trigraph, would continue the comment in the next line."""
    text = one_line(text).replace("??/", "? ?/")
    return re.sub(r"\\(\s*)$", r"\\.", text)


def xml_comment(text: str) -> str:
    """Which has no -- and does not end in -."""
    return re.sub("-(?=-|$)", "- ", one_line(text))


#: What becomes of the free text in a file, by the end of its name: it stands in comments alone, in Markdown in lines.
FREE_TEXT: Dict[str,
                Callable[[str],
                         str]] = {".xml": xml_comment, ".cpp": cpp_comment, ".sh": one_line, ".txt": one_line, ".md": one_line}
