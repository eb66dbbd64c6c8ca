// Linked views: parallel coordinates, scatter matrix and distributions, each with a brush that filters all.

/** Rows up to which each is drawn by itself; of more the density is drawn, on as many levels as [LEVELS]. */
const SINGLE_ROWS = 2500;

/** One canvas of `across` by `down` images of densities, filled again and again: the browser takes up one image, not many. */
class Densities {
  constructor([width, height], rgb, across = 1, down = 1) {
    Object.assign(this, { width, height, across, canvas: el('canvas', { width: width * across, height: height * down }) });
    this.context = this.canvas.getContext('2d');
    this.image = this.context.createImageData(this.canvas.width, this.canvas.height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.rgb = rgb;
  }
  /**
   * Fills an image with whole numbers as densities, lines from the top: denser is darker, on a logarithmic scale. `sums`: of the levels of
   * what was counted, whose means give the colours; null: one colour.
   */
  fill([density, sums], column = 0, row = 0) {
    const { width, height, across, pixels, rgb } = this, plain = (rgb[2] << 16) | (rgb[1] << 8) | rgb[0], scale = 215 / Math.log1p(largest(density) || 1);
    for (let y = 0, from = 0; y < height; y++) {
      for (let x = 0, to = ((row * height + y) * across + column) * width; x < width; x++, from++, to++) {
        const count = density[from], colour = sums && count ? LEVEL_COLORS[(sums[from] / count) | 0] : plain;
        pixels[to] = count ? colour | ((40 + (count < LOGS.length ? LOGS[count] : Math.log1p(count)) * scale) << 24) : 0;
      }
    }
  }
  /** Hands what was filled to the canvas. */
  show() { this.context.putImageData(this.image, 0, 0); return this.canvas; }
  /** Where an image is on the canvas. */
  place(column, row) { return [column * this.width, row * this.height, this.width, this.height]; }
}

/** Colours of the levels of the chosen output, as the pixels of an image have them; grey for a level that is missing. */
const LEVEL_COLORS = Uint32Array.from({ length: STRIDE }, (_, level) => {
  const [r, g, b] = level < LEVELS ? rampRgb(level / (LEVELS - 1)) : GREY_RGB;
  return (b << 16) | (g << 8) | r;
});

/** Number of rows on each pair of levels, [STRIDE] by [STRIDE]: of two columns the levels of the same rows; and the sums of a third's. */
function pairs(a, b, c) {
  const counts = new Uint32Array(STRIDE * STRIDE), sums = c && new Uint32Array(STRIDE * STRIDE);
  if (!c) for (let k = 0; k < a.length; k++) counts[a[k] * STRIDE + b[k]]++;
  else for (let k = 0; k < a.length; k++) { const at = a[k] * STRIDE + b[k]; counts[at]++; sums[at] += c[k]; }
  return [counts, sums];
}

function largest(values) {
  let most = 0;
  for (let i = 0; i < values.length; i++) if (values[i] > most) most = values[i];
  return most;
}

/** Pixels between two axes of parallel coordinates, before they are stretched. */
const GAP = 72;

/** Densities of the lines between two axes and the sums of a third's levels, from levels: lines of pixels from the top. */
function linesBetween(a, b, c) {
  const [counts, sums] = pairs(a, b, c), density = new Uint32Array(GAP * LEVELS), summed = c && new Uint32Array(GAP * LEVELS);
  for (let from = 0; from < LEVELS; from++) {
    for (let to = 0; to < LEVELS; to++) {
      const count = counts[from * STRIDE + to];
      if (!count) continue;
      const slope = (to - from) / (GAP - 1), sum = c && sums[from * STRIDE + to];
      if (!c) for (let x = 0, y = LEVELS - 0.5 - from; x < GAP; x++, y -= slope) density[(y | 0) * GAP + x] += count;
      else for (let x = 0, y = LEVELS - 0.5 - from; x < GAP; x++, y -= slope) { const at = (y | 0) * GAP + x; density[at] += count; summed[at] += sum; }
    }
  }
  return [density, summed];
}

/** Densities of points and the sums of a third's levels, from levels: lines of pixels from the top. */
function pointsOn(a, b, c) {
  const turned = (counts) => {
    if (!counts) return null;
    const density = new Uint32Array(LEVELS * LEVELS);
    for (let x = 0; x < LEVELS; x++) for (let y = 0; y < LEVELS; y++) density[(LEVELS - 1 - y) * LEVELS + x] = counts[x * STRIDE + y];
    return density;
  };
  return pairs(a, b, c).map(turned);
}

/** Height in pixels of a view of columns together that has less than two of them. */
const LONE = 40;

/** Says so, and returns whether. */
function isLone(painter, columns) {
  if (columns.length < 2) painter.text('Choose two columns or more under Columns.', 4, LONE / 2, { color: SOFT });
  return columns.length < 2;
}

/** About so many marks of a column's axis with their texts. */
function marksOf(column, count) { return column.log ? logTicks(column.low, column.high, count) : zip(ticks(column.low, column.high, count)); }

/** Parallel coordinates of the shown columns. */
class Parallel {
  constructor(state) {
    this.state = state;
    this.figure = new Figure({
      title: 'Parallel coordinates', least: () => 110 + 58 * state.shown.length, height: () => (state.shown.length > 1 ? 380 : LONE),
      paint: (...on) => this.paint(...on), still: (...on) => this.axes(...on), over: (...on) => this.paintOver(...on),
      hover: (x, y) => this.hover(x, y), drag: (...drag) => this.drag(...drag),
      left: () => { this.row = -1; this.figure.redrawOver(); },
    });
    this.row = -1;
    dressed.add(() => { this.ground = null; });
  }
  /** Other columns are shown. */
  renew() {
    this.sheets = new Kept((rgb) => new Densities([GAP, LEVELS], rgb, Math.max(1, this.state.shown.length - 1)));
    this.ground = null;
    this.figure.renew();
  }
  /** The lines of all rows: what lies under those of the selected ones. */
  prepare() { return (this.ground ||= this.between(levels, GREY_RGB)); }
  /** The lines of rows with these levels, on one canvas; those of selected rows by the chosen output. */
  between(found, rgb) {
    const { shown, output } = this.state, sheet = this.sheets.of(rgb), by = rgb === BLUE_RGB && output ? found.of(output) : null;
    for (let k = 0; k + 1 < shown.length; k++) sheet.fill(linesBetween(found.of(shown[k]), found.of(shown[k + 1]), by), k);
    return sheet.show();
  }
  x(k, width) { const n = this.state.shown.length; return n > 1 ? 55 + k * (width - 110) / (n - 1) : width / 2; }
  y(column, v) { return this.bottom - scaled(column)(v) * (this.bottom - this.top); }
  value(column, y) { return valueAt(column, (this.bottom - y) / (this.bottom - this.top)); }
  paint(painter, width, height) {
    const { shown, table, selection } = this.state;
    [this.top, this.bottom] = [62, height - 14];
    if (isLone(painter, shown)) return;
    const narrowed = selection.narrowed;
    if (table.rows <= SINGLE_ROWS) {
      if (narrowed) this.lines(painter, width, Array(table.rows).keys(), GREY, 0.35);
      this.lines(painter, width, selection.picked, null, Math.max(0.3, Math.min(0.8, 60 / selection.picked.length)));
    } else {
      const place = (image) => painter.image(image, 55, this.top, width - 110, this.bottom - this.top);
      if (narrowed) place(this.prepare());
      place(this.between(selection.levels, BLUE_RGB));
    }
    shown.forEach((column, k) => this.limit(painter, column, this.x(k, width)));
  }
  axes(painter, width) {
    const { shown } = this.state, between = (width - 110) / (shown.length - 1);
    if (shown.length < 2) return;
    // At both ends the edge of the figure is nearer than the next axis.
    const isEnd = (k) => k === 0 || k === shown.length - 1;
    shown.forEach((column, k) => this.axis(painter, column, this.x(k, width), { room: isEnd(k) ? Math.min(110, between) : between, left: k > 0 && isEnd(k) }));
  }
  lines(painter, width, rows, color, alpha) {
    for (const i of rows) for (const run of this.runs(width, i)) painter.line(run, { color: color ?? this.state.color(i), alpha });
  }
  /** The pieces of a row's line: it breaks where a value is missing. */
  runs(width, row) {
    const runs = [[]];
    this.state.shown.forEach((column, k) => {
      const v = column.values[row];
      if (v !== v) runs.push([]);
      else runs[runs.length - 1].push(this.x(k, width), this.y(column, v));
    });
    return runs.filter((run) => run.length > 2);
  }
  /** An axis; its texts have `room` pixels, and those of its marks stand on its right, or `left` of it. */
  axis(painter, column, x, { room, left }) {
    painter.line([x, this.top, x, this.bottom], { color: INK });
    const fits = Math.max(6, Math.floor((room - 8) / 7.1));
    const lines = wrapped(titled(column.label, column.unit), fits, 4);
    lines.forEach((line, i) => painter.text(line, x, this.top - 10 - 13 * (lines.length - 1 - i), { align: 'center', size: 11, weight: 600 }));
    const marks = column.names ? column.names.map((name, i) => [i, wrapped(name, 14, 1)[0]]) : marksOf(column, 6);
    for (const [value, text] of column.count ? marks : []) {
      painter.line([x - 3, this.y(column, value), x + 3, this.y(column, value)], { color: INK });
      painter.text(text, left ? x - 5 : x + 5, this.y(column, value), { size: 10, halo: true, align: left ? 'right' : 'left' });
    }
  }
  limit(painter, column, x) {
    const limit = this.state.selection.limits.get(column);
    if (!limit) return;
    const spans = limit instanceof Set ? [...limit].map((code) => [code - 0.5, code + 0.5]) : [[limit.low, limit.high]];
    for (const [low, high] of spans) {
      const clamp = (v) => Math.max(this.top, Math.min(this.bottom, this.y(column, v)));
      painter.rect(x - 8, clamp(high), 16, Math.max(1, clamp(low) - clamp(high)), { fill: ORANGE, alpha: 0.3 });
      painter.rect(x - 8, clamp(high), 16, Math.max(1, clamp(low) - clamp(high)), { stroke: ORANGE });
    }
  }
  paintOver(painter, width) {
    if (this.row >= 0) for (const run of this.runs(width, this.row)) painter.line(run, { color: ORANGE, width: 2.5 });
  }
  nearest(x, width) {
    const n = this.state.shown.length;
    return n < 2 ? 0 : Math.max(0, Math.min(n - 1, Math.round((x - 55) / (width - 110) * (n - 1))));
  }
  /** The selected row whose line passes nearest. */
  hover(x, y) {
    const { shown, selection } = this.state, width = this.figure.width;
    if (shown.length < 2) return '';
    const n = shown.length, along = n > 1 ? Math.max(0, Math.min(n - 1.001, (x - 55) / (width - 110) * (n - 1))) : 0;
    const k = Math.floor(along), t = along - k, a = shown[k], b = shown[Math.min(n - 1, k + 1)];
    const { picked } = selection, [pa, pb] = [selection.places.of(a), selection.places.of(b)], aim = (this.bottom - y) / (this.bottom - this.top);
    let best = 9 / (this.bottom - this.top), row = -1;
    for (let p = 0; p < picked.length; p++) {
      const distance = Math.abs((1 - t) * pa[p] + t * pb[p] - aim);
      if (distance < best) { best = distance; row = picked[p]; }
    }
    if (row !== this.row) { this.row = row; this.figure.redrawOver(); }
    return row < 0 ? '' : this.state.describe(row);
  }
  drag(x0, y0, _x1, y1, ended) {
    const column = this.state.shown.length > 1 && this.state.shown[this.nearest(x0, this.figure.width)];
    if (!column || (!ended && Math.abs(y1 - y0) < 4)) return;
    const span = Math.abs(y1 - y0) < 4 ? null : Selection.span(column, this.value(column, y0), this.value(column, y1));
    this.state.selection.set([[column, span]]);
  }
}

/** Scatter matrix of some columns: points or densities below the diagonal, distributions on it, correlations above. */
class Matrix {
  constructor(state) {
    this.state = state;
    this.columns = [];
    this.figure = new Figure({
      title: 'Scatter matrix', least: () => 80 + 80 * this.columns.length, height: (width) => (this.columns.length > 1 ? Math.min(width, 1000) * 0.8 + 40 : LONE),
      paint: (...on) => this.paint(...on), still: (...on) => this.frames(...on), hover: (x, y) => this.hover(x, y), drag: (...drag) => this.drag(...drag),
    });
    dressed.add(() => { this.ground = null; });
  }
  /** Shows other columns. */
  renew(columns) {
    const parts = Math.max(1, columns.length - 1);
    this.columns = columns;
    this.sheets = new Kept((rgb) => new Densities([LEVELS, LEVELS], rgb, parts, parts));
    this.ground = null;
    this.figure.renew();
  }
  /** The points of all rows: what lies under those of the selected ones. */
  prepare() { return (this.ground ||= this.points(levels, GREY_RGB)); }
  /** The points of rows with these levels, on one canvas: that of columns j and i > j in column j and line i - 1. */
  points(found, rgb) {
    const { columns } = this, { output } = this.state, sheet = this.sheets.of(rgb), by = rgb === BLUE_RGB && output ? found.of(output) : null;
    for (let i = 1; i < columns.length; i++) for (let j = 0; j < i; j++) sheet.fill(pointsOn(found.of(columns[j]), found.of(columns[i]), by), j, i - 1);
    return sheet.show();
  }
  cell(i, j) {
    const n = this.columns.length, w = (this.figure.width - 80) / n, h = (this.figure.tall - 60) / n;
    return { left: 72 + j * w, top: 8 + i * h, width: w - 8, height: h - 8 };
  }
  paint(painter) {
    const n = this.columns.length, { table, selection } = this.state, images = [];
    if (isLone(painter, this.columns)) return;
    if (table.rows > SINGLE_ROWS) {
      if (selection.narrowed) images.push(this.prepare());
      images.push(this.points(selection.levels, BLUE_RGB));
    }
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        const box = this.cell(i, j);
        if (i === j) this.diagonal(painter, this.columns[i], box);
        else if (j < i && images.length) images.forEach((image) => painter.image(image, box.left, box.top, box.width, box.height, this.sheets.of(BLUE_RGB).place(j, i - 1)));
        else if (j < i) this.panel(painter, [this.columns[j], this.columns[i]], box);
        else this.correlation(painter, this.columns[j], this.columns[i], box);
      }
    }
  }
  /** What no brush changes. */
  frames(painter) {
    if (this.columns.length < 2) return;
    for (let i = 0; i < this.columns.length; i++) {
      for (let j = 0; j <= i; j++) {
        const { left, top, width, height } = this.cell(i, j);
        painter.rect(left, top, width, height, { stroke: RULE });
      }
    }
    this.columns.forEach((column, k) => this.labels(painter, column, k));
  }
  labels(painter, column, k) {
    const left = this.cell(k, 0), below = this.cell(this.columns.length - 1, k);
    const lines = wrapped(titled(column.label, column.unit), Math.max(8, Math.floor(left.height / 5.9)), 3);
    lines.forEach((line, i) => painter.text(line, 12 + 13 * i, left.top + left.height / 2, { align: 'center', turned: true, weight: 600 }));
    const foot = wrapped(titled(column.label, column.unit), Math.max(8, Math.floor(below.width / 5.9)), 2);
    const bottom = below.top + below.height;
    foot.forEach((line, i) => painter.text(line, below.left + below.width / 2, bottom + 27 + 13 * i, { align: 'center', weight: 600 }));
    const ends = column.names ? named(column.names, below.width / column.names.length).map(([code, name]) => [code, wrapped(name, 8, 1)[0]]) : marksOf(column, 3);
    for (const [value, text] of column.count ? ends : []) {
      const part = scaled(column)(value);
      painter.text(text, below.left + part * below.width, bottom + 10, { align: 'center', size: 9, color: SOFT });
      if (k) painter.text(text, left.left - 4, left.top + (1 - part) * left.height, { align: 'right', size: 9, color: SOFT });
    }
  }
  diagonal(painter, column, box) {
    const all = distributions.of(column), some = histogram(column, this.state.selection);
    const most = Math.max(1, ...all), width = box.width / all.length;
    const bar = (count, k, fill) => painter.rect(box.left + k * width, box.top + box.height * (1 - count / most * 0.92), Math.max(0.6, width - 0.6), box.height * count / most * 0.92, { fill });
    all.forEach((count, k) => { if (count) bar(count, k, RULE); });
    some.forEach((count, k) => { if (count) bar(count, k, BLUE); });
  }
  panel(painter, [a, b], box) {
    const { table, selection } = this.state, at = (rows) => this.dots(a, b, box, rows);
    if (selection.narrowed) painter.dots(at(null), table.rows < 100 ? 2.2 : 1.6, { color: GREY, alpha: 0.5 });
    const alpha = Math.max(0.25, Math.min(0.85, 200 / selection.picked.length));
    for (const [color, rows] of this.state.byColor()) painter.dots(at(rows), table.rows < 100 ? 2.6 : 1.9, { color, alpha });
  }
  dots(a, b, box, rows) {
    const at = [], count = rows ? rows.length : a.values.length;
    const [across, up] = [scaled(a), scaled(b)];
    for (let k = 0; k < count; k++) {
      const i = rows ? rows[k] : k, [x, y] = [across(a.values[i]), up(b.values[i])];
      if (x === x && y === y) at.push(box.left + x * box.width, box.top + (1 - y) * box.height);
    }
    return at;
  }
  correlation(painter, a, b, box) {
    if (a.names || b.names) return;
    let n = 0, sa = 0, sb = 0, aa = 0, bb = 0, ab = 0;
    const { places } = this.state.selection, [pa, pb] = [places.of(a), places.of(b)];
    for (let k = 0; k < pa.length; k++) {
      const x = pa[k] - 0.5, y = pb[k] - 0.5, sum = x + y;
      if (sum !== sum) continue;
      n++; sa += x; sb += y; aa += x * x; bb += y * y; ab += x * y;
    }
    const r = (n * ab - sa * sb) / Math.sqrt((n * aa - sa * sa) * (n * bb - sb * sb));
    if (!Number.isFinite(r)) return;
    painter.text(`r = ${(Math.abs(r) < 0.005 ? 0 : r).toFixed(2)}`, box.left + box.width / 2, box.top + box.height / 2, { align: 'center', size: 11 + 7 * Math.abs(r), color: Math.abs(r) > 0.3 ? INK : SOFT });
  }
  /** The columns and place of a panel below the diagonal. */
  find(x, y) {
    const n = this.columns.length;
    for (let i = 1; i < n; i++) {
      for (let j = 0; j < i; j++) {
        const box = this.cell(i, j);
        if (x >= box.left && x <= box.left + box.width && y >= box.top && y <= box.top + box.height) return { a: this.columns[j], b: this.columns[i], box };
      }
    }
    return null;
  }
  hover(x, y) {
    const found = this.find(x, y);
    if (!found) return '';
    const { a, b, box } = found, { picked, places } = this.state.selection, [pa, pb] = [places.of(a), places.of(b)];
    const [px, py] = [(x - box.left) / box.width, 1 - (y - box.top) / box.height];
    let best = 64, row = -1;
    for (let k = 0; k < picked.length; k++) {
      const dx = (pa[k] - px) * box.width, dy = (pb[k] - py) * box.height, distance = dx * dx + dy * dy;
      if (distance < best) { best = distance; row = picked[k]; }
    }
    return row < 0 ? '' : this.state.describe(row, [a, b]);
  }
  drag(x0, y0, x1, y1, ended) {
    const found = this.find(x0, y0);
    if (!found) return;
    const { a, b, box } = found, moved = Math.abs(x1 - x0) > 4 && Math.abs(y1 - y0) > 4;
    if (!moved && !ended) return;
    const vx = (x) => valueAt(a, Math.max(0, Math.min(1, (x - box.left) / box.width)));
    const vy = (y) => valueAt(b, 1 - Math.max(0, Math.min(1, (y - box.top) / box.height)));
    const { selection } = this.state, area = selection.area(a, b);
    if (moved || selection.limits.has(area)) selection.set([[area, moved ? [Selection.span(a, vx(x0), vx(x1)), Selection.span(b, vy(y0), vy(y1))] : null]]);
  }
}

/** Distribution of a column: all rows in grey, the selected ones in blue. Dragging sets limits. */
function distribution(state, column) {
  const frame = (width, height) => ({ left: 44, top: 6, width: width - 54, height: height - 44 });
  const figure = new Figure({
    title: titled(column.label, column.unit), height: 165,
    paint(painter, width, height) {
      const box = frame(width, height), all = distributions.of(column), some = histogram(column, state.selection);
      const most = Math.max(1, ...all), n = all.length;
      const { py } = axes(painter, box, { low: column.domain[0], high: column.domain[1], names: column.names, log: column.log }, { low: 0, high: most, whole: true });
      const bar = (count, k, fill) => { if (count) painter.rect(box.left + box.width * k / n, py(count), Math.max(0.7, box.width / n - 1), py(0) - py(count), { fill }); };
      all.forEach((count, k) => bar(count, k, GREY));
      some.forEach((count, k) => bar(count, k, BLUE));
      const m = moments(column, state.selection.picked);
      const words = column.names ? `${m.count} rows` : m.count ? `least ${short(m.low)}, mean ${short(m.mean)}, largest ${short(m.high)}` : 'no values';
      painter.text(words, 4, height - 8, { color: SOFT, size: Math.min(10.5, width / words.length * 1.75) });
    },
    hover(x) {
      const box = frame(this.width, this.tall), all = distributions.of(column), some = histogram(column, state.selection);
      const k = Math.floor((x - box.left) / box.width * all.length);
      if (!(k in all)) return '';
      const [from, to] = [k, k + 1].map((end) => valueAt(column, end / all.length));
      const what = column.names ? column.names[k] : `${short(from)} to ${withUnit(short(to), column.unit)}`;
      return `${what}\n${some[k]} of ${all[k]} rows\n${column.text}`;
    },
    drag(x0, _y0, x1, _y1, ended) {
      const box = frame(this.width, this.tall);
      const value = (x) => valueAt(column, Math.max(0, Math.min(1, (x - box.left) / box.width)));
      const click = Math.abs(x1 - x0) < 4;
      if (click && !ended) return;
      const one = click && column.names ? [value(x0) - 1e-6, value(x0) + 1e-6] : [value(x0), value(x1)];
      state.selection.set([[column, click && (!column.names || state.selection.limits.has(column)) ? null : Selection.span(column, ...one)]]);
    },
  });
  return figure;
}
