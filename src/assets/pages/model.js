// Models that predict in the page: Gaussian processes of the outputs, with the digits that decore itself computes.

const [LN_2_HIGH, LN_2_LOW] = [0.6931471803691238, 1.9082149292705877e-10];
/** The words of a number, to write its exponent. */
const WORDS = new Float64Array(1), HALVES = new Uint32Array(WORDS.buffer);

/** The exponential function by basic operations alone: weights of rows are large numbers of both signs, so that last digits show. */
function expOf(x) {
  const ROUNDING = 6755399441055744, clipped = x < -700 ? -700 : x > 700 ? 700 : x;
  const k = (clipped * 1.4426950408889634 + ROUNDING) - ROUNDING, r = (clipped - k * LN_2_HIGH) - k * LN_2_LOW, square = r * r;
  const even = ((((((1 / 479001600) * square + 1 / 3628800) * square + 1 / 40320) * square + 1 / 720) * square + 1 / 24) * square + 1 / 2) * square + 1;
  const odd = ((((((1 / 6227020800) * square + 1 / 39916800) * square + 1 / 362880) * square + 1 / 5040) * square + 1 / 120) * square + 1 / 6) * square + 1;
  HALVES[0] = 0; HALVES[1] = (k + 1023) << 20;
  return (even + r * odd) * WORDS[0];
}

/** The natural logarithm of a positive number, by basic operations alone. */
function lnOf(x) {
  WORDS[0] = Math.max(x, 2.2250738585072014e-308);
  let exponent = ((HALVES[1] >>> 20) & 0x7ff) - 1023;
  HALVES[1] = (HALVES[1] & 0xfffff) | (1023 << 20);
  let mantissa = WORDS[0];
  if (mantissa > 1.4142135623730951) { mantissa *= 0.5; exponent += 1; }
  const f = (mantissa - 1) / (mantissa + 1), square = f * f;
  let total = 1 / 21;
  for (let odd = 19; odd >= 3; odd -= 2) total = total * square + 1 / odd;
  return exponent * LN_2_HIGH + (2 * f + (2 * f * square * total + exponent * LN_2_LOW));
}

/** A factor as a model sees it: { name, unit, names, range, logarithmic }. */
class FactorAxis {
  constructor(space) { Object.assign(this, space); this.of = space.logarithmic ? lnOf : (v) => v; }
  get nominal() { return this.names.length > 0; }
  /** Largest place: 1 over a range, of names the last number. */
  get end() { return this.nominal ? this.names.length - 1 : 1; }
  /** The place of a value in the range, 0 to 1; of a name its number. */
  scaled(value) {
    if (this.nominal) return Math.max(0, this.names.indexOf(String(value)));
    const [low, high] = this.range.map(this.of);
    return high > low ? (this.of(Number(value)) - low) / (high - low) : 0;
  }
  /** The value at a place. */
  value(place) {
    if (this.nominal) return this.names[Math.round(place)];
    const [low, high] = this.range;
    return this.logarithmic ? low * (high / low) ** place : low + place * (high - low);
  }
  text(place) { return this.nominal ? this.value(place) : withUnit(brief(this.value(place)), this.unit); }
}

/** One Gaussian process: mean and standard deviation at places. */
class Process {
  constructor(stored, points, { factors, numbers }) {
    const { figures, count } = stored, d = factors.length;
    Object.assign(this, { figures, count, d, runs: numbers(stored.runs, count), alpha: numbers(stored.weights, count), nominal: factors.map((factor) => factor.nominal) });
    const rows = numbers(stored.rows, count);
    this.points = new Float64Array(count * d);
    for (let i = 0; i < count; i++) for (let k = 0; k < d; k++) this.points[i * d + k] = points[rows[i] * d + k];
    this.own = figures.noise + figures.spread;
    this.matern = figures.kernel === 'matern_5_2';
  }
  at(squared) {
    if (!this.matern) return expOf(-0.5 * squared);
    const s = Math.sqrt(5 * squared);
    return (1 + s + s * s / 3) * expOf(-s);
  }
  /** Adds weighted squared differences in one factor to the rows' distances from a place. */
  addSquares(into, factor, place) {
    const { points, d, count } = this, weight = this.figures.weights[factor], nominal = this.nominal[factor];
    for (let i = 0, p = factor; i < count; i++, p += d) {
      const off = points[p] - place;
      into[i] += nominal ? (off === 0 ? 0 : weight) : weight * (off * off);
    }
    return into;
  }
  near(place) {
    const squares = new Float64Array(this.count);
    for (let k = 0; k < this.d; k++) this.addSquares(squares, k, place[k]);
    for (let i = 0; i < squares.length; i++) squares[i] = this.at(squares[i]);
    return squares;
  }
  sum(near) {
    let known = 0;
    for (let i = 0; i < near.length; i++) known += near[i] * this.alpha[i];
    return this.figures.mean + known;
  }
  mean(place) { return this.sum(this.near(place)); }
  /** The Cholesky factor of the rows' correlations, line by line, and what it makes of ones. */
  factor() {
    if (this.cholesky) return this.cholesky;
    const { count: n, d, points, own } = this, lines = [];
    for (let i = 0; i < n; i++) {
      const line = this.near(points.subarray(i * d, (i + 1) * d)).subarray(0, i + 1);
      line[i] = 1 + this.figures.noise + this.figures.spread / this.runs[i];
      for (let j = 0; j <= i; j++) {
        let rest = line[j];
        const other = j < i ? lines[j] : line;
        for (let k = 0; k < j; k++) rest -= line[k] * other[k];
        line[j] = j < i ? rest / other[j] : Math.sqrt(rest);
      }
      lines.push(line);
    }
    const ones = this.solve(lines, new Float64Array(n).fill(1));
    return (this.cholesky = { lines, ones, total: ones.reduce((sum, one) => sum + one * one, 0), own });
  }
  solve(lines, side) {
    for (let i = 0; i < side.length; i++) {
      const line = lines[i];
      let rest = side[i];
      for (let k = 0; k < i; k++) rest -= line[k] * side[k];
      side[i] = rest / line[i];
    }
    return side;
  }
  /** Expected value, and standard deviation of a new row, noise included. */
  predict(place) {
    const near = this.near(place), mean = this.sum(near), { lines, ones, total, own } = this.factor();
    const explained = this.solve(lines, near);
    let squares = 0, sum = 0;
    for (let i = 0; i < explained.length; i++) { squares += explained[i] * explained[i]; sum += explained[i] * ones[i]; }
    const share = Math.max(1 - squares, 0) + (1 - sum) * (1 - sum) / total + own;
    return { mean, stdDev: Math.sqrt(this.figures.variance * share) };
  }
}

/** Models of outputs over the same factors. */
class PageModel {
  constructor(stored, bytes) {
    const numbers = (offset, count) => new Float64Array(bytes.buffer, bytes.byteOffset + offset, count);
    this.factors = stored.factors.map((factor) => new FactorAxis(factor));
    const of = { factors: this.factors, numbers }, points = numbers(stored.points, stored.rows * stored.factors.length);
    const process = (one) => one && new Process(one, points, of);
    this.outputs = stored.outputs.map((output) => ({
      ...output, process: process(output.process), success: output.success && { ...output.success, process: process(output.success.process) },
    }));
  }
  has(output) { return output.process || output.constant !== null; }
  mean(output, place) { return output.process ? output.process.mean(place) : output.constant; }
  /** Expected value, standard deviation of the model's error and of a run about its expected value. */
  predict(output, place) {
    const { process } = output;
    if (!process) return { mean: output.constant, model: 0, scatter: 0 };
    const { mean, stdDev } = process.predict(place), scatter = Math.sqrt(process.own * process.figures.variance);
    const model = process.figures.reach / 1.959963984540054 * Math.sqrt(Math.max(0, stdDev * stdDev - scatter * scatter));
    return { mean, model, scatter };
  }
  /** Probability that a row is done and has all outputs of the model. */
  success(place) {
    return this.outputs.reduce((least, { success }) => {
      if (!success) return least;
      if (!success.process) return Math.min(least, success.everywhere);
      const [slope, offset] = success.scaling, { mean, stdDev } = success.process.predict(place);
      const margin = (slope * mean + offset) / Math.sqrt(1 + Math.PI / 8 * (slope * stdDev) ** 2);
      return Math.min(least, 1 / (1 + Math.exp(-margin)));
    }, 1);
  }
}

/** The normal distribution function, to 1e-7. */
function normalCdf(x) {
  const z = Math.abs(x) / Math.SQRT2, t = 1 / (1 + 0.5 * z);
  const terms = [1.00002368, 0.37409196, 0.09678418, -0.18628806, 0.27886807, -1.13520398, 1.48851587, -0.82215223, 0.17087277];
  const series = terms.reduceRight((sum, term) => term + t * sum, 0);
  const tail = t * Math.exp(-z * z - 1.26551223 + series * t);
  return x >= 0 ? 1 - tail / 2 : tail / 2;
}

/** Share of runs within a limit over equally likely nodes { mean, model, scatter }; `caution`: see decore help best. */
function heldAt(node, limit, smaller, caution) {
  const off = (smaller ? limit - node.mean : node.mean - limit) - caution * node.model;
  return node.scatter > 0 ? normalCdf(off / node.scatter) : Number(off >= 0);
}

/** The least limit that a share of runs hold; where values must be large, the largest. */
function quantileOf(nodes, smaller, share, caution, steps = 40) {
  let [low, high] = [Infinity, -Infinity];
  for (const { mean, model, scatter } of nodes) {
    const reach = Math.abs(caution) * model + 9 * scatter;
    low = Math.min(low, mean - reach); high = Math.max(high, mean + reach);
  }
  for (let step = 0; step < steps && high > low; step++) {
    const middle = 0.5 * (low + high);
    let held = 0;
    for (const node of nodes) held += heldAt(node, middle, smaller, caution);
    if ((held >= share * nodes.length - 1e-9) === smaller) high = middle; else low = middle;
  }
  return smaller ? high : low;
}
