"""Pages of datasets in Chromium: `pages.py PAGE ...`, of which the first has more than one row.

Each page must draw every plot without an error on the console, at 1280 and 800 pixels and for print. On the first, hovering
shows a row and dragging selects rows. The same page with 100 000 rows of 20 columns must show its first plots within a second, and a drag
answered within 100 ms (times LIMIT_FACTOR, for machines that do other work at the same time).
"""

import base64
import json
import os
import pathlib
import random
import re
import shutil
import struct
import sys
import tempfile

from playwright.sync_api import sync_playwright

ROWS, COLUMNS = 100_000, 20
FACTOR = float(os.environ.get("LIMIT_FACTOR", "1"))
BLANK = """() => [...document.querySelectorAll('figure')].filter((figure) => {
    const canvas = figure.querySelector('canvas');
    const context = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const pixels = new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
    return !pixels.some((pixel) => pixel !== 0);
}).map((figure) => figure.textContent)"""


def grown(page: str) -> str:
    """The page with the rows of a large dataset in place of its own."""
    inside = lambda name: re.search(f'id="{name}">(.*?)</script>', page, re.S)
    meta, random_ = json.loads(inside("meta")[1]), random.Random(1)
    kept = [c for c in meta["columns"] if c["name"] in ("row", "status", "reason") or c["group"] == "factor"]
    others = [c for c in meta["columns"] if c not in kept and c["form"] != "u8"]
    meta["columns"] = kept + sorted(others, key=lambda c: c["rank"] < 0)[: COLUMNS - len(kept)]
    meta["rows"] = meta["rows_there"] = meta["rows_shown"] = ROWS
    data, base = bytearray(), [random_.random() for _ in range(ROWS)]
    for k, column in enumerate(meta["columns"]):
        data += bytes(-len(data) % 8)
        column["offset"] = len(data)
        if column["name"] == "row":
            column["form"] = "f64"
            data += struct.pack(f"<{ROWS}d", *range(ROWS))
        elif column["form"] == "u8":
            data += bytes(0 if column["names"] else 255 for _ in range(ROWS))
        else:
            column["form"] = "f32"
            data += struct.pack(f"<{ROWS}f", *(k * b + random_.random() for b in base))
    for name, text in (("meta", json.dumps(meta).replace("<", "\\u003c")), ("data", base64.b64encode(data).decode())):
        start, end = inside(name).span(1)
        page = page[:start] + text + page[end:]
    return page


class Browser:
    """Opens pages and gathers what goes wrong in them."""

    def __init__(self, chromium):
        self.chromium = chromium

    def open(self, path: pathlib.Path, width: int):
        page = self.chromium.new_page(viewport={"width": width, "height": 900})
        page.wrong = []
        page.on("console", lambda message: page.wrong.append(message.text))
        page.on("pageerror", lambda error: page.wrong.append(str(error)))
        page.on("request", lambda request: None if request.url.startswith(("file:", "blob:", "data:")) else page.wrong.append(request.url))
        page.goto(path.resolve().as_uri())
        page.wait_for_function("performance.getEntriesByName('decore-whole').length > 0")
        return page

    def is_drawn(self, path: pathlib.Path, width: int) -> None:
        page = self.open(path, width)
        for at in range(0, page.evaluate("document.body.scrollHeight"), 400):
            page.evaluate(f"scrollTo(0, {at})")
            page.wait_for_timeout(60)
        blank, wide = page.evaluate(BLANK), page.evaluate("document.documentElement.scrollWidth")
        assert not page.wrong and not blank and wide <= width, f"{path} at {width}: {page.wrong}, blank {blank}, {wide} px wide"
        if width == 1280:
            page.pdf()
            assert not page.evaluate(BLANK) and not page.wrong, f"{path} in print: {page.wrong}"
        page.close()

    def answers(self, path: pathlib.Path) -> tuple[float, float]:
        """Hovers and drags over the parallel coordinates; ms until plots were in sight, and longest until a drag was answered."""
        page = self.open(path, 1280)
        drawn = page.evaluate("performance.getEntriesByName('decore-drawn')[0].startTime")
        canvas = page.locator("figure canvas").first
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        for y in range(80, int(box["height"]) - 20, 3):
            page.mouse.move(box["x"] + 80, box["y"] + y)
            if page.locator(".tip").is_visible():
                break
        assert "row " in page.inner_text(".tip"), "hovering tells no row"
        everything = page.inner_text(".count")
        page.mouse.move(box["x"] + 55, box["y"] + 100)
        page.mouse.down()
        for y in (160, 200, 230):
            page.mouse.move(box["x"] + 55, box["y"] + y)
        page.mouse.up()
        page.wait_for_timeout(300)
        selected = page.inner_text(".count")
        assert selected != everything and page.locator("#rows tbody tr").count() > 0, f"a drag selects nothing: {selected}"
        brush = page.evaluate("Math.max(...performance.getEntriesByName('decore-brush').map((entry) => entry.duration))")
        page.get_by_role("button", name="clear all").click()
        assert page.inner_text(".count") == everything, "the selection is not let go"
        assert not page.wrong, page.wrong
        page.close()
        return drawn, brush


def main(paths: list[pathlib.Path]) -> None:
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as scratch:
        executable = shutil.which("chromium") or shutil.which("chromium-browser")
        chromium = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        browser = Browser(chromium)
        for path in paths:
            for width in (1280, 800):
                browser.is_drawn(path, width)
        browser.answers(paths[0])
        large = pathlib.Path(scratch) / "large.html"
        large.write_text(grown(paths[0].read_text(encoding="utf-8")), encoding="utf-8")
        # The first of three is also the browser's own warming up.
        times = [browser.answers(large) for _ in range(3)]
        drawn, brush = (min(column) for column in zip(*times))
        size = large.stat().st_size / 1e6
        print(f"{len(paths)} pages are drawn; {ROWS} rows of {COLUMNS} columns: {size:.1f} MB, drawn in {drawn:.0f} ms, a drag in {brush:.0f} ms")
        assert size <= 15 and drawn <= 1000 * FACTOR and brush <= 100 * FACTOR, "over its limits"
        chromium.close()


main([pathlib.Path(name) for name in sys.argv[1:]])
