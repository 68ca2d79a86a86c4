#!/usr/bin/env python3
"""A report opens in a browser, whole and without asking anybody for anything: check_report.py <packMesh> <chromium>."""
import os
import re
import subprocess
import sys
import tempfile
from html.parser import HTMLParser


class Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.tags, self.text, self.links = [], "", []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.links += [(tag, name, value) for name, value in attributes if name in ("src", "href", "srcset", "data")]

    def handle_data(self, data):
        self.text += data + " "


def main():
    program, browser = os.path.realpath(sys.argv[1]), sys.argv[2]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        subprocess.run([program, *"--cylinder x 8 30 --hematocrit 0.25 --plt_ratio 0.1 --report report.html --quiet".split()],
                       check=True)

        def browse(*what):
            return subprocess.run(
                [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
                 "--disable-background-networking", "--disable-component-update", "--disable-sync",
                 "--disable-dev-shm-usage", "--window-size=1280,1600", "--user-data-dir=" + folder + "/profile", *what,
                 "file://" + folder + "/report.html"],
                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=200, check=True, text=True).stdout

        dom = browse("--dump-dom")
        page = Page()
        page.feed(dom)
        assert page.tags.count("svg") == 4, page.tags.count("svg")
        assert page.tags.count("table") >= 4
        for words in ("Packing of a", "Certificate", "clean", "Hematocrit", "wallClearance", "--hematocrit 0.25",
                      "cell-free layer", "distance to the wall", "density"):
            assert words in page.text, words
        for tag, name, value in page.links:
            assert value.startswith("data:image/png;base64,"), (tag, name, value[:60])
        assert not re.search(r"https?://|url\(|@import|<script|<link", dom)
        for path in re.findall(r' d="([^"]*)"', dom):
            assert path and not re.search("nan|inf", path), path

        browse("--screenshot=" + folder + "/report.png")
        with open("report.png", "rb") as file:
            picture = file.read()
        assert picture.startswith(b"\x89PNG") and len(picture) > 50000, len(picture)
        print(f"{len(dom)} characters, {len(page.links)} pictures, all inside")


main()
