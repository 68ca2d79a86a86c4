# SPDX-License-Identifier: AGPL-3.0-or-later
"""Pages in Chromium, for tests of what they show."""
import json
import os

from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

PATIENCE = 1200  # [s] for a page or a script, on a machine that other work shares


def started(chromedriver, options):
    """A browser. Its start has time limits of its own, which a loaded machine can exceed."""
    for attempt in range(10):
        try:
            driver = webdriver.Chrome(service=Service(chromedriver), options=options)
            break
        except WebDriverException:
            if attempt == 9:
                raise
    driver.set_page_load_timeout(PATIENCE)
    driver.set_script_timeout(PATIENCE)
    return driver


class Browser:
    """Opens pages, one after another in the same process, which takes seconds to start. pictures: folder for pictures of them, or None"""

    def __init__(self, chromium, chromedriver, pictures=None):
        self.chromium, self.chromedriver, self.pictures = chromium, chromedriver, pictures
        self._drivers = {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for driver in self._drivers.values():
            driver.quit()

    def open(self, file, width=1280, height=900, webgl=True):
        return Page(self, file, width, height, webgl)

    def driver(self, webgl):
        if webgl not in self._drivers:
            options = Options()
            options.binary_location = self.chromium
            for argument in [
                    "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-background-networking",
                    "--disable-component-update", "--disable-sync", "--no-first-run",
                    *(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] if webgl else [
                        "--disable-gpu", "--disable-3d-apis"])]:
                options.add_argument(argument)
            options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
            self._drivers[webgl] = started(self.chromedriver, options)
        return self._drivers[webgl]


class Page:
    """A page in a browser of this size, which must write no errors and request no other file."""

    def __init__(self, browser, file, width, height, webgl):
        self.browser, self.driver = browser, browser.driver(webgl)
        self.driver.set_window_size(width, height)
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600})
        self.url = "file://" + os.path.realpath(file)
        self.driver.get(self.url)
        # The view gets its size in the first frame, after the callbacks of that frame.
        self.driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            self.check_logs()
            self.driver.get("about:blank")  # a page that stays would go on drawing
            self._messages()

    def _messages(self):
        """Of the browser since the last call."""
        return [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]

    def check_logs(self):
        errors = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "ERROR")]
        assert not errors, errors
        for message in self._messages():
            if message["method"] == "Network.requestWillBeSent":
                url = message["params"]["request"]["url"]
                assert url.startswith(("data:", "blob:")) or url == self.url, url

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def text(self, query):
        return self.driver.find_element(By.CSS_SELECTOR, query).text

    def click(self, x, y):
        """At these pixels of the view."""
        canvas = self.driver.find_element(By.CSS_SELECTOR, "#stage canvas")
        self.run("arguments[0].scrollIntoView({ block: 'center' })", canvas)
        size = canvas.size
        ActionChains(self.driver).move_to_element_with_offset(canvas, round(x - size["width"] / 2),
                                                              round(y - size["height"] / 2)).click().perform()

    def colors(self):
        """Pixels of the view that are red, and others that something is drawn on."""
        return self.run("""
            const from = packMesh.view.canvas, to = document.createElement("canvas");
            [to.width, to.height] = [from.width, from.height];
            const context = to.getContext("2d");
            context.drawImage(from, 0, 0);
            const data = context.getImageData(0, 0, to.width, to.height).data, found = [0, 0];
            for (let i = 0; i < data.length; i += 4)
              if (data[i + 3]) ++found[data[i] > 90 && data[i] > 1.5 * data[i + 1] && data[i] > 1.5 * data[i + 2] ? 0 : 1];
            return found;""")

    def save(self, name):
        if self.browser.pictures:
            self.driver.save_screenshot(os.path.join(self.browser.pictures, name + ".png"))
