// The model over two factors: colours by an output, limit lines with what is not known of them, and the rows.

/** The share of rows that have all values is limited too, by the confidence. */
const SUCCEED = 'rows that succeed';
/** Pixels of the picture under the lines, along each side. */
const PICTURE = 160;
/** Pixels between the lines of hatching where a limit is broken. */
const HATCH = 7;
/** How long after the last change the picture at rest is drawn, ms. */
const REST_MS = 160;
/** How long the picture at rest keeps the page from answering, ms. */
const SLICE_MS = 12;

/** Fields of a picture: { colour, limits: [{ value, reached, good, bad }] }. */
function* pictureOf(explorer, { place, axes, output, model }, drag, kept) {
  const fields = new Fields(explorer, place, axes, drag);
  const other = model === explorer.model ? fields : Object.assign(new Fields(Object.assign(Object.create(explorer), { model }), translated(explorer, model, place), axes, drag), { lines: fields.lines });
  const limits = [];
  for (const value of explorer.values.filter(({ limit }) => limit !== null)) {
    const error = drag ? kept.get(value) : yield* fields.error(explorer.output(value));
    if (!drag) kept.set(value, error);
    const [reached, good, bad] = yield* fields.reached(value, error);
    limits.push({ value, reached, good: good ?? reached, bad: bad ?? reached });
  }
  const success = drag ? kept.get('success') : yield* fields.success();
  if (!drag) kept.set('success', success);
  if (success) {
    const { lines } = fields, field = Float64Array.from({ length: lines * lines }, (_, cell) => between(success, ERROR_LINES, Math.floor(cell / lines) / (lines - 1), cell % lines / (lines - 1)));
    limits.push({ value: { text: SUCCEED, unit: '', smaller: false, limit: explorer.confidence }, reached: field, good: field, bad: field });
  }
  return { lines: fields.lines, colour: yield* other.expected(output), limits };
}

/** Takes steps for so many ms; returns the result where there is one. */
function stepped(steps, forMs = Infinity) {
  const end = performance.now() + forMs;
  for (;;) {
    const { done, value } = steps.next();
    if (done) return value;
    if (performance.now() > end) return null;
  }
}

/** Whether a value breaks a limit. */
const breaks = ({ smaller, limit }, value) => (smaller ? value > limit : value < limit);

/** Draws colours, hatching where a limit is broken and the band in which the model does not know. */
function paintPicture(picture, range, image) {
  const { lines, colour, limits } = picture, { data } = image, paper = rgbOf(PAPER);
  const shades = Array.from({ length: 256 }, (_, k) => rampRgb(k / 255));
  for (let row = 0, at = 0; row < PICTURE; row++) {
    const y = 1 - row / (PICTURE - 1);
    for (let column = 0; column < PICTURE; column++, at += 4) {
      const x = column / (PICTURE - 1), part = (between(colour, lines, x, y) - range[0]) / (range[1] - range[0] || 1);
      let [r, g, b] = shades[Math.max(0, Math.min(255, Math.round(255 * part)))];
      let mixed = 0;
      for (const { value, good, bad } of limits) {
        if (breaks(value, between(good, lines, x, y))) { mixed = (row + column) % HATCH < 2 ? 0.95 : 0.65; break; }
        if (breaks(value, between(bad, lines, x, y))) mixed = 0.4;
      }
      r += mixed * (paper[0] - r); g += mixed * (paper[1] - g); b += mixed * (paper[2] - b);
      data[at] = r; data[at + 1] = g; data[at + 2] = b; data[at + 3] = 255;
    }
  }
}

/** The rows of the dataset, coloured alike: the stronger, the nearer their other factors are. `values`: the column of the output, if any. */
function paintRows(painter, box, { state, explorer, place, axes: [a, b], range, values }) {
  const columns = explorer.factors.map((factor) => state.table.columns.find((one) => one.group === 'factor' && one.subject === factor.name));
  const averaged = explorer.free([a, b]).map(([factor]) => factor), value = ({ names, values: of }, i) => (names ? names[of[i]] : of[i]);
  if (columns.some((column) => !column)) return;
  for (const i of state.selection.picked) {
    const at = explorer.factors.map((factor, k) => factor.scaled(value(columns[k], i))), [x, y] = [box.left + at[a] * box.width, box.top + (1 - at[b]) * box.height];
    if (!(at[a] >= 0 && at[b] >= 0)) continue;
    const far = at.reduce((most, one, k) => (k === a || k === b || averaged.includes(k) ? most : Math.max(most, Math.abs(one - place[k]))), 0), alpha = Math.max(0.15, 1 - 2.5 * far);
    const part = values ? (values.values[i] - range[0]) / (range[1] - range[0] || 1) : NaN;
    painter.dots([x, y], 3.4, { color: PAPER, alpha });
    painter.dots([x, y], 2.5, { color: part === part ? ramp(part) : GREY, alpha });
  }
}

/**
 * Contours of the model over two factors. `chosen()`: { place, axes, output, model, column, marks }, where `column` has the rows' values of
 * the output, and `marks` the placements [place, text, colour]; `pick(place)` is told of a click.
 */
function contourFigure(state, explorer, chosen, pick) {
  const frame = (width, height) => ({ left: 62, top: 8, width: Math.max(60, width - (width < 480 ? 78 : 150)), height: height - 56 });
  const sheet = el('canvas', { width: PICTURE, height: PICTURE }), context = sheet.getContext('2d'), errors = new Map();
  let picture = null, waiting = 0;
  const axis = (place) => {
    const factor = explorer.factors[place];
    return { low: factor.range[0], high: factor.range[1], log: factor.logarithmic, title: titled(words(factor.name), factor.unit) };
  };
  const inBox = (box, place, axes) => [box.left + box.width * place[axes[0]], box.top + box.height * (1 - place[axes[1]])];
  const figure = new Figure({
    title: 'The model over two factors', height: (width) => Math.round(Math.min(430, Math.max(260, 0.72 * width))),
    paint(painter, width, height) {
      const { place, axes: [a, b], output, column, marks } = chosen(), box = frame(width, height);
      picture ??= stepped(pictureOf(explorer, chosen(), true, errors));
      const range = [Math.min(...picture.colour), Math.max(...picture.colour)], image = context.createImageData(PICTURE, PICTURE);
      paintPicture(picture, range, image);
      context.putImageData(image, 0, 0);
      axes(painter, box, axis(a), axis(b));
      painter.image(sheet, box.left, box.top, box.width, box.height);
      const lines = (field, level, look) => { for (const [x0, y0, x1, y1] of contour(field, picture.lines, level)) painter.line([box.left + x0 * box.width, box.top + (1 - y0) * box.height, box.left + x1 * box.width, box.top + (1 - y1) * box.height], look); };
      for (const level of ticks(range[0], range[1], 7)) lines(picture.colour, level, { color: '#ffffff', alpha: 0.5 });
      for (const { value, reached } of picture.limits) lines(reached, value.limit, { color: ORANGE, width: 2.5 });
      paintRows(painter, box, { state, explorer, place, axes: [a, b], range, values: column });
      if (width >= 480) scaleBar(painter, box, range, titled(nameOf({ text: output.output, unit: output.unit }), output.unit));
      for (const [at, text, fill] of marks) marker(painter, ...inBox(box, at, [a, b]), text, { fill });
    },
    hover(x, y) {
      const at = this.placeAt(x, y);
      if (!at || !picture) return '';
      const { axes: [a, b], output } = chosen(), [u, v] = [at[a], at[b]];
      const told = ({ value, reached }) => (value.text === SUCCEED ? `${SUCCEED}: ${short(100 * between(reached, picture.lines, u, v))} %`
        : `${nameOf(value)}: ${withUnit(short(between(reached, picture.lines, u, v)), value.unit)} in ${brief(100 * explorer.confidence)} % of runs, limit ${brief(value.limit)}`);
      const colour = `${nameOf({ text: output.output, unit: output.unit })}: ${withUnit(short(between(picture.colour, picture.lines, u, v)), output.unit)}`;
      return [...[a, b].map((place) => `${words(explorer.factors[place].name)}: ${explorer.factors[place].text(at[place])}`), colour, ...picture.limits.map(told)].join('\n');
    },
    placeAt(x, y) {
      const box = frame(this.width, this.tall), { axes: [a, b], place } = chosen(), [u, v] = [(x - box.left) / box.width, 1 - (y - box.top) / box.height];
      if (u < 0 || u > 1 || v < 0 || v > 1) return null;
      const at = Float64Array.from(place);
      at[a] = u; at[b] = v;
      return at;
    },
    drag(_x0, _y0, x1, y1, ended) { const at = this.placeAt(x1, y1); if (at && ended) pick(at); },
  });
  /** Draws at once what a drag has time for, and all of it when there is time. */
  figure.follow = () => {
    performance.mark('decore-slide-begins');
    picture = stepped(pictureOf(explorer, chosen(), true, errors));
    figure.redraw();
    performance.measure('decore-slide', 'decore-slide-begins');
    figure.rest();
  };
  figure.rest = () => {
    clearTimeout(waiting);
    const steps = pictureOf(explorer, chosen(), false, errors), step = () => {
      const found = stepped(steps, SLICE_MS);
      if (!found) { waiting = setTimeout(step); return; }
      picture = found;
      figure.redraw();
      performance.mark('decore-rest');
    };
    waiting = setTimeout(step, REST_MS);
  };
  return figure;
}

/** A bar of colours with its values, right of a box. */
function scaleBar(painter, box, range, title) {
  const x = box.left + box.width + 16, steps = 48;
  for (let k = 0; k < steps; k++) painter.rect(x, box.top + box.height * (1 - (k + 1) / steps), 14, box.height / steps + 0.5, { fill: ramp((k + 0.5) / steps) });
  painter.rect(x, box.top, 14, box.height, { stroke: SOFT });
  for (const [v, text] of zip(ticks(range[0], range[1], 6))) painter.text(text, x + 18, box.top + box.height * (1 - (v - range[0]) / (range[1] - range[0] || 1)), { size: 10, color: SOFT });
  painter.text(wrapped(title, Math.floor(box.height / 5.9), 1)[0], x + 66, box.top + box.height / 2, { align: 'center', turned: true });
}
