// The table of a report: typed columns out of the page, and the rows that all limits let through.

/** Levels into which linked views sort values, the level of a value that is missing, and the number of both. */
const LEVELS = 128, NONE = LEVELS, STRIDE = LEVELS + 1;
/** Logarithms of one more than a whole number, for densities. */
const LOGS = Float32Array.from({ length: 4096 }, (_, i) => Math.log1p(i));

/** Colours of values from low to high, each lighter than the one before, legible on light and dark paper and without colour vision. */
const RAMP = [[72, 36, 117], [56, 88, 140], [33, 144, 141], [84, 197, 104], [206, 222, 40]];

function rampRgb(part) {
  const at = Math.max(0, Math.min(0.9999, part)) * (RAMP.length - 1), k = Math.floor(at), t = at - k;
  return RAMP[k].map((c, i) => Math.round(c + t * (RAMP[k + 1][i] - c)));
}

function ramp(part) { return `rgb(${rampRgb(part).join()})`; }

/** What is computed when it is first asked for; `make(key)` makes it. */
class Kept extends Map {
  constructor(make) { super(); this.make = make; }
  of(key) {
    if (!this.has(key)) this.set(key, this.make(key));
    return this.get(key);
  }
}

/** The page's data block. */
const pageBytes = bytesOf('data');

/** The columns of the page's data block. Values are numbers (NaN: none); those of a category count into its `names`. */
function readTable(meta) {
  const types = { f32: Float32Array, f64: Float64Array, u32: Uint32Array, u16: Uint16Array, u8: Uint8Array };
  const columns = meta.columns.map((stored, index) => {
    const raw = new types[stored.form](pageBytes.buffer, pageBytes.byteOffset + stored.offset, meta.rows_shown);
    const column = { ...stored, index, label: labelOf(stored), values: raw };
    if (stored.names) column.values = Float32Array.from(raw, (code) => (code < stored.names.length ? code : NaN));
    measure(column);
    return column;
  });
  return { meta, columns, rows: meta.rows_shown, named: new Map(columns.map((column) => [column.name, column])) };
}

/** The name of a column as words; the unit stands beside it. */
function labelOf({ name, subject, group, unit }) {
  if (group === 'factor') return subject;
  const suffix = unit === 'J/NL' ? '_j_per_nl' : `_${unit.toLowerCase().replace(/[^a-z0-9]+/g, '_')}`;
  const scatter = name.endsWith('_scatter') ? ' (scatter)' : '';
  const plain = scatter ? name.slice(0, -'_scatter'.length) : name;
  const bare = unit && unit !== '1' && plain.endsWith(suffix) ? plain.slice(0, -suffix.length) : plain;
  return bare.replaceAll('_', ' ') + scatter;
}

/** Range and domain of axes of a column. */
function measure(column) {
  const { values, names } = column;
  let low = Infinity, high = -Infinity, count = 0;
  for (let i = 0; i < values.length; i++) {
    const v = values[i];
    if (v !== v) continue;
    count++;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  const pad = names ? 0.5 : (high - low) * 0.02 || Math.abs(high) * 0.02 || 1, log = column.logarithmic && !names && low > 0 && high > low;
  const domain = names ? [-0.5, names.length - 0.5] : log ? [low * (low / high) ** 0.02, high * (high / low) ** 0.02] : count ? [low - pad, high + pad] : [0, 1];
  Object.assign(column, { low, high, count, domain, log, varies: high > low });
}

/** The level of each value of a column. */
const levels = new Kept((column) => {
  const { domain, log } = column, values = log ? places.of(column) : column.values, found = new Uint8Array(values.length);
  const base = log ? 0 : domain[0], scale = LEVELS / (log ? 1 : domain[1] - base);
  for (let i = 0; i < values.length; i++) {
    const v = values[i];
    found[i] = v !== v ? NONE : (v - base) * scale;
  }
  return found;
});

/** The place of each value of a column in its domain, from 0 to 1. */
const places = new Kept((column) => {
  const { values, domain, log } = column, found = new Float32Array(values.length), base = domain[0], scale = 1 / (domain[1] - base), part = scaled(column);
  if (log) for (let i = 0; i < values.length; i++) found[i] = part(values[i]);
  else for (let i = 0; i < values.length; i++) found[i] = (values[i] - base) * scale;
  return found;
});

/** A value as it stands in the table of all digits that the page has. */
function exact(column, row) {
  const v = column.values[row];
  if (v !== v) return '';
  if (column.names) return column.names[v];
  if (column.form !== 'f32') return String(v);
  for (let digits = 6; digits < 9; digits++) {
    if (Math.fround(Number(v.toPrecision(digits))) === v) return String(Number(v.toPrecision(digits)));
  }
  return String(Number(v.toPrecision(9)));
}

/** A value to read. */
function readable(column, row) {
  const v = column.values[row];
  if (v !== v) return '–';
  if (column.names) return column.names[v];
  return column.whole ? String(v) : short(v);
}

/** The limits that the reader has set, and the rows within all of them. */
class Selection {
  constructor(table) {
    this.table = table;
    this.limits = new Map();
    this.areas = new Map();
    this.listeners = [];
    /** By how many limits a row is left out, and which rows each limit leaves out. */
    this.left = new Uint16Array(table.rows);
    this.masks = new Map();
    this.pick();
  }
  /** Calls `listener` whenever the selection has changed. */
  watch(listener) { this.listeners.push(listener); }
  get narrowed() { return this.limits.size > 0; }
  /** What a brush over a panel of two columns limits, beside the limits of each: its limit is a pair of theirs. */
  area(a, b) {
    const key = `${a.index} ${b.index}`;
    if (!this.areas.has(key)) this.areas.set(key, { columns: [a, b], label: `${a.label}, ${b.label}` });
    return this.areas.get(key);
  }
  /** Sets limits of columns: { low, high } of numbers, a Set of codes of categories, null for none. Pairs [column or area, limit]. */
  set(pairs) {
    performance.mark('decore-brush-begins');
    for (const [column, limit] of pairs) {
      if (limit) this.limits.set(column, limit);
      else this.limits.delete(column);
      this.apply(column);
    }
    this.pick();
    for (const listener of this.listeners) listener();
    performance.measure('decore-brush', 'decore-brush-begins');
  }
  /** The limit that a span of a column's axis stands for; null for one of no length. */
  static span(column, from, to) {
    const [low, high] = from < to ? [from, to] : [to, from];
    if (!(high > low)) return null;
    if (!column.names) return { low, high };
    const codes = column.names.map((_, code) => code).filter((code) => code + 0.5 > low && code - 0.5 < high);
    return codes.length ? new Set(codes) : null;
  }
  clear() { this.set([...this.limits.keys()].map((column) => [column, null])); }
  /** Renews what the limit of a column leaves out; the other limits stay as they are. */
  apply(column) {
    const { left } = this, limit = this.limits.get(column), before = this.masks.get(column);
    if (before) for (let i = 0; i < left.length; i++) left[i] -= before[i];
    if (!limit) { this.masks.delete(column); return; }
    const mask = (before || new Uint8Array(left.length)).fill(0);
    if (column.columns) column.columns.forEach((one, k) => { if (limit[k]) Selection.exclude(mask, one.values, limit[k]); });
    else Selection.exclude(mask, column.values, limit);
    for (let i = 0; i < left.length; i++) left[i] += mask[i];
    this.masks.set(column, mask);
  }
  /** Marks the rows beyond a limit of their values. */
  static exclude(mask, values, limit) {
    if (limit instanceof Set) {
      for (let i = 0; i < mask.length; i++) if (!limit.has(values[i])) mask[i] = 1;
      return;
    }
    const { low, high } = limit;
    // A missing value is within no limits: both comparisons fail.
    for (let i = 0; i < mask.length; i++) if (!(values[i] >= low && values[i] <= high)) mask[i] = 1;
  }
  /** Lists the rows within all limits. */
  pick() {
    const { left } = this, picked = new Uint32Array(left.length);
    let count = 0;
    for (let i = 0; i < left.length; i++) { picked[count] = i; count += left[i] ? 0 : 1; }
    this.picked = picked.subarray(0, count);
    const some = (all) => new Kept((column) => (this.narrowed ? gathered(all.of(column), this.picked) : all.of(column)));
    /** Levels and places of the selected rows alone. */
    [this.levels, this.places] = [some(levels), some(places)];
  }
}

/** The values of some rows. */
function gathered(values, rows) {
  const some = new values.constructor(rows.length);
  for (let k = 0; k < some.length; k++) some[k] = values[rows[k]];
  return some;
}

/** Parts of an axis on which rows are counted. */
const PARTS = 32;

/** Number of rows on each part of a column's axis, of a category on each name. */
function histogram(column, selection) {
  if (!selection.narrowed) return distributions.of(column);
  return column.names ? counted(gathered(column.values, selection.picked), column.names.length) : onParts(selection.levels.of(column));
}

const distributions = new Kept((column) => (column.names ? counted(column.values, column.names.length) : onParts(levels.of(column))));

function onParts(found) {
  const counts = new Uint32Array(PARTS + 1), shift = Math.log2(LEVELS / PARTS);
  for (let k = 0; k < found.length; k++) counts[found[k] >> shift]++;
  // The last is of those that are missing.
  return counts.subarray(0, PARTS);
}

function counted(codes, names) {
  const counts = new Uint32Array(names);
  for (let k = 0; k < codes.length; k++) if (codes[k] === codes[k]) counts[codes[k]]++;
  return counts;
}

/** Mean, least, largest and number of the values of a column in rows. */
function moments(column, rows) {
  let count = 0, sum = 0, squares = 0, low = Infinity, high = -Infinity;
  for (let k = 0; k < rows.length; k++) {
    const v = column.values[rows[k]];
    if (v !== v) continue;
    const before = count ? sum / count : 0;
    count++; sum += v;
    squares += (v - before) * (v - sum / count);
    if (v < low) low = v;
    if (v > high) high = v;
  }
  const deviation = count > 1 ? Math.sqrt(squares / (count - 1)) : NaN;
  return { count, mean: count ? sum / count : NaN, low, high, deviation, error: deviation / Math.sqrt(count) };
}

/** Groups of columns' values as [grouped] finds them, by the largest number of groups. */
const groupings = new Kept((most) => new Kept((column) => grouped(column, most)));

function groups(column, most) { return groupings.of(most).of(column); }

/**
 * Groups of a column's values: each level where there are few and rows share them, else equal parts of its range, of few rows fewer.
 * { count, names, centres, width, of }: `of` has the group of each row, [UNGROUPED] where there is none.
 */
function grouped(column, most) {
  const { values, names, low, high } = column, of = new Uint8Array(values.length);
  const all = (group) => { for (let i = 0; i < of.length; i++) of[i] = values[i] === values[i] ? group(values[i]) : UNGROUPED; };
  if (names) {
    all((v) => v);
    return { count: names.length, names, centres: names.map((_, i) => i), of };
  }
  const distinct = new Set();
  for (let i = 0; i < values.length && distinct.size <= most; i++) if (values[i] === values[i]) distinct.add(values[i]);
  if (distinct.size <= most && (2 * distinct.size <= column.count || distinct.size < 3)) {
    const centres = [...distinct].sort((a, b) => a - b), place = new Map(centres.map((v, i) => [v, i]));
    all((v) => place.get(v));
    return { count: centres.length, centres, of };
  }
  const parts = Math.max(2, Math.min(most, Math.floor(Math.sqrt(column.count / 2))));
  const axis = { log: column.log, domain: [low, high] }, part = scaled(axis), last = parts - 1;
  const scale = parts / (high - low);
  all(column.log ? (v) => Math.min(last, Math.floor(part(v) * parts)) : (v) => Math.min(last, Math.floor((v - low) * scale)));
  return { count: parts, centres: Array.from({ length: parts }, (_, i) => valueAt(axis, (i + 0.5) / parts)), width: (high - low) / parts, of };
}

/** The group of a row whose value is missing: beyond the number of names that a page tells apart. */
const UNGROUPED = 255;

/** The first `most` of rows in an order, without sorting all. */
function leastOf(rows, order, most) {
  const kept = [];
  for (let k = 0; k < rows.length; k++) {
    const row = rows[k];
    if (kept.length === most && order(row, kept[most - 1]) > 0) continue;
    let [from, to] = [0, kept.length];
    while (from < to) { const middle = (from + to) >> 1; if (order(kept[middle], row) < 0) from = middle + 1; else to = middle; }
    kept.splice(from, 0, row);
    if (kept.length > most) kept.pop();
  }
  return kept;
}

/** Share of an output's variance that lies between groups of a factor, adjusted for their number: what a factor does by itself. */
function influence(factor, output) {
  const group = groups(factor, 12), sums = new Float64Array(group.count), counts = new Float64Array(group.count);
  let sum = 0, squares = 0, count = 0;
  const step = Math.max(1, Math.floor(output.values.length / 20000));
  for (let i = 0; i < output.values.length; i += step) {
    const v = output.values[i], g = group.of[i];
    if (v !== v || g === UNGROUPED) continue;
    sums[g] += v; counts[g]++; sum += v; squares += v * v; count++;
  }
  const total = squares - sum * sum / count;
  let between = -sum * sum / count;
  let filled = 0;
  for (let g = 0; g < group.count; g++) if (counts[g]) { between += sums[g] ** 2 / counts[g]; filled++; }
  return total > 0 && count > filled ? 1 - (1 - between / total) * (count - 1) / (count - filled) : 0;
}
