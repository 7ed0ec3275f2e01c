"""Opens report.html in Chromium, uses it as a person would, and checks what it shows.

    python3 report.py REPORT.html [FOLDER] [--meshes]

Needs Chromium with its driver, and Selenium (PyPI). Pictures of the page (light, dark, on a telephone) are written to FOLDER.
With --meshes the arm has to be drawn with meshes.
"""

import re
import sys
import time
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select, WebDriverWait

FLAGS = """--headless=new --no-sandbox --disable-quic --no-first-run --disable-background-networking
    --disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader"""
PATIENCE = 60


def browser():
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in FLAGS.split():
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))


def opened(driver, page, mark, size):
    """Opens the page and waits until it is drawn."""
    driver.set_window_size(*size)
    driver.get("about:blank")
    driver.get(f"{page}#{mark}")
    WebDriverWait(driver, PATIENCE).until(lambda d: d.find_element(By.TAG_NAME, "body").get_attribute("data-state") == "ready")


class Page:
    """What a person sees and does."""

    def __init__(self, driver):
        self.driver = driver
        self.run = driver.execute_script

    def clock(self):
        return float(self.text("clock").split()[0])

    def text(self, name):
        return self.driver.find_element(By.ID, name).text

    def click(self, name):
        self.driver.find_element(By.ID, name).click()

    def title(self):
        return self.run("return document.getElementById('joints').layout.yaxis.title.text")

    def tip(self):
        return self.run("const m = document.getElementById('arm').data[2]; return [m.x[0], m.y[0], m.z[0]]")

    def until(self, what, words):
        WebDriverWait(self.driver, PATIENCE).until(lambda _: what(), words)


def check(page, meshes):
    run = page.run
    assert run("return document.querySelectorAll('#arm canvas').length") >= 1, "the arm is not drawn"
    for name, least in [("feed", 2), ("joints", 6)]:
        traces = run(f"return document.querySelectorAll('#{name} .scatterlayer .trace').length")
        assert traces >= least, f"{name}: {traces} curves"
    rows = page.driver.find_elements(By.CSS_SELECTOR, "#limits tbody tr")
    assert len(rows) >= 8
    used = float(rows[0].find_elements(By.TAG_NAME, "td")[4].text.split()[0])
    assert 50 < used <= 100.01, f"the limit that is used most is on top: {used}"

    # A click on a limit goes to its worst place and shows its quantity.
    jerk = next(row for row in rows if row.text.startswith("joint jerk"))
    jerk.click()
    there = float(jerk.find_elements(By.TAG_NAME, "td")[5].text.split()[0])
    page.until(lambda: abs(page.clock() - there) < 2e-3, "goes to the worst place")
    page.until(lambda: page.title().startswith("jerk"), "shows the jerk")

    # A click on the curve at the slowest place tells what limits there.
    t, slowest = run(
        """const data = JSON.parse(document.getElementById('data').textContent), end = data.report.duration_s;
        const inside = data.t.map((t, i) => i).filter((i) => data.t[i] > 0.1 * end && data.t[i] < 0.9 * end);
        const i = inside.reduce((least, i) => data.feed[i] < data.feed[least] ? i : least, inside[0]);
        return [data.t[i], data.feed[i]]"""
    )
    x, y = run(
        """const plot = document.getElementById('feed'), l = plot._fullLayout, box = plot.getBoundingClientRect();
        return [box.x + l.xaxis._offset + l.xaxis.l2p(arguments[0]), box.y + l.yaxis._offset + l.yaxis.l2p(1e3 * arguments[1])]""",
        t,
        slowest,
    )
    mouse = ActionChains(page.driver, duration=100)
    mouse.w3c_actions.pointer_action.move_to_location(int(x), int(y))
    mouse.pause(0.5).click().perform()
    page.until(lambda: abs(page.clock() - t) < 0.03, "goes to the place that is clicked")
    words = page.text("now")
    assert re.search(r"mm/s.*(limited by|set by) \w+", words), words
    left, wanted = run(
        """const x = document.getElementById('feed')._fullLayout.xaxis;
        return [parseFloat(document.querySelector('#feed + .cursor').style.left), x._offset + x.l2p(time)]"""
    )
    assert abs(left - wanted) < 0.6, "the cursor stands at the time"

    # Meshes stand at the joints.
    off = run(
        """const shape = data.shape, points = armAt(time), drawn = document.getElementById('arm').data[0];
        if (!shape) return arguments[0] ? -1 : 0;
        const corners = shape.meshes.reduce((sum, mesh) => sum + mesh.points.length / 3, 0);
        if (drawn.x.length < corners || drawn.i.length < 1000) return 1;
        return Math.max(...frames(shape, armAt(time, 'joints')).map((pose) => Math.min(...points.map((_, n) =>
            n % 3 ? 1 : Math.hypot(...[0, 1, 2].map((k) => pose[k] - points[n + k]))))))""",
        meshes,
    )
    assert off >= 0, "the page has no meshes"
    assert off < 1e-3, f"meshes are {off} m off their joints"

    # It plays from the start to where it is paused, and the arm moves.
    run("const s = document.getElementById('scrub'); s.value = 0; s.dispatchEvent(new Event('input'))")
    assert page.clock() == 0
    before = page.tip()
    Select(page.driver.find_element(By.ID, "rate")).select_by_value("0.1")
    page.click("play")
    page.until(lambda: page.clock() > 0.1, "plays")
    page.click("play")
    page.until(lambda: page.text("play") == "Play", "pauses")
    stopped = page.clock()
    assert page.tip() != before, "the arm moves"
    time.sleep(0.3)
    assert page.clock() == stopped, "stands while it is paused"

    # Every quantity, in parts of its limit and in its unit.
    choice = Select(page.driver.find_element(By.ID, "quantity"))
    for name in [option.text for option in choice.options]:
        choice.select_by_visible_text(name)
        page.until(lambda: page.title().startswith(name), f"shows {name}")
    page.click("shares")
    page.until(lambda: "[" in page.title(), "in its unit")
    page.click("shares")

    dark = "return document.documentElement.classList.contains('dark')"
    first = run(dark)
    page.click("theme")
    assert run(dark) != first, "turns dark"


def main(report, folder=None, *, meshes):
    text = Path(report).read_text(encoding="utf-8")
    size = len(text.encode()) / 1e6
    assert size < 6, f"{size:.2f} MB"
    assert not re.search(r'<(script|link|img)[^>]*(src|href)="http', text), "it needs the network"
    page = Path(report).resolve().as_uri()
    driver = browser()
    try:
        opened(driver, page, "light", (1400, 950))
        check(Page(driver), meshes)
        for name, shape, mark in [("light", (1400, 950), "light"), ("dark", (1400, 950), "dark"), ("telephone", (500, 1900), "light")]:
            opened(driver, page, f"{mark}&t=1", shape)
            if folder is not None:
                Path(folder).mkdir(parents=True, exist_ok=True)
                driver.save_screenshot(str(Path(folder) / f"{name}.png"))
        error = driver.find_element(By.TAG_NAME, "body").get_attribute("data-error")
        assert error is None, error
        errors = [entry["message"] for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]
        assert not errors, "\n".join(errors)
    finally:
        driver.quit()
    print(f"{report}: loads, goes to limits and places, plays, pauses, turns dark; {size:.1f} MB")


if __name__ == "__main__":
    main(*(word for word in sys.argv[1:] if word != "--meshes"), meshes="--meshes" in sys.argv)
