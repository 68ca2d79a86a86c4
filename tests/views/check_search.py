#!/usr/bin/env python3
"""The search of a documentation page that is opened as a file: check_search.py <packMesh> <chromium> <chromedriver>."""
import json
import os
import shutil
import sys
import tempfile

from selenium.webdriver.common.by import By

from browser import Browser

SCRIPT = os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../docs/offline_search.js")
#: What the theme has of it.
PAGE = """<!DOCTYPE html><meta charset="utf-8"><script id="__config" type="application/json">{"base": ".."}</script>
<div class="md-search" hidden><input class="md-search__input"><div class="md-search-result__meta"></div><ol class="md-search-result__list"></ol></div>
<script src="../offline_search.js"></script>"""
DOCS = [{
    "location": "a.html", "title": "Gaps",
    "text": "<p>Cells <b>&lt;img src=x onerror=console.error(1)&gt;</b> keep distance.</p>"},
        {"location": "b.html#walls", "title": "Walls",
         "text": "Gaps between cells and walls."}, {"location": "c.html", "title": "Other", "text": ""}]


def check(page):

    def found(text):
        field = page.driver.find_element(By.CSS_SELECTOR, ".md-search__input")
        field.clear()
        field.send_keys(text)
        links = page.driver.find_elements(By.CSS_SELECTOR, ".md-search-result__list a")
        return [link.get_attribute("href").rpartition("/")[2] for link in links]

    page.driver.execute_async_script(
        "const wait = () => window.searchIndex ? setTimeout(arguments[0]) : setTimeout(wait, 10); wait()")
    assert found("gaps") == ["a.html", "b.html#walls"] and page.text(".md-search-result__meta") == "2 found"  # by title first
    assert found("GAPS walls") == ["b.html#walls"] and found("gaps nothing") == [] and found("") == []
    found("distance")
    assert "<img src=x" in page.text(".md-search-result__list") and not page.driver.find_elements(By.TAG_NAME, "img")
    page.run("document.querySelector('.md-search').hidden = true")  # as the theme does when its own search fails
    page.driver.execute_async_script("setTimeout(arguments[0], 0)")
    assert page.run("return !document.querySelector('.md-search').hidden")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.makedirs(os.path.join(folder, "search"))
        os.makedirs(os.path.join(folder, "docs"))
        shutil.copy(SCRIPT, folder)
        with open(os.path.join(folder, "search/search_index.js"), "w", encoding="utf-8") as file:
            file.write("window.searchIndex = " + json.dumps({"docs": DOCS}))
        with open(os.path.join(folder, "docs/page.html"), "w", encoding="utf-8") as file:
            file.write(PAGE)
        with Browser(sys.argv[2], sys.argv[3]) as browser:
            check(browser.open(os.path.join(folder, "docs/page.html")))  # without the checks of pages that load nothing
        print("The search finds pages")


main()
