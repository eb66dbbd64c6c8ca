// Linked views: parallel coordinates, scatter matrix and distributions, each with a brush that filters all.

/** Rows up to which each is drawn by itself; of more the density is drawn, on as many levels as [LEVELS]. */
const SINGLE_ROWS = 2500;

/** A canvas of given pixels filled from densities: colour of `rgb`, denser is darker, on a logarithmic scale. */
function densityImage(density, width, height, rgb, largest) {
  const canvas = el('canvas', { width, height }), context = canvas.getContext('2d');
  const image = context.createImageData(width, height), pixels = new Uint32Array(image.data.buffer);
  const colour = (rgb[2] << 16) | (rgb[1] << 8) | rgb[0], scale = 215 / Math.log1p(largest || 1);
  for (let i = 0; i < density.length; i++) {
    if (density[i]) pixels[i] = colour | ((40 + Math.log1p(density[i]) * scale) << 24);
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

const GREY_RGB = [190, 198, 208], BLUE_RGB = [31, 95, 168];

/** Number of rows on each pair of levels of two columns. */
function pairs(a, b, rows) {
  const counts = new Uint32Array(LEVELS * LEVELS), count = rows ? rows.length : a.level.length;
  const [la, lb] = [a.level, b.level];
  for (let k = 0; k < count; k++) {
    const i = rows ? rows[k] : k;
    if (la[i] !== NONE && lb[i] !== NONE) counts[la[i] * LEVELS + lb[i]]++;
  }
  return counts;
}

function largest(values) {
  let most = 0;
  for (let i = 0; i < values.length; i++) if (values[i] > most) most = values[i];
  return most;
}

/** Densities of the lines between two axes, as an image whose rows are levels. */
function linesBetween(a, b, rows, rgb) {
  const width = 72, counts = pairs(a, b, rows), density = new Float32Array(width * LEVELS);
  for (let from = 0; from < LEVELS; from++) {
    for (let to = 0; to < LEVELS; to++) {
      const count = counts[from * LEVELS + to];
      if (!count) continue;
      const slope = (to - from) / (width - 1);
      for (let x = 0, y = LEVELS - 0.5 - from; x < width; x++, y -= slope) density[(y | 0) * width + x] += count;
    }
  }
  return densityImage(density, width, LEVELS, rgb, largest(density));
}

/** Parallel coordinates of the shown columns. */
class Parallel {
  constructor(state) {
    this.state = state;
    this.figure = new Figure({
      title: 'Parallel coordinates', height: 380,
      paint: (...on) => this.paint(...on), over: (...on) => this.paintOver(...on),
      hover: (x, y) => this.hover(x, y), drag: (...drag) => this.drag(...drag),
      left: () => { this.row = -1; this.figure.redrawOver(); },
    });
    this.row = -1;
  }
  x(k, width) { const n = this.state.shown.length; return n > 1 ? 55 + k * (width - 110) / (n - 1) : width / 2; }
  y(column, v) { const [low, high] = column.domain; return this.bottom - (v - low) / (high - low) * (this.bottom - this.top); }
  value(column, y) { const [low, high] = column.domain; return low + (this.bottom - y) / (this.bottom - this.top) * (high - low); }
  paint(painter, width, height) {
    const { shown, table, selection } = this.state;
    [this.top, this.bottom] = [62, height - 14];
    const narrowed = selection.narrowed;
    if (table.rows <= SINGLE_ROWS) {
      if (narrowed) this.lines(painter, width, Array.from({ length: table.rows }, (_, i) => i), GREY, 0.35);
      this.lines(painter, width, selection.picked, BLUE, Math.max(0.15, Math.min(0.8, 60 / selection.picked.length)));
    } else {
      const key = shown.map((column) => column.index).join();
      if (this.key !== key) [this.key, this.ground] = [key, shown.slice(1).map((b, k) => linesBetween(shown[k], b, null, GREY_RGB))];
      const place = (image, k) => painter.image(image, this.x(k, width), this.top, this.x(k + 1, width) - this.x(k, width), this.bottom - this.top);
      if (narrowed) this.ground.forEach(place);
      shown.slice(1).map((b, k) => linesBetween(shown[k], b, narrowed ? selection.picked : null, BLUE_RGB)).forEach(place);
    }
    shown.forEach((column, k) => this.axis(painter, column, this.x(k, width), (width - 110) / Math.max(1, shown.length - 1)));
  }
  lines(painter, width, rows, color, alpha) {
    for (const i of rows) for (const run of this.runs(width, i)) painter.line(run, { color, alpha });
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
  axis(painter, column, x, room) {
    painter.line([x, this.top, x, this.bottom], { color: INK });
    const fits = Math.max(6, Math.floor((room - 8) / 7.1));
    const lines = wrapped(titled(column.label, column.unit), fits, 4);
    lines.forEach((line, i) => painter.text(line, x, this.top - 10 - 13 * (lines.length - 1 - i), { align: 'center', size: 11, weight: 600 }));
    const marks = column.names ? column.names.map((name, i) => [i, wrapped(name, 14, 1)[0]]) : zip(ticks(column.low, column.high, 6));
    for (const [value, text] of column.count ? marks : []) {
      painter.line([x - 3, this.y(column, value), x + 3, this.y(column, value)], { color: INK });
      painter.text(text, x + 5, this.y(column, value), { size: 10, halo: true });
    }
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
    if (!shown.length) return '';
    const n = shown.length, along = n > 1 ? Math.max(0, Math.min(n - 1.001, (x - 55) / (width - 110) * (n - 1))) : 0;
    const k = Math.floor(along), t = along - k, a = shown[k], b = shown[Math.min(n - 1, k + 1)];
    let best = 9, row = -1;
    for (const i of selection.picked) {
      const at = (1 - t) * this.y(a, a.values[i]) + t * this.y(b, b.values[i]), distance = Math.abs(at - y);
      if (distance < best) [best, row] = [distance, i];
    }
    if (row !== this.row) { this.row = row; this.figure.redrawOver(); }
    return row < 0 ? '' : this.state.describe(row);
  }
  drag(x0, y0, _x1, y1, ended) {
    const column = this.state.shown[this.nearest(x0, this.figure.width)];
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
      title: 'Scatter matrix', height: (width) => Math.min(width, 1000) * 0.8 + 40,
      paint: (...on) => this.paint(...on), hover: (x, y) => this.hover(x, y), drag: (...drag) => this.drag(...drag),
    });
  }
  cell(i, j) {
    const n = this.columns.length, w = (this.figure.width - 80) / n, h = (this.figure.tall - 60) / n;
    return { left: 72 + j * w, top: 8 + i * h, width: w - 8, height: h - 8 };
  }
  paint(painter) {
    const n = this.columns.length, narrowed = this.state.selection.narrowed;
    const key = this.columns.map((column) => column.index).join();
    if (this.key !== key) [this.key, this.ground] = [key, new Map()];
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        const box = this.cell(i, j);
        if (i === j) this.diagonal(painter, this.columns[i], box);
        else if (j < i) this.panel(painter, [this.columns[j], this.columns[i]], box, narrowed);
        else this.correlation(painter, this.columns[j], this.columns[i], box);
        if (j <= i) painter.rect(box.left, box.top, box.width, box.height, { stroke: RULE });
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
    const ends = column.names ? column.names.slice(0, 6).map((name, code) => [code, wrapped(name, 8, 1)[0]]) : zip(ticks(column.low, column.high, 3));
    for (const [value, text] of column.count ? ends : []) {
      const part = (value - column.domain[0]) / (column.domain[1] - column.domain[0]);
      painter.text(text, below.left + part * below.width, bottom + 10, { align: 'center', size: 9, color: SOFT });
      if (k) painter.text(text, left.left - 4, left.top + (1 - part) * left.height, { align: 'right', size: 9, color: SOFT });
    }
  }
  diagonal(painter, column, box) {
    const all = histogram(column, null, 32), some = histogram(column, this.state.selection.picked, 32);
    const most = Math.max(1, ...all), width = box.width / all.length;
    const bar = (count, k, fill) => painter.rect(box.left + k * width, box.top + box.height * (1 - count / most * 0.92), Math.max(0.6, width - 0.6), box.height * count / most * 0.92, { fill });
    all.forEach((count, k) => { if (count) bar(count, k, RULE); });
    some.forEach((count, k) => { if (count) bar(count, k, BLUE); });
  }
  panel(painter, [a, b], box, narrowed) {
    const { table, selection } = this.state;
    if (table.rows <= SINGLE_ROWS) {
      const at = (rows) => this.points(a, b, box, rows);
      if (narrowed) painter.dots(at(null), table.rows < 100 ? 2.2 : 1.6, { color: GREY, alpha: 0.5 });
      painter.dots(at(selection.picked), table.rows < 100 ? 2.6 : 1.9, { color: BLUE, alpha: Math.max(0.25, Math.min(0.85, 200 / selection.picked.length)) });
      return;
    }
    const key = `${a.index},${b.index}`;
    if (!this.ground.has(key)) this.ground.set(key, this.density(a, b, null, GREY_RGB));
    if (narrowed) painter.image(this.ground.get(key), box.left, box.top, box.width, box.height);
    painter.image(this.density(a, b, selection.picked, BLUE_RGB), box.left, box.top, box.width, box.height);
  }
  points(a, b, box, rows) {
    const at = [], count = rows ? rows.length : a.values.length;
    const part = ({ domain, values }, i) => (values[i] - domain[0]) / (domain[1] - domain[0]);
    for (let k = 0; k < count; k++) {
      const i = rows ? rows[k] : k, [x, y] = [part(a, i), part(b, i)];
      if (x === x && y === y) at.push(box.left + x * box.width, box.top + (1 - y) * box.height);
    }
    return at;
  }
  density(a, b, rows, rgb) {
    const counts = pairs(a, b, rows), image = new Uint32Array(counts.length);
    for (let x = 0; x < LEVELS; x++) for (let y = 0; y < LEVELS; y++) image[(LEVELS - 1 - y) * LEVELS + x] = counts[x * LEVELS + y];
    return densityImage(image, LEVELS, LEVELS, rgb, largest(image));
  }
  correlation(painter, a, b, box) {
    if (a.names || b.names) return;
    let n = 0, sa = 0, sb = 0, aa = 0, bb = 0, ab = 0;
    const scale = (column, i) => (column.values[i] - column.domain[0]) / (column.domain[1] - column.domain[0]);
    for (const i of this.state.selection.picked) {
      const x = scale(a, i), y = scale(b, i), sum = x + y;
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
    const { a, b, box } = found, parts = ([low, high]) => high - low;
    const vx = a.domain[0] + (x - box.left) / box.width * parts(a.domain), vy = b.domain[0] + (1 - (y - box.top) / box.height) * parts(b.domain);
    let best = 64, row = -1;
    for (const i of this.state.selection.picked) {
      const dx = (a.values[i] - vx) / parts(a.domain) * box.width, dy = (b.values[i] - vy) / parts(b.domain) * box.height;
      if (dx * dx + dy * dy < best) [best, row] = [dx * dx + dy * dy, i];
    }
    return row < 0 ? '' : this.state.describe(row, [a, b]);
  }
  drag(x0, y0, x1, y1, ended) {
    const found = this.find(x0, y0);
    if (!found) return;
    const { a, b, box } = found, moved = Math.abs(x1 - x0) > 4 && Math.abs(y1 - y0) > 4;
    if (!moved && !ended) return;
    const vx = (x) => a.domain[0] + (Math.max(0, Math.min(1, (x - box.left) / box.width))) * (a.domain[1] - a.domain[0]);
    const vy = (y) => b.domain[0] + (1 - Math.max(0, Math.min(1, (y - box.top) / box.height))) * (b.domain[1] - b.domain[0]);
    const limits = moved ? [Selection.span(a, vx(x0), vx(x1)), Selection.span(b, vy(y0), vy(y1))] : [null, null];
    this.state.selection.set([[a, limits[0]], [b, limits[1]]]);
  }
}

/** Distribution of a column: all rows in grey, the selected ones in blue. Dragging sets limits. */
function distribution(state, column) {
  const frame = (width, height) => ({ left: 44, top: 6, width: width - 54, height: height - 44 });
  const figure = new Figure({
    title: titled(column.label, column.unit), height: 165,
    paint(painter, width, height) {
      const box = frame(width, height), all = histogram(column, null, 32), some = histogram(column, state.selection.picked, 32);
      const most = Math.max(1, ...all), n = all.length;
      const { py } = axes(painter, box, { low: column.domain[0], high: column.domain[1], names: column.names }, { low: 0, high: most, whole: true });
      const bar = (count, k, fill) => { if (count) painter.rect(box.left + box.width * k / n, py(count), Math.max(0.7, box.width / n - 1), py(0) - py(count), { fill }); };
      all.forEach((count, k) => bar(count, k, GREY));
      some.forEach((count, k) => bar(count, k, BLUE));
      const m = moments(column, state.selection.picked);
      const words = column.names ? `${m.count} rows` : m.count ? `least ${short(m.low)}, mean ${short(m.mean)}, largest ${short(m.high)}` : 'no values';
      painter.text(words, 4, height - 8, { color: SOFT, size: Math.min(10.5, width / words.length * 1.75) });
    },
    hover(x) {
      const box = frame(this.width, this.tall), all = histogram(column, null, 32), some = histogram(column, state.selection.picked, 32);
      const k = Math.floor((x - box.left) / box.width * all.length);
      if (!(k in all)) return '';
      const step = (column.domain[1] - column.domain[0]) / all.length, from = column.domain[0] + k * step;
      const what = column.names ? column.names[k] : `${short(from)} to ${withUnit(short(from + step), column.unit)}`;
      return `${what}\n${some[k]} of ${all[k]} rows\n${column.text}`;
    },
    drag(x0, _y0, x1, _y1, ended) {
      const box = frame(this.width, this.tall), [low, high] = column.domain;
      const value = (x) => low + Math.max(0, Math.min(1, (x - box.left) / box.width)) * (high - low);
      const click = Math.abs(x1 - x0) < 4;
      if (click && !ended) return;
      const one = click && column.names ? [value(x0) - 1e-6, value(x0) + 1e-6] : [value(x0), value(x1)];
      state.selection.set([[column, click && (!column.names || state.selection.limits.has(column)) ? null : Selection.span(column, ...one)]]);
    },
  });
  return figure;
}
