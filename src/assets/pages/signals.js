// Signals out of the page: unpacked, read at a time, thinned for drawing.

/** The bytes of a block of base64 that was deflated. */
async function unpacked(id) {
  const stream = new Blob([bytesOf(id)]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Samples that a block of a coarser level stands for, from one level to the next. */
const COARSER = 4;

/** One signal: a value every `interval` seconds from 0 on, and its least and largest values over ever longer blocks. */
class Trace {
  constructor(values, interval) { Object.assign(this, { values, interval, levels: null }); }
  /** The value at a time, linear between samples. */
  at(time) {
    const { values } = this, place = Math.max(0, Math.min(values.length - 1, time / this.interval));
    const k = Math.min(values.length - 2, Math.floor(place));
    return k < 0 ? values[0] : values[k] + (place - k) * (values[k + 1] - values[k]);
  }
  get pyramid() {
    if (this.levels) return this.levels;
    this.levels = [{ low: this.values, high: this.values }];
    for (let size = this.values.length; size > 64; size = this.levels[this.levels.length - 1].low.length) {
      const below = this.levels[this.levels.length - 1], count = Math.ceil(size / COARSER);
      const low = new Float32Array(count).fill(Infinity), high = new Float32Array(count).fill(-Infinity);
      for (let i = 0; i < size; i++) {
        const k = Math.floor(i / COARSER);
        if (below.low[i] < low[k]) low[k] = below.low[i];
        if (below.high[i] > high[k]) high[k] = below.high[i];
      }
      this.levels.push({ low, high });
    }
    return this.levels;
  }
  /** Indices of the samples within times, both ends included. */
  span(from, to) {
    const last = this.values.length - 1, index = (time, round) => Math.max(0, Math.min(last, round(time / this.interval)));
    return [index(from, (k) => Math.ceil(k - 1e-9)), index(to, (k) => Math.floor(k + 1e-9))];
  }
  /** Least and largest value within times; of none the value there. */
  range(from, to) {
    let [k, end] = this.span(from, to), low = Infinity, high = -Infinity;
    const take = (level, i) => { low = Math.min(low, level.low[i]); high = Math.max(high, level.high[i]); };
    while (k <= end) {
      let [l, block] = [0, 1];
      while (l + 1 < this.pyramid.length && k % (block * COARSER) === 0 && k + block * COARSER - 1 <= end) { l++; block *= COARSER; }
      take(this.pyramid[l], k / block);
      k += block;
    }
    return low <= high ? [low, high] : [this.at(from), this.at(from)];
  }
  /**
   * Points [x, y, x, y, ...] of the signal from `from` to `to` over `width` pixels: every sample where there is room, else the least
   * and the largest value of each half pixel.
   */
  points(from, to, width, px, py) {
    const { values, interval } = this, [first, last] = this.span(from, to), points = [];
    const each = (to - from) / interval / width;
    if (each <= 2) {
      if (this.values.length > 1) points.push(px(from), py(this.at(from)));
      for (let k = first; k <= last; k++) points.push(px(k * interval), py(values[k]));
      if (values.length > 1 && to <= (values.length - 1) * interval) points.push(px(to), py(this.at(to)));
      return points;
    }
    let [l, block] = [0, 1];
    while (l + 1 < this.pyramid.length && block * COARSER <= each / 2) { l++; block *= COARSER; }
    const { low, high } = this.pyramid[l];
    let column = -1, least = 0, most = 0, before = NaN;
    // From the end that is nearer to where the curve was: lines between columns do not cross them.
    const flush = () => {
      if (column < 0) return;
      const x = px(from) + column + 0.5, ends = Math.abs(most - before) < Math.abs(least - before) ? [most, least] : [least, most];
      points.push(x, py(ends[0]), x, py(ends[1]));
      before = ends[1];
    };
    for (let k = Math.ceil(first / block); k <= Math.floor(last / block); k++) {
      const at = Math.floor((k * block * interval - from) / (to - from) * width);
      if (at !== column) { flush(); [column, least, most] = [at, low[k], high[k]]; }
      least = Math.min(least, low[k]);
      most = Math.max(most, high[k]);
    }
    flush();
    return points;
  }
  /** The lines of the signal's curve, as [Trace#points] takes them: one. */
  lines(...at) { return [this.points(...at)]; }
}

/** A part of a measured curve: a signal that begins later and ends earlier than the others. */
class Piece {
  constructor(stored, bytes, interval) {
    const values = new Float32Array(bytes.buffer, bytes.byteOffset + stored.offset, stored.count);
    Object.assign(this, { trace: new Trace(values, interval), from: stored.from_s, to: stored.from_s + (stored.count - 1) * interval });
  }
  at(time) { return time < this.from || time > this.to ? NaN : this.trace.at(time - this.from); }
  clip(from, to) { return [Math.max(from, this.from), Math.min(to, this.to)]; }
  range(from, to) {
    const [begin, end] = this.clip(from, to);
    return begin < end ? this.trace.range(begin - this.from, end - this.from) : [Infinity, -Infinity];
  }
  points(from, to, width, px, py) {
    const [begin, end] = this.clip(from, to);
    if (begin >= end) return [];
    return this.trace.points(begin - this.from, end - this.from, width * (end - begin) / (to - from), (time) => px(time + this.from), py);
  }
}

/** A measured curve: its parts, between which nothing was measured, and times of samples that stand out. */
class Measured {
  constructor(curve, bytes, interval) {
    Object.assign(this, { pieces: curve.pieces.map((stored) => new Piece(stored, bytes, interval)), spikes: curve.spikes_s });
  }
  /** The value at a time; none where nothing was measured. */
  at(time) { return this.pieces.map((piece) => piece.at(time)).find((value) => !Number.isNaN(value)) ?? NaN; }
  range(from, to) {
    return this.pieces.map((piece) => piece.range(from, to)).reduce(([low, high], [a, b]) => [Math.min(low, a), Math.max(high, b)], [Infinity, -Infinity]);
  }
  lines(...at) { return this.pieces.map((piece) => piece.points(...at)).filter((points) => points.length); }
}

/** All signals of the page, by what they are of and their quantity. */
class Signals {
  constructor(meta, bytes) {
    const count = meta.samples;
    this.interval = meta.interval_s;
    this.end = Math.max(0, (count - 1) * meta.interval_s);
    this.named = new Map();
    meta.signals.forEach((stored, index) => {
      const values = new Float32Array(count), start = 4 * count * index, { low, step } = stored.scale;
      let before = 0, slope = 0;
      for (let k = start, i = 0; i < count; i++, k++) {
        const word = bytes[k] | (bytes[k + count] << 8) | (bytes[k + 2 * count] << 16) | (bytes[k + 3 * count] << 24);
        slope = (slope + ((word >>> 1) ^ -(word & 1))) | 0;
        before = (before + slope) | 0;
        values[i] = low + step * before;
      }
      this.named.set(Signals.key(stored.of, stored.quantity), Object.assign(new Trace(values, meta.interval_s), stored));
    });
    this.curves = meta.measured.map((curve) => ({ key: Signals.key(curve.of, curve.quantity), name: curve.column, trace: new Measured(curve, bytes, meta.interval_s) }));
  }
  static key(of, quantity) { return `${JSON.stringify(of)} ${quantity}`; }
  get(of, quantity) { return this.named.get(Signals.key(of, quantity)); }
  hammer(index, quantity) { return this.get({ hammer: index }, quantity); }
  casting(index, quantity) { return this.get({ casting: index }, quantity); }
  fixture(casting, place, quantity) { return this.get({ fixture: [casting, place] }, quantity); }
  core(casting, place, quantity) { return this.get({ core: [casting, place] }, quantity); }
  point(index, quantity) { return this.get({ point: index }, quantity); }
  /** Measured curves of a signal. */
  measured(of, quantity) { return this.curves.filter((curve) => curve.key === Signals.key(of, quantity)); }
  run(quantity) { return this.get('run', quantity); }
}
