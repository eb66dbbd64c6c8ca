"""Test HTML pages in Chromium: `pages.py DATASET ... -- SCENE SIGNALS ... -- PREDICTED`.

The first dataset needs a study with a goal. Give the table of its signals with each page of a row. PREDICTED contains predictions of
`decore predict` with the models of the first dataset.

All pages: every plot is drawn without an error on the console, at 1280, 800 and 390 pixels, light, dark and in print, and can be saved as SVG.

The first page: the answer is visible at the top, and fills the first page of A4. Sliders react within 50 ms and change the prediction.
Predictions equal decore's to 1e-9. Limits of a panel and of a column are independent. Hovering shows a row, dragging selects rows. The keyboard
alone can set, change and remove limits, and sort rows. For an unfinished sweep with many factors the page shows missing and hidden rows, and
stays legible. Names of 10 kB do not make it wider. With 100,000 rows of 20 columns, it shows its first plots within a second and reacts to
a drag within 100 ms, at any scroll position.

Pages of a row: pointer and keyboard play, set, jump and zoom the time. Moving parts agree with the signals to 1e-6 m, at 30 frames a
second. The page has at most 5 MB. The plan is to scale. Side views show tilt, displacement and bending as the signals have them, times the
factor that they state.

LIMIT_FACTOR multiplies all time limits, for busy machines.
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

import pyarrow.parquet
import pypdf
from playwright.sync_api import sync_playwright

ROWS, COLUMNS = 100_000, 20
SCENE_MB, FRAMES_PER_SECOND, POSITION_M = 5, 30, 1e-6
# Largest error of a drawn motion, as a share of the largest motion: signals have 65536 steps.
ASIDE = 1e-4
# As ASIDE, for a bent casting between its stations: the outline is a line of 48 pieces.
BENDING = 1e-3
SLIDE_MS, ALIKE = 50, 1e-9
FACTOR = float(os.environ.get("LIMIT_FACTOR", "1"))
BLANK = """() => [...document.querySelectorAll('figure')].filter((figure) => {
    const canvas = figure.querySelector('canvas');
    const context = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const pixels = new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
    return !pixels.some((pixel) => pixel !== 0);
}).map((figure) => figure.textContent)"""

SVGS = """() => [...figures].filter((figure) => {
    const document = new DOMParser().parseFromString(figure.svg(), 'image/svg+xml');
    return document.querySelector('parsererror') || !document.querySelector('polyline, rect + rect, circle, polygon');
}).map((figure) => figure.title)"""
# Distance in pixels of the outermost labels of parallel coordinates from the figure's edges, left and right.
ENDS = """() => {
    const drawn = document.createElement('div'), figure = [...figures].find(({ title }) => title === 'Parallel coordinates');
    drawn.innerHTML = figure.svg();
    document.body.append(drawn);
    const box = drawn.querySelector('svg').getBoundingClientRect(), texts = [...drawn.querySelectorAll('text')].map((text) => text.getBoundingClientRect());
    drawn.remove();
    return [Math.min(...texts.map((text) => text.left)) - box.left, box.right - Math.max(...texts.map((text) => text.right))];
}"""
# Drawn positions of a hammer's parts, compared with the signals.
POSES = """async (times) => {
    const { mechanism } = await scene, { hammers } = mechanism.meta;
    return times.map((time) => hammers.map((hammer, h) => {
        const pose = mechanism.pose(h, time);
        return {
            extension_m: pose.cylinder - pose.guide, piston_m: pose.piston - pose.rear, spool_m: pose.spool, arm_displacement_m: pose.guide,
            chisel_m: pose.shank - pose.rear - hammer.piston_stroke_m - DRAWN.piston,
        };
    }));
}"""

# Side views of all castings at these times, as they are drawn: outline of the casting and marks of its points, in pixels; and their scale.
SIDES = """async (times) => {
    const { sides, view } = await scene, { meta } = sides, found = [], width = 900;
    const names = (c, { kind, index }) => ({ strike: () => `${meta.hammers[index].name}_casting`, held: () => `${meta.castings[c].name}_fixture_${meta.castings[c].fixtures[index].name}_casting`,
        core: () => `${meta.castings[c].name}_core_${meta.castings[c].cores[index].name}`, measured: () => `${meta.castings[c].name}_measuring_point` })[kind]();
    for (let c = 0; c < meta.castings.length; c++) {
        sides.chosen = c;
        sides.rename();
        const { motion, factor } = sides.side();
        for (const side of sides.views) for (const time of side.axis === undefined ? [] : times) {
            view.seek(time);
            let outline = null;
            const nothing = () => {}, painter = { line: nothing, rect: nothing, dots: nothing, text: nothing, image: nothing, polygon(points, { fill }) { if (fill === '#b98f7a') outline = points; } };
            side.paint(painter, width);
            const at = side.place(width), { axis } = side;
            found.push({
                casting: meta.castings[c].name, elastic: meta.castings[c].elastic, axis, time, factor, scale: at.scale, top: at.top, bottom: at.bottom, middle: at.x(0), outline,
                title: side.figure.title, size: motion.shape.size, largest: motion.largest, ends: motion.shape.across[axis],
                marks: side.marks.map(({ kind, index, x, y, rest }) => {
                    const { frame, along } = motion.motion.find(kind, index);
                    return { x, y, rest, name: names(c, { kind, index }), frame, along };
                }),
            });
        }
    }
    sides.exaggerate(10 * sides.side().factor);
    const own = sides.views[0].figure.title;
    sides.exaggerate(NaN);
    return { found, own, automatic: sides.views[0].figure.title };
}"""

# Marks of the plan, in pixels, and places of two of its axes' points.
PLAN = """() => {
    const figure = [...figures].find(({ title }) => title === 'From above, to scale');
    figure.draw();
    return figure.marks.map(({ kind, name, at, x, y }) => ({ kind, name, at, x, y }));
}"""

# Predictions of rows { factors, one column each } by the page's models: mean and standard deviation of each output.
PREDICTIONS = """(rows) => {
    const model = new PageModel(meta.models.found.model, pageBytes), count = Object.values(rows)[0].length;
    return Object.fromEntries(model.outputs.filter(({ process }) => process).map((output) => [output.output, Array.from({ length: count }, (_, i) => {
        const { mean, stdDev } = output.process.predict(Float64Array.from(model.factors, (factor) => factor.scaled(rows[factor.name][i])));
        return [mean, stdDev];
    })]));
}"""
PARALLEL = "figure:has(canvas[aria-label='Parallel coordinates']) canvas"


def grown(page: str) -> str:
    """Return the page with the rows of a large dataset."""
    inside = lambda name: re.search(f'id="{name}">(.*?)</script>', page, re.S)
    meta, random_ = json.loads(inside("meta")[1]), random.Random(1)
    kept = [c for c in meta["columns"] if c["name"] in ("row", "status", "reason") or c["group"] == "factor"]
    others = [c for c in meta["columns"] if c not in kept and c["form"] != "u8"]
    meta["columns"] = kept + sorted(others, key=lambda c: c["rank"] < 0)[: COLUMNS - len(kept)]
    meta["rows"] = meta["rows_there"] = meta["rows_shown"] = ROWS
    # A page has no models of so many rows.
    meta["answer"], meta["models"] = None, {"found": None, "why": "Models take longer than a page should."}
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


def lone(page: str) -> str:
    """Return the page with only the first row."""
    start, end = re.search('id="meta">(.*?)</script>', page, re.S).span(1)
    meta = json.loads(page[start:end])
    meta.update(rows=1, rows_there=1, rows_shown=1)
    return page[:start] + json.dumps(meta).replace("<", "\\u003c") + page[end:]


def unfinished(page: str) -> tuple[str, int]:
    """Return the page of a sweep with three missing rows and 30 more factors, and its number of rows."""
    start, end = re.search('id="meta">(.*?)</script>', page, re.S).span(1)
    meta = json.loads(page[start:end])
    meta["rows"] = meta["rows_there"] + 3
    factor = next(c for c in meta["columns"] if c["group"] == "factor" and not c.get("names"))
    factor["subject"] = "distance from here to there and back"
    meta["columns"] += [dict(factor, name=f"factor_more_{k}", subject=f"more_{k}") for k in range(30)]
    return page[:start] + json.dumps(meta).replace("<", "\\u003c") + page[end:], meta["rows"]


def long_names(page: str) -> str:
    """Return the page of a study whose title, a factor's name and a note have 10 kB without a blank."""
    start, end = re.search('id="meta">(.*?)</script>', page, re.S).span(1)
    meta, name = json.loads(page[start:end]), "A" * 10_000
    meta["title"] = name
    next(c for c in meta["columns"] if c["group"] == "factor")["subject"] = name
    if meta["models"]["found"]:
        meta["models"]["found"]["surrogate"]["notes"].append(f"The rows have few values of `{name}`.")
    return page[:start] + json.dumps(meta).replace("<", "\\u003c") + page[end:]


class Browser:
    """Opens pages and collects their errors."""

    def __init__(self, chromium):
        self.chromium = chromium

    def open(self, path: pathlib.Path, width: int, scheme: str = "light"):
        page = self.chromium.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
        page.wrong = []
        page.on("console", lambda message: page.wrong.append(message.text))
        page.on("pageerror", lambda error: page.wrong.append(str(error)))
        page.on("request", lambda request: None if request.url.startswith(("file:", "blob:", "data:")) else page.wrong.append(request.url))
        page.goto(path.resolve().as_uri())
        page.wait_for_function("performance.getEntriesByName('decore-whole').length > 0")
        return page

    def is_drawn(self, path: pathlib.Path, width: int, scheme: str = "light") -> None:
        page = self.open(path, width, scheme)
        for at in range(0, page.evaluate("document.body.scrollHeight"), 400):
            page.evaluate(f"scrollTo(0, {at})")
            page.wait_for_timeout(60)
        blank, wide = page.evaluate(BLANK), page.evaluate("document.documentElement.scrollWidth")
        assert not page.wrong and not blank and wide <= width, f"{path} at {width}, {scheme}: {page.wrong}, blank {blank}, {wide} px wide"
        if width == 1280 and scheme == "light":
            page.pdf()
            assert not page.evaluate(BLANK) and not page.wrong, f"{path} in print: {page.wrong}"
            # The printed page has the labels of the axes on the same canvas; hide all others.
            page.emulate_media(media="print")
            hidden = "[...document.querySelectorAll('canvas.over')].every((one) => getComputedStyle(one).display === 'none')"
            page.evaluate("dispatchEvent(new Event('beforeprint'))")
            lone = page.evaluate("[...figures].filter((figure) => figure.still && figure.stood !== 0).map((figure) => figure.title)")
            assert page.evaluate(hidden) and not lone, f"{path} in print: no axes of {lone}"
        page.close()

    def saves(self, path: pathlib.Path) -> None:
        """Every figure is an SVG that can be read; a button saves one, by the keyboard."""
        page = self.open(path, 1280)
        broken = page.evaluate(SVGS)
        button = page.get_by_role("button", name="Save as SVG").first
        button.focus()
        with page.expect_download() as download:
            page.keyboard.press("Enter")
        text = pathlib.Path(download.value.path()).read_text(encoding="utf-8")
        assert not broken and text.startswith("<svg") and not page.wrong, f"{path}: no SVG of {broken}, {page.wrong}"
        page.close()

    def moves(self, path: pathlib.Path, signals: pathlib.Path) -> tuple[float, float]:
        """Play, set, jump, zoom and hover. Return frames a second, and the largest distance in m between drawing and signals."""
        page = self.open(path, 1280)
        shown = lambda: page.evaluate("scene.then(({ view }) => [view.from, view.to, view.now])")
        page.keyboard.press("n")
        first = page.evaluate("scene.then(({ player }) => player.blows[0].start_s)")
        assert abs(shown()[2] - first + 0.0005) < 1e-9, f"the first blow is at {first}, the time {shown()[2]}"
        before = shown()[2]
        page.get_by_label("Next blow").click()
        assert shown()[2] > before
        slider = page.get_by_label("Time", exact=True)
        slider.focus()
        middle = page.evaluate("scene.then(({ view }) => Math.round(500 * view.end) / 1000)")
        slider.evaluate("(node, time) => { node.value = String(time); node.dispatchEvent(new Event('input')); }", middle)
        assert abs(shown()[2] - middle) < 1e-9 and f"{1000 * middle:.3f} ms" in page.inner_text(".player .count"), "the slider sets no time"
        canvas = page.locator("section:has(h2:text-is('Over time')) canvas").first
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        page.mouse.move(box["x"] + 300, box["y"] + 60)
        assert "ms" in page.inner_text(".tip"), "hovering tells nothing"
        page.mouse.down()
        page.mouse.move(box["x"] + 400, box["y"] + 60)
        page.mouse.up()
        near = shown()
        assert near[1] - near[0] < 0.15 * page.evaluate("scene.then(({ view }) => view.end)"), f"a drag zooms to {near}"
        page.keyboard.down("Control")
        page.mouse.wheel(0, -200)
        page.keyboard.up("Control")
        page.wait_for_timeout(100)
        nearer = shown()
        assert nearer[1] - nearer[0] < near[1] - near[0], "the wheel does not zoom"
        page.evaluate("document.activeElement.blur()")
        page.keyboard.press("ArrowRight")
        assert shown()[0] > nearer[0], "the arrow does not move the view"
        page.keyboard.press("0")
        assert shown()[0] == 0, "0 does not show all"
        page.evaluate("scrollTo(0, 0)")
        before = shown()[2]
        page.keyboard.press(" ")
        page.wait_for_timeout(500)
        begin = page.evaluate("scene.then(({ player }) => [player.frames, performance.now()])")
        page.wait_for_timeout(2000)
        end = page.evaluate("scene.then(({ player }) => [player.frames, performance.now()])")
        page.keyboard.press(" ")
        assert shown()[2] > before, "the mechanism does not play"
        assert not page.wrong, f"{path}: {page.wrong}"
        off = self.off(page, signals)
        page.close()
        return 1000 * (end[0] - begin[0]) / (end[1] - begin[1]), off

    def off(self, page, signals: pathlib.Path) -> float:
        """Return the largest distance in m between the drawing and a table of signals."""
        table = pyarrow.parquet.read_table(signals)
        column = lambda name: table[name].to_numpy()
        places = range(0, table.num_rows, 7)
        poses = page.evaluate(POSES, [float(column("time_s")[place]) for place in places])
        names = page.evaluate("meta.hammers.map((hammer) => hammer.name)")
        quantities = ["extension_m", "piston_m", "spool_m", "arm_displacement_m", "chisel_m"]
        return max(
            abs(pose[h][quantity] - column(f"{name}_{quantity}")[place])
            for h, name in enumerate(names)
            for quantity in quantities
            for place, pose in zip(places, poses)
        )

    def stands(self, path: pathlib.Path, signals: pathlib.Path) -> float:
        """Check plan and side views: places to scale, tilt, displacement and bending. Return the largest error over the largest motion."""
        page = self.open(path, 1280)
        table = pyarrow.parquet.read_table(signals)
        column = lambda name: table[name].to_numpy()
        times, worst, compared = column("time_s"), 0.0, 0
        # The page shows what blows do: also when the castings move most.
        castings = page.evaluate("meta.castings.map(({ name }) => name)")
        rows = sorted({*(int(abs(column(f"{name}_heave_m")).argmax()) for name in castings), len(times) // 3, len(times) // 2})
        views = page.evaluate(SIDES, [float(times[row]) for row in rows])
        factor = lambda title: float(title.rsplit("×", 1)[1])
        assert factor(views["own"]) == 10 * factor(views["automatic"]), f"the title states {views['own']}"
        for view in views["found"]:
            row = min(rows, key=lambda row: abs(times[row] - view["time"]))
            moved = lambda y, rest: (y - rest) / (view["factor"] * view["scale"]) / view["largest"]
            heave, *turns = (column(f"{view['casting']}_{name}")[row] for name in ("heave_m", "rotation_x_rad", "rotation_y_rad"))
            # A point a, b moves by z + b rx - a ry.
            slope = [-turns[1], turns[0]][view["axis"]]
            rigid = lambda at: heave + slope * at
            assert factor(view["title"]) == view["factor"] >= 1, f"the title states {view['title']}"
            assert view["factor"] == 1 or 0.03 < view["factor"] * view["largest"] / view["size"] < 0.0801, "the factor shows no motion of 8 % of the size"
            if not view["elastic"]:
                corners = [*zip(view["outline"][::2], view["outline"][1::2])]
                for (x, y), across, rest in zip(corners, [*view["ends"], *view["ends"][::-1]], [view["top"]] * 2 + [view["bottom"]] * 2):
                    assert abs(x - view["middle"] - view["scale"] * across) < 1e-6, "the casting is not to scale"
                    worst = max(worst, abs(moved(y, rest) - rigid(across) / view["largest"]))
            # Bends of the points at each station along the view.
            stations = {}
            for mark in view["marks"]:
                name = f"{mark['name']}_displacement_m"
                assert abs(mark["x"] - view["middle"] - view["scale"] * mark["frame"][view["axis"]]) < 1e-6, "a point is not to scale"
                # Along another direction than the casting's a signal has another motion.
                if abs(abs(mark["along"]) - 1) < 1e-9:
                    worst = max(worst, abs(moved(mark["y"], mark["rest"]) - mark["along"] * column(name)[row] / view["largest"]))
                    compared += 1
                    a, b, _ = mark["frame"]
                    bend = mark["along"] * column(name)[row] - (heave + b * turns[0] - a * turns[1])
                    stations.setdefault(round(mark["frame"][view["axis"]], 9), []).append(bend)
            edge = [(x, moved(y, view["top"])) for x, y in zip(view["outline"][::2], view["outline"][1::2])]
            edge = edge[: len(edge) // 2]
            for across, bends in stations.items() if view["elastic"] else ():
                (x0, y0), (x1, y1) = next(pair for pair in zip(edge, edge[1:]) if pair[1][0] >= view["middle"] + view["scale"] * across)
                drawn = y0 + (y1 - y0) * (view["middle"] + view["scale"] * across - x0) / (x1 - x0)
                expected = (rigid(across) + sum(bends) / len(bends)) / view["largest"]
                assert abs(drawn - expected) < BENDING, f"the casting bends by {drawn} of the largest motion at {across} m, not {expected}"
        assert compared, "no point is compared with its signal"
        marks = page.evaluate(PLAN)
        first, last = (max(marks, key=lambda mark: sign * (mark["at"][0] + mark["at"][1])) for sign in (1, -1))
        scale = [(first[side] - last[side]) / (first["at"][k] - last["at"][k]) for k, side in enumerate("xy") if abs(first["at"][k] - last["at"][k]) > 1e-9]
        apart = max(mark["at"] for mark in marks) != min(mark["at"] for mark in marks)
        assert bool(scale) == apart and all(abs(abs(one) - abs(scale[0])) < 1e-6 * abs(scale[0]) for one in scale), f"the plan is not to scale: {scale}"
        kinds = {mark["kind"] for mark in marks}
        assert {"strike", "centre"} <= kinds and kinds & {"pad", "spring", "clamp"}, f"the plan shows only {kinds}"
        assert not page.wrong, f"{path}: {page.wrong}"
        page.close()
        return worst

    def answers(self, path: pathlib.Path) -> tuple[float, float, float]:
        """Hover and drag over the parallel coordinates. Return ms until plots were visible, and the longest reaction to a drag and a limit."""
        page = self.open(path, 1280)
        drawn = page.evaluate("performance.getEntriesByName('decore-drawn')[0].startTime")
        canvas = page.locator(PARALLEL).first
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
        for at in range(0, page.evaluate("document.body.scrollHeight"), 800):
            page.evaluate(f"scrollTo(0, {at})")
            page.wait_for_timeout(60)
            page.evaluate("selection.set([[state.shown[0], { low: state.shown[0].low, high: state.shown[0].high / (1 + scrollY / 1e4) }]])")
        anywhere = page.evaluate("Math.max(...performance.getEntriesByName('decore-brush').map((entry) => entry.duration))")
        assert not page.wrong, page.wrong
        page.close()
        return drawn, brush, anywhere

    def decides(self, path: pathlib.Path, predicted: pathlib.Path) -> tuple[float, float]:
        """Checks the answer of a page: first screen, sliders, predictions, print. Returns the slowest reaction in ms and the error of predictions."""
        page = self.open(path, 1280)
        seen = "(node) => { const box = node.getBoundingClientRect(); return box.top >= 0 && box.bottom <= innerHeight; }"
        for what in (".lead", ".tile.choose", "canvas[aria-label='Plan of the machine, from above']"):
            assert page.locator(what).first.evaluate(seen), f"{path}: {what} is not in the first screen"
        page.wait_for_timeout(2000 * FACTOR)
        assert page.evaluate("performance.getEntriesByName('decore-rest').length"), "the picture at rest is not drawn"
        before, sliders = page.inner_text("#compared"), page.locator(".slider input[type=range]:enabled")
        page.evaluate("performance.clearMeasures()")
        for place in range(sliders.count()):
            for share in (0.3, 0.5, 0.35, 0.45, 0.4):
                sliders.nth(place).evaluate("(node, share) => { node.value = share; node.dispatchEvent(new Event('input')); }", share)
                page.wait_for_timeout(60)
        times = sorted(page.evaluate("performance.getEntriesByName('decore-slide').map((entry) => entry.duration)"))
        page.wait_for_timeout(800)
        after = page.inner_text("#compared")
        assert after != before and "Placement B" in after, "sliders change no prediction"
        page.locator(".slider .all input").first.click()
        page.wait_for_timeout(800)
        assert page.inner_text("#compared") != after, "an uncertain factor at one value changes no prediction"
        off = self.alike(page, predicted)
        self.limits_apart(page)
        assert not page.wrong, f"{path}: {page.wrong}"
        self.on_paper(page, path)
        page.close()
        # Nine of ten, because the machine may be busy.
        return times[int(0.9 * (len(times) - 1))], off

    def alike(self, page, predicted: pathlib.Path) -> float:
        """Returns the largest difference between the page's predictions and a table's, over the spread of an output."""
        table = pyarrow.parquet.read_table(predicted)
        rows = {name.removeprefix("factor_"): table[name].to_pylist() for name in table.column_names if name.startswith("factor_")}
        worst = 0.0
        for output, found in page.evaluate(PREDICTIONS, rows).items():
            ours, std_dev = table[output].to_pylist(), table[f"{output}_std_dev"].to_pylist()
            size = max(ours) - min(ours)
            worst = max([worst, *(max(abs(m - a), abs(s - b)) / size for (m, s), a, b in zip(found, ours, std_dev))])
        return worst

    def limits_apart(self, page) -> None:
        """A brush over a panel leaves the limits of its columns alone."""
        count = lambda: int(page.inner_text(".bar .count").split()[0])
        column = "state.shown[0]"
        page.evaluate(f"selection.set([[{column}, {{ low: {column}.low, high: ({column}.low + {column}.high) / 2 }}]])")
        limited = count()
        area, half = "selection.area(state.shown[0], state.shown[1])", "(state.shown[1].low + state.shown[1].high) / 2"
        page.evaluate(f"selection.set([[{area}, [{{ low: -1e99, high: 1e99 }}, {{ low: state.shown[1].low, high: {half} }}]]])")
        both = count()
        page.evaluate(f"selection.set([[{area}, null]])")
        assert both < limited == count(), f"{limited} rows within a limit are {both} with a brush and {count()} after it"
        page.get_by_role("button", name="clear all").click()

    def on_paper(self, page, path: pathlib.Path) -> None:
        """The answer is the first page of A4, whole and alone."""
        sheet = pathlib.Path(path).with_suffix(".pdf")
        page.pdf(path=sheet, format="A4")
        first, second, *_ = [" ".join(one.extract_text().split()) for one in pypdf.PdfReader(sheet).pages]
        sheet.unlink()
        for text in ("Two placements", "Behind the answer", "To reduce it"):
            assert text in first and text not in second, f"`{text}` is not on the first page alone"
        assert "rows are there" in second and "rows are there" not in first, "the rows do not begin on the second page"

    def obeys(self, path: pathlib.Path) -> None:
        """Sets, changes and removes a limit and sorts the rows, by the keyboard alone."""
        page = self.open(path, 1280)
        count = lambda: int(page.inner_text(".count").split()[0])
        everything = count()
        page.locator(".bar form select").focus()
        page.keyboard.press("Tab")
        page.keyboard.press("Enter")
        within = count()
        field = page.locator(".chip input").first
        field.focus()
        page.keyboard.press("Control+A")
        page.keyboard.type("1e9")
        page.keyboard.press("Tab")
        assert count() == 0 < within, f"a limit beyond all values leaves {count()} rows"
        page.locator(".chip button").focus()
        page.keyboard.press("Enter")
        assert count() == everything, "the limit is not removed"
        heading = page.locator("#rows th button").first
        heading.focus()
        page.keyboard.press("Enter")
        page.wait_for_timeout(50)
        rows = [int(text) for text in page.locator("#rows tbody td:first-child").all_inner_texts()]
        assert rows == sorted(rows, reverse=rows[0] > rows[-1]) and len(rows) > 1, f"the heading sorts to {rows}"
        assert not page.wrong, f"{path}: {page.wrong}"
        page.close()


    def tells(self, path: pathlib.Path, rows: int) -> None:
        """Check the page of an unfinished sweep with many factors: missing rows, hidden rows, labels of many columns, a single column."""
        page = self.open(path, 1280)
        text = page.inner_text("main")
        assert f"3 of {rows} rows are still to come." in text and "All rows are done" not in text, "rows to come are not told"
        assert re.search(r"The figure shows the 24 factors .*; \d+ more are hidden", text), "no note on hidden factors"
        refused = "usedWords({ used: { whole: 1, of: 2, unit: 'rows', left_out: [] }, refused: 'no indices: why', notes: [] })"
        assert page.evaluate(refused) == "No indices: why. From 1 of 2 rows."
        page.evaluate("[...document.querySelectorAll('.choice input:checked')].slice(2).forEach((box) => box.click())")
        left, right = page.evaluate(ENDS)
        assert left >= 0 and right >= 0, f"texts of parallel coordinates lie {left} and {right} px within the figure"
        page.evaluate("[...document.querySelectorAll('.choice input:checked')].slice(1).forEach((box) => box.click())")
        tall = "[...figures].filter(({ title }) => ['Parallel coordinates', 'Scatter matrix'].includes(title)).map((one) => (one.draw(), one.tall))"
        assert max(page.evaluate(tall)) < 60, "a view of several columns has one"
        page.evaluate("state.shown = table.columns; rows()")
        highest = page.evaluate("Math.max(...[...document.querySelectorAll('#rows td.text')].map((cell) => cell.clientHeight))")
        assert highest < 50, f"texts of rows break into lines, {highest} px high"
        assert not page.wrong, f"{path}: {page.wrong}"
        page.close()


def main(paths: list[pathlib.Path], scenes: list[tuple[pathlib.Path, pathlib.Path]], predicted: pathlib.Path) -> None:
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as scratch:
        executable = shutil.which("chromium") or shutil.which("chromium-browser")
        chromium = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        browser = Browser(chromium)
        for path in [*paths, *(path for path, _ in scenes)]:
            for width in (1280, 800):
                browser.is_drawn(path, width)
            browser.is_drawn(path, 1280, "dark")
        for path in [*paths, *(path for path, _ in scenes)]:
            for scheme in ("light", "dark"):
                browser.is_drawn(path, 390, scheme)
        for path in [*paths, *(path for path, _ in scenes)]:
            browser.saves(path)
        for path, signals in scenes:
            rate, off = browser.moves(path, signals)
            size = path.stat().st_size / 1e6
            print(f"{path.name}: {size:.1f} MB, {rate:.0f} frames a second, drawn {off:.1e} m beside the signals")
            aside = browser.stands(path, signals)
            print(f"{path.name}: side views are {aside:.1e} of the largest motion beside the signals")
            assert aside <= ASIDE, "over its limit"
            assert size <= SCENE_MB and rate >= FRAMES_PER_SECOND / FACTOR and off <= POSITION_M, "over its limits"
        slide, off = browser.decides(paths[0], predicted)
        print(f"sliders answer in {slide:.0f} ms, predictions differ by {off:.1e} of the outputs' spread")
        assert slide <= SLIDE_MS * FACTOR and off <= ALIKE, "over its limits"
        browser.answers(paths[0])
        browser.obeys(paths[0])
        part = pathlib.Path(scratch) / "part.html"
        text, rows = unfinished(paths[0].read_text(encoding="utf-8"))
        part.write_text(text, encoding="utf-8")
        browser.tells(part, rows)
        part.write_text(lone(paths[0].read_text(encoding="utf-8")), encoding="utf-8")
        page = browser.open(part, 1280)
        factors = page.evaluate("table.columns.filter(({ group }) => group === 'factor').map(({ label }) => label)")
        heads = page.inner_text("#rows thead")
        assert not page.wrong and all(factor in heads for factor in factors), f"{factors} of a row alone are not all in {heads}"
        page.close()
        part.write_text(long_names(paths[0].read_text(encoding="utf-8")), encoding="utf-8")
        page = browser.open(part, 1280)
        width = page.evaluate("document.documentElement.scrollWidth")
        assert not page.wrong and width == 1280, f"a page with long names is {width} pixels wide, not 1280"
        page.close()
        large = pathlib.Path(scratch) / "large.html"
        large.write_text(grown(paths[0].read_text(encoding="utf-8")), encoding="utf-8")
        # The first of three includes the browser's warm-up.
        times = [browser.answers(large) for _ in range(3)]
        drawn, brush, anywhere = (min(column) for column in zip(*times))
        size = large.stat().st_size / 1e6
        print(f"{len(paths)} pages are drawn; {ROWS} rows of {COLUMNS} columns: {size:.1f} MB, drawn in {drawn:.0f} ms, a drag in {brush:.0f} ms, anywhere in {anywhere:.0f} ms")
        assert size <= 15 and drawn <= 1000 * FACTOR and max(brush, anywhere) <= 100 * FACTOR, "over its limits"
        chromium.close()


first = sys.argv.index("--")
last = sys.argv.index("--", first + 1)
files = [pathlib.Path(name) for name in sys.argv[first + 1 : last]]
main([pathlib.Path(name) for name in sys.argv[1:first]], list(zip(files[::2], files[1::2])), pathlib.Path(sys.argv[last + 1]))
