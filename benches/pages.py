"""The page of `decore report --html` beside HiPlot's and plotly's, of the same rows: size, time to open, time of a brush, memory.

python pages.py DECORE FOLDER [TURNS]

DECORE is the program; FOLDER keeps the two sweeps (100 000 and 1 000 000 rows of the rig over 0.06 s, ten minutes at first, taken
up again later), the pages, and a screenshot of each before and after the brush. Needs pandas, pyarrow, hiplot, plotly, playwright
and a chromium. Prints the tables of RESULTS.md: medians of TURNS (default 5) turns, the pages in turns, a new browser for each.

All pages show the axes that decore's shows when it opens, and carry 20 columns of numbers: those of decore's page that have values,
then the next of the table. HiPlot's numbers have seven digits and plotly's single precision, as decore's: neither carries more.
decore's own page is as the command writes it, with four columns more.

Times, alike for all pages: a script that runs before theirs notes when anything is drawn on a canvas of the document, and at the
end of each frame with such a call copies the last canvas to one of a pixel and reads it, which waits until all before is drawn.

open   from the start of the navigation until the last frame that draws (no other within 2 s); `first` until the first one
brush  the mouse is pressed on the first axis and moved over its middle; once nothing moves any more it is moved by some pixels to two
       thirds of the axis and let go: from the browser's time of this last move to the last frame that draws; `first` to the first
       one; `held` is the longest time between two frames meanwhile
memory resident memory of the page's process after it, and its peak

A page whose brush did not select about a third of the rows ends the script.
"""

import base64
import json
import pathlib
import re
import shutil
import statistics
import subprocess
import sys

import hiplot
import numpy as np
import pandas as pd
import plotly
import plotly.graph_objects as go
import pyarrow.parquet
from playwright.sync_api import sync_playwright

COLUMNS, LARGE, HUGE = 20, 100_000, 1_000_000
EXTREMES = 20  # rows at each end of a column that a thinned page keeps
QUIET_S, LONGEST_S = 2.0, 300

STUDY = """title = "A large table"
duration_s = 0.06

[structure]
source = "station"
cutoff_hz = 1000.0
damping_ratio = 0.02

[hammer.hammer]
mount = "R5"
supply_bar = 5.0
standoff_m = 0.085
start_time_s = 0.002
gate_delay_s = 0.020

[casting.part]
mass_kg = 0.517

[casting.part.fixture.table]
point = "T5"
stiffness_n_per_m = 3e7
damping_n_s_per_m = 4000.0

[solver]
fidelity = "draft"

[design]
kind = "random"
rows = 1000
seed = 1

[design.factor.pressure]
path = "hammer.hammer.supply_bar"
range = [4.0, 6.0]
unit = "bar"

[design.factor.standoff]
path = "hammer.hammer.standoff_m"
range = [0.06, 0.10]
unit = "m"

[design.factor.delay]
path = "hammer.hammer.gate_delay_s"
range = [0.01, 0.02]
unit = "s"

[design.factor.mass]
path = "casting.part.mass_kg"
range = [0.4, 4.0]
unit = "kg"

[design.factor.stiffness]
path = "casting.part.fixture.table.stiffness_n_per_m"
range = [1e7, 1e8]
unit = "N/m"

[design.factor.damping]
path = "casting.part.fixture.table.damping_n_s_per_m"
range = [1000.0, 8000.0]
unit = "N s/m"
"""

# Runs before the page's own scripts. `drawn`: [first, last] end of a frame that drew since `since`, in ms.
WATCH = """(() => {
    const watch = window.watch = { since: 0, drawn: [], held: 0, moved: 0, calls: 0 };
    const probe = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
    let last = null, before = performance.now();
    const wrap = (prototype, names) => names.forEach((name) => {
        const own = prototype[name];
        prototype[name] = function (...given) {
            if (this.canvas.isConnected) { last = this.canvas; watch.calls++; }
            return own.apply(this, given);
        };
    });
    wrap(CanvasRenderingContext2D.prototype, ['stroke', 'fill', 'fillRect', 'strokeRect', 'clearRect', 'drawImage', 'putImageData', 'fillText']);
    for (const one of [WebGLRenderingContext, WebGL2RenderingContext]) wrap(one.prototype, ['drawArrays', 'drawElements', 'clear']);
    watch.begin = () => { Object.assign(watch, { drawn: [], held: 0, moved: 0, calls: 0 }); last = null; before = performance.now(); };
    addEventListener('mousemove', (event) => { watch.moved ||= event.timeStamp; }, { capture: true });
    const channel = new MessageChannel();
    // Comes after what the page does in its own callbacks of the frame.
    channel.port1.onmessage = () => {
        if (last) {
            probe.drawImage(last, 0, 0, 1, 1);
            probe.getImageData(0, 0, 1, 1);
            last = null;
            const now = performance.now();
            watch.drawn = [watch.drawn[0] ?? now, now];
        }
        requestAnimationFrame(frame);
    };
    const frame = (now) => { watch.held = Math.max(watch.held, now - before); before = now; channel.port2.postMessage(0); };
    requestAnimationFrame(frame);
})()"""
SETTLED = f"watch.drawn.length > 0 && performance.now() - watch.drawn[1] > {1000 * QUIET_S}"

# Of each page: the box of its first axis in the window (left, top, width, height), and the number of rows selected.
AXIS = {
    "decore": """() => {
        const box = document.querySelector('figure canvas').getBoundingClientRect();
        return [box.left + 55, box.top + 62, 0, box.height - 62 - 14];
    }""",
    "HiPlot": """() => {
        const axes = [...document.querySelectorAll('.pplot-brush')].map((one) => one.getBoundingClientRect());
        const { left, top, width, height } = axes.sort((a, b) => a.left - b.left)[0];
        return [left + width / 2, top, width, height];
    }""",
    "plotly": """() => {
        const axes = [...document.querySelectorAll('.parcoords .axis-brush .background')].map((one) => one.getBoundingClientRect());
        const { left, top, width, height } = axes.sort((a, b) => a.left - b.left)[0];
        return [left + width / 2, top, 0, height];
    }""",
}
SELECTED = {
    "decore": "() => Number(document.querySelector('.count').textContent.split(' ')[0])",
    "HiPlot": "() => Number(document.body.innerText.match(/Selected:?\\s*(\\d+)/i)[1])",
    "plotly": """() => {
        const { values, constraintrange } = document.querySelector('.js-plotly-plot')._fullData[0].dimensions[0];
        return Array.from(values).filter((value) => value >= constraintrange[0] && value <= constraintrange[1]).length;
    }""",
}


def sweep(decore: str, folder: pathlib.Path, rows: int) -> tuple[pathlib.Path, pathlib.Path]:
    """The dataset of a sweep and decore's page of it."""
    study, dataset, page = folder / "study.toml", folder / str(rows), folder / f"decore_{rows}.html"
    study.write_text(STUDY, encoding="utf-8")
    subprocess.run([decore, "run", study, "--output", dataset, "--set", f"design.rows={rows}"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([decore, "report", dataset, "--html", page], check=True, stdout=subprocess.DEVNULL)
    return dataset, page


class Inside:
    """What decore's page carries."""

    def __init__(self, page: pathlib.Path):
        text = page.read_text(encoding="utf-8")
        block = lambda name: re.search(f'id="{name}">(.*?)</script>', text, re.S)[1]
        self.meta, data = json.loads(block("meta")), base64.b64decode(block("data"))
        kinds, rows = {"f32": np.float32, "f64": np.float64, "u8": np.uint8}, self.meta["rows_shown"]
        self.values = {c["name"]: np.frombuffer(data, kinds[c["form"]], rows, c["offset"]) for c in self.meta["columns"]}
        self.numbers = [c["name"] for c in self.meta["columns"] if c["form"] != "u8" and c["name"] != "row"]


def same_rows(dataset: pathlib.Path, inside: Inside) -> pd.DataFrame:
    """The table that the others are given, in single precision."""
    table = pyarrow.parquet.read_table(dataset / "runs")
    numeric = [f.name for f in table.schema if f.name != "row" and (pyarrow.types.is_floating(f.type) or pyarrow.types.is_integer(f.type))]
    ordered = inside.numbers + [name for name in numeric if name not in inside.numbers]
    whole = [name for name in ordered if table[name].null_count == 0][:COLUMNS]
    frame = table.select(whole).to_pandas().astype(np.float32)
    assert len(frame.columns) == COLUMNS and not frame.isna().any().any()
    return frame


def hiplot_page(frame: pd.DataFrame, axes: list[str], path: pathlib.Path) -> None:
    short = frame.apply(lambda column: [float(f"{value:.7g}") for value in column])
    experiment = hiplot.Experiment.from_dataframe(short)
    hidden = ["uid", "from_uid", *(name for name in frame if name not in axes)]
    # The order of HiPlot's axes is from the right.
    experiment.display_data(hiplot.Displays.PARALLEL_PLOT).update({"hide": hidden, "order": axes[::-1]})
    experiment.to_html(path)


def plotly_page(frame: pd.DataFrame, axes: list[str], path: pathlib.Path) -> None:
    ordered = axes + [name for name in frame if name not in axes]
    dimensions = [{"label": name, "values": frame[name].to_numpy(), "visible": name in axes} for name in ordered]
    go.Figure(go.Parcoords(dimensions=dimensions)).write_html(path, include_plotlyjs=True)


def resident(browser) -> tuple[float, float]:
    """Resident memory of the largest renderer in MB, now and at its peak."""
    processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    sizes = []
    for process in processes:
        if process["type"] == "renderer":
            status = pathlib.Path(f"/proc/{process['id']}/status").read_text()
            sizes.append(tuple(int(re.search(rf"{key}:\s+(\d+)", status)[1]) / 1e3 for key in ("VmRSS", "VmHWM")))
    return max(sizes)


def settle(page) -> list[float]:
    """Waits until nothing was drawn for a while; ends of the first and the last frame that drew."""
    # decore's page lets no text be evaluated as a script: no `wait_for_function`.
    for _ in range(5 * LONGEST_S):
        if page.evaluate(SETTLED):
            return page.evaluate("watch.drawn")
        page.wait_for_timeout(200)
    raise TimeoutError(f"{page.url} draws for longer than {LONGEST_S} s")


def measure(playwright, kind: str, path: pathlib.Path, rows: int) -> dict[str, float]:
    """Opens a page in a new browser and brushes its first axis; times in ms, memory in MB."""
    executable = shutil.which("chromium") or shutil.which("chromium-browser")
    browser = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox", "--enable-unsafe-swiftshader"])
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.set_default_timeout(1000 * LONGEST_S)
    page.add_init_script(WATCH)
    page.goto(path.resolve().as_uri(), wait_until="commit")
    first_open, opened = settle(page)
    page.screenshot(path=path.with_name(f"{path.stem}_open.png"))
    x, top, _, height = page.evaluate(AXIS[kind])
    page.mouse.move(x, top + height / 3)
    page.mouse.down()
    page.evaluate("watch.begin()")
    for part in (0.4, 0.5, 0.6):
        page.mouse.move(x, top + part * height)
    settle(page)
    page.evaluate("watch.begin()")
    page.mouse.move(x, top + 2 / 3 * height)
    page.mouse.up()
    first, last = settle(page)
    moved, held = page.evaluate("[watch.moved, watch.held]")
    share = page.evaluate(SELECTED[kind]) / rows
    assert 0.28 < share < 0.38, f"{path}: the brush selects {share:.3f} of the rows"
    page.screenshot(path=path.with_name(f"{path.stem}_brush.png"))
    now, peak = resident(browser)
    browser.close()
    return {
        "first_open": first_open, "open": opened, "first": first - moved, "brush": last - moved, "held": held,
        "memory": now, "peak": peak,
    }


def table(results: dict[str, list[dict[str, float]]], paths: dict[str, pathlib.Path]) -> str:
    """Medians, and ratios of each to the first."""
    lines = ["| page | size | opened, first | opened | brush, first | brush | longest hold | memory, peak |", "|---|---|---|---|---|---|---|---|"]
    medians = {name: {key: statistics.median(turn[key] for turn in turns) for key in turns[0]} for name, turns in results.items()}
    base, base_size = next(iter(medians.values())), next(iter(paths.values())).stat().st_size
    for name, m in medians.items():
        size = paths[name].stat().st_size
        cell = lambda key, unit: f"{m[key]:.0f} {unit} ({m[key] / base[key]:.2g})"
        cells = [f"{size / 1e6:.1f} MB ({size / base_size:.2g})", *(cell(key, "ms") for key in ("first_open", "open", "first", "brush", "held"))]
        lines.append(f"| {name} | {' | '.join(cells)} | {m['memory']:.0f}, {m['peak']:.0f} MB |")
    for name, turns in results.items():
        lines.append(f"{name}: open " + ", ".join(f"{t['open']:.0f}" for t in turns) + "; brush " + ", ".join(f"{t['brush']:.0f}" for t in turns))
    return "\n".join(lines)


def extremes_missing(dataset: pathlib.Path, inside: Inside) -> list[str]:
    """Columns of the page whose least or largest values are not those of the whole table."""
    missing = []
    for name in inside.numbers:
        all_ = pyarrow.parquet.read_table(dataset / "runs", columns=[name])[name].drop_null().to_numpy()
        all_, shown = (np.sort(values[~np.isnan(values)].astype(np.float32)) for values in (all_, inside.values[name]))
        if not (np.array_equal(all_[:EXTREMES], shown[:EXTREMES]) and np.array_equal(all_[-EXTREMES:], shown[-EXTREMES:])):
            missing.append(name)
    return missing


def main(decore: str, folder: pathlib.Path, turns: int) -> None:
    folder.mkdir(exist_ok=True)
    dataset, page = sweep(decore, folder, LARGE)
    huge_dataset, huge_page = sweep(decore, folder, HUGE)
    inside, huge = Inside(page), Inside(huge_page)
    frame = same_rows(dataset, inside)
    paths = {"decore": page, "HiPlot": folder / "hiplot.html", "plotly": folder / "plotly.html"}
    with sync_playwright() as playwright:
        executable = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": 1280, "height": 900})
        tab.goto(page.resolve().as_uri())
        tab.wait_for_function("performance.getEntriesByName('decore-whole').length > 0")
        axes = tab.evaluate("state.shown.map((column) => column.name)")
        print(f"chromium {browser.version}, hiplot {hiplot.__version__}, plotly {plotly.__version__}")
        browser.close()
        hiplot_page(frame, axes, paths["HiPlot"])
        plotly_page(frame, axes, paths["plotly"])
        print(f"{len(frame)} rows, {len(frame.columns)} columns ({len(inside.meta['columns'])} in decore's page), {len(axes)} axes")
        results, huge_results = {name: [] for name in paths}, []
        for _ in range(turns):
            for name, path in paths.items():
                results[name].append(measure(playwright, name, path, LARGE))
            huge_results.append(measure(playwright, "decore", huge_page, huge.meta["rows_shown"]))
    print(table(results, paths))
    print(table({"decore": huge_results}, {"decore": huge_page}))
    print(f"{huge.meta['rows_there']} rows, {huge.meta['rows_shown']} in the page, {len(huge.meta['columns'])} columns: {huge.meta['notes'][0]}")
    print(f"columns of numbers without their {EXTREMES} least and largest values: {extremes_missing(huge_dataset, huge) or 'none'} of {len(huge.numbers)}")


if __name__ == "__main__":
    main(sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 5)
