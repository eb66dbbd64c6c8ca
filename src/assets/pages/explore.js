// What models expect of a place: averages and limits over the uncertain factors, at one place and over two factors.

/** Kernels that a drag may evaluate: about 20 ms. */
const DRAG_KERNELS = 0.7e6;
/** Lines of a grid at rest, lines of the grid on which the model's error is told, and draws of the uncertain factors that a drag takes. */
const REST_LINES = 25, ERROR_LINES = 7, DRAG_NODES = 6;

/** A value of the goal or a limit in words, without its unit. */
function nameOf({ text, unit }) { return labelOf({ name: text, unit, group: 'run' }); }

/** Every so many of a list's entries, from the middle of each part. */
function spread(list, most) {
  if (list.length <= most) return list;
  return Array.from({ length: most }, (_, k) => list[Math.floor((k + 0.5) * list.length / most)]);
}

/** Models of a page with the question that they answer: values, uncertain factors and their draws. Places are arrays, one number per factor. */
class Explorer {
  constructor({ model, values, uncertain = [], nodes = [[]], caution = 0, confidence = 0.95 }) {
    // In the order of the first uncertain factor: parts of the draws are parts of its distribution.
    const sorted = [...nodes].sort((p, q) => p[0] - q[0]);
    Object.assign(this, { model, values, uncertain, nodes: sorted, caution, confidence, pinned: new Set() });
  }
  get factors() { return this.model.factors; }
  output(value) { return this.model.outputs[value.output]; }
  /** Uncertain factors that are averaged over: neither pinned by the reader nor an axis. */
  free(axes = []) { return this.uncertain.map((factor, k) => [factor, k]).filter(([factor]) => !this.pinned.has(factor) && !axes.includes(factor)); }
  /** The place with each draw of the uncertain factors. */
  draws(place, axes = [], most = Infinity) {
    const free = this.free(axes);
    if (!free.length) return [place];
    return spread(this.nodes, most).map((node) => {
      const drawn = Float64Array.from(place);
      for (const [factor, k] of free) drawn[factor] = node[k];
      return drawn;
    });
  }
  /** What an output is at a place over the draws: mean, and the ends of 95 % of the runs, the model's error included. */
  expected(output, place, model = this.model) {
    const nodes = this.draws(place).map((drawn) => model.predict(output, drawn)), mean = average(nodes, 'mean');
    const wide = nodes.map((node) => ({ ...node, scatter: Math.hypot(node.scatter, node.model) }));
    return { mean, low: quantileOf(wide, false, 0.975, 0), high: quantileOf(wide, true, 0.975, 0) };
  }
  /** What a limited value reaches in the stated share of runs, with the model's error on the bad side. */
  reached(value, place, caution = this.caution) {
    return quantileOf(this.draws(place).map((drawn) => this.model.predict(this.output(value), drawn)), value.smaller, this.confidence, caution);
  }
  /** Share of runs that hold all limits, with the model's error on the bad side. */
  held(place, caution = this.caution) {
    const limits = this.values.filter(({ limit }) => limit !== null);
    const share = (drawn) => limits.reduce((all, value) => all * heldAt(this.model.predict(this.output(value), drawn), value.limit, value.smaller, caution), this.model.success(drawn));
    return this.draws(place).reduce((sum, drawn, _, all) => sum + share(drawn) / all.length, 0);
  }
}

function average(nodes, name) { return nodes.reduce((sum, node) => sum + node[name], 0) / nodes.length; }

/** Values of a model's outputs over two factors about a place, on a grid of lines. What takes long stops now and then (`yield`). */
class Fields {
  /** `drag`: fewer lines and draws, in the time of a frame or two. */
  constructor(explorer, place, axes, drag) {
    const outputs = Math.max(1, explorer.values.filter(({ limit }) => limit !== null).length + 1);
    const rows = Math.max(1, ...explorer.model.outputs.map(({ process }) => process?.count ?? 0));
    this.draws = explorer.draws(place, axes, drag ? DRAG_NODES : Infinity);
    const fitting = Math.floor(Math.sqrt(DRAG_KERNELS / (this.draws.length * rows * outputs)));
    this.lines = drag ? Math.max(7, Math.min(REST_LINES, fitting)) : REST_LINES;
    Object.assign(this, { explorer, place, axes, errors: new Map() });
  }
  at(line, axis, lines = this.lines) { return line / (lines - 1) * this.explorer.factors[axis].end; }
  /** Means of an output of a model at each draw, line by line: [(i * lines + j) * draws + d]. */
  *means(output) {
    const { lines, draws, axes } = this, { process } = output, found = new Float64Array(lines * lines * draws.length);
    if (!process) return found.fill(output.constant);
    const [across, up] = axes.map((axis) => Array.from({ length: lines }, (_, k) => process.addSquares(new Float64Array(process.count), axis, this.at(k, axis))));
    const rest = draws.map((drawn) => {
      const squares = new Float64Array(process.count);
      drawn.forEach((at, factor) => { if (!axes.includes(factor)) process.addSquares(squares, factor, at); });
      return squares;
    });
    const { alpha, count, figures: { mean } } = process;
    for (let i = 0, at = 0; i < lines; i++) {
      yield;
      for (let j = 0; j < lines; j++) {
        for (const own of rest) {
          const [a, b] = [across[i], up[j]];
          let sum = mean;
          for (let k = 0; k < count; k++) sum += alpha[k] * process.at(a[k] + b[k] + own[k]);
          found[at++] = sum;
        }
      }
    }
    return found;
  }
  /** Averages over the draws. */
  *expected(output) {
    const means = yield* this.means(output), { length } = this.draws;
    return Float64Array.from({ length: means.length / length }, (_, cell) => { let sum = 0; for (let d = 0; d < length; d++) sum += means[cell * length + d]; return sum / length; });
  }
  /** Standard deviations of the model's error. */
  error(output) { return this.coarse((place) => this.explorer.model.predict(output, place).model); }
  /** Probability that rows have all values; null where all rows have them. */
  *success() {
    const { explorer } = this;
    return explorer.model.outputs.some(({ success }) => success?.process) ? yield* this.coarse((place) => explorer.model.success(place)) : null;
  }
  /** A figure of places on a coarse grid, as the average of few draws: for what varies slowly. */
  *coarse(figure) {
    const few = this.explorer.draws(this.place, this.axes, 3), found = new Float64Array(ERROR_LINES * ERROR_LINES);
    for (let i = 0; i < ERROR_LINES; i++) {
      for (let j = 0; j < ERROR_LINES; j++) {
        yield;
        const at = few.map((drawn) => { const one = Float64Array.from(drawn); this.axes.forEach((axis, k) => { one[axis] = this.at(k ? j : i, axis, ERROR_LINES); }); return one; });
        found[i * ERROR_LINES + j] = at.reduce((sum, one) => sum + figure(one), 0) / at.length;
      }
    }
    return found;
  }
  /** What a limited value reaches in the stated share of runs: as expected, and with the model's error on its good and bad side. */
  *reached(value, error) {
    const { explorer, lines, draws } = this, output = explorer.output(value), means = yield* this.means(output), { length } = draws;
    const { process } = output, scatter = process ? Math.sqrt(process.own * process.figures.variance) : 0;
    const nodes = draws.map(() => ({ mean: 0, model: 0, scatter })), cautions = error ? [0, -explorer.caution, explorer.caution] : [0];
    const found = cautions.map(() => new Float64Array(lines * lines));
    for (let cell = 0; cell < lines * lines; cell++) {
      const model = error ? between(error, ERROR_LINES, Math.floor(cell / lines) / (lines - 1), cell % lines / (lines - 1)) : 0;
      for (let d = 0; d < length; d++) { nodes[d].mean = means[cell * length + d]; nodes[d].model = model; }
      cautions.forEach((caution, k) => { found[k][cell] = quantileOf(nodes, value.smaller, explorer.confidence, caution, 16); });
    }
    return found;
  }
}

/** A field between the lines of its grid; `x` and `y` from 0 to 1. */
function between(field, lines, x, y) {
  const [u, v] = [x * (lines - 1), y * (lines - 1)], [i, j] = [Math.min(lines - 2, u | 0), Math.min(lines - 2, v | 0)], [a, b] = [u - i, v - j], at = i * lines + j;
  return (1 - a) * ((1 - b) * field[at] + b * field[at + 1]) + a * ((1 - b) * field[at + lines] + b * field[at + lines + 1]);
}

/** Pieces [x0, y0, x1, y1] of the line on which a field has a level, each from 0 to 1. */
function contour(field, lines, level) {
  const pieces = [], step = 1 / (lines - 1);
  for (let i = 0; i + 1 < lines; i++) {
    for (let j = 0; j + 1 < lines; j++) {
      const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]], values = corners.map(([p, q]) => field[p * lines + q] - level), cuts = [];
      for (let k = 0; k < 4; k++) {
        const [a, b] = [values[k], values[(k + 1) % 4]];
        if ((a < 0) === (b < 0)) continue;
        const t = a / (a - b), [[p, q], [r, s]] = [corners[k], corners[(k + 1) % 4]];
        cuts.push([(p + t * (r - p)) * step, (q + t * (s - q)) * step]);
      }
      for (let k = 0; k + 1 < cuts.length; k += 2) pieces.push([...cuts[k], ...cuts[k + 1]]);
    }
  }
  return pieces;
}
