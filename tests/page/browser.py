"""Chromium without a screen, drawing by software: the picture and the requests of a page."""

import io
import json
import os
import shutil

try:
    import numpy
    from PIL import Image
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None

WIDE = (1400, 1000)
PHONE = (390, 844)
OUTLINE = (38, 50, 66)


def missing_tool():
    """The missing program for opening pages; empty if none is missing."""
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            return program
    return "" if webdriver else "python3-selenium, python3-numpy and python3-pil"


class Browser:
    """A window with one page."""

    def __init__(self, page, size=WIDE, without_webgl=False, on_phone=False):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        arguments = ["--headless=new", "--no-sandbox", "--hide-scrollbars",
                     "--force-device-scale-factor=1", "--disable-background-networking"]
        if without_webgl:
            arguments += ["--disable-gpu", "--disable-3d-apis"]
        else:
            arguments += ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        for argument in arguments + ["--window-size=%d,%d" % size]:
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")),
                                       options=options)
        self.driver.set_script_timeout(120)
        if on_phone:
            # Windows are at least 500 pixels wide; emulated screens may be narrower.
            self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": PHONE[0], "height": PHONE[1], "deviceScaleFactor": 2, "mobile": True})
            self.driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {
                "enabled": True, "maxTouchPoints": 5})
        self.page = page

    def __enter__(self):
        self.idle_seconds = self.cpu_seconds()
        self.driver.get("file://%s" % self.page)
        self.wait_until("window.kirireel !== undefined")
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def wait_until(self, condition):
        """Waits until a JavaScript expression is true; fails after the script's limit of time."""
        self.driver.execute_async_script(
            "const done = arguments[0];"
            "const look = () => (%s) ? done() : setTimeout(look, 20); look();" % condition)

    def wait_until_fine(self):
        """Waits until the picture has its final quality."""
        self.wait_until("kirireel.stages.every((stage) => stage.isFine && !stage.isStale)")

    def cpu_seconds(self):
        """CPU seconds of the browser's processes so far."""
        ticks = os.sysconf("SC_CLK_TCK")
        parents, seconds = {}, {}
        for entry in os.listdir("/proc"):
            if not entry.isdigit():
                continue
            try:
                with open("/proc/%s/stat" % entry) as file:
                    fields = file.read().rsplit(")", 1)[1].split()
            except OSError:
                continue  # it has just ended
            parents[int(entry)] = int(fields[1])
            seconds[int(entry)] = (int(fields[11]) + int(fields[12])) / ticks
        mine, total = {self.driver.service.process.pid}, 0
        while mine:
            total += sum(seconds[process] for process in mine)
            mine = {process for process, parent in parents.items() if parent in mine}
        return total

    def messages(self):
        """Errors and warnings of the page."""
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def requests(self):
        """Addresses that the page loaded, except itself and its own content."""
        addresses = []
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                addresses.append(message["params"]["request"]["url"])
        return [a for a in addresses if not a.startswith(("file://", "data:", "blob:"))]

    def touch(self, *moments):
        """Fingers on the page: for each moment a list of their positions (x, y). Then none."""
        kind = "touchStart"
        for places in moments + ([],):
            points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]
            self.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {
                "type": kind if places else "touchEnd", "touchPoints": points})
            kind = "touchMove"

    def set_canvas(self, width, height):
        self.run("for (const {canvas} of kirireel.stages) {"
                 "  canvas.style.width = arguments[0] + 'px';"
                 "  canvas.style.height = arguments[1] + 'px';"
                 "}"
                 "kirireel.resized(); kirireel.showView(0);", width, height)

    def move_slider(self, position):
        self.run("const slider = document.getElementById('slider');"
                 "slider.value = arguments[0];"
                 "slider.dispatchEvent(new Event('input', {bubbles: true}));", position)

    def canvas_picture(self):
        """The picture on the canvas: rows x columns x 3, 0 to 255."""
        self.wait_until_fine()
        canvas = self.driver.find_element("css selector", "canvas")
        return picture_of(canvas.screenshot_as_png)


def picture_of(png):
    return numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=float)


def likeness(picture, other):
    """The peak signal-to-noise ratio, decibels."""
    error = numpy.mean((picture - other) ** 2)
    return 10 * numpy.log10(255 ** 2 / max(error, 1e-12))


def grown(mask, pixels):
    """A mask grown by so many pixels, across and down."""
    result = mask.copy()
    for dy in range(-pixels, pixels + 1):
        for dx in range(-pixels, pixels + 1):
            result |= numpy.roll(mask, (dy, dx), (0, 1))
    return result


def lines_of(picture, tolerance):
    """A mask of the colour of outlines, within so many levels."""
    return (abs(picture - OUTLINE) < tolerance).all(axis=2)
