// The table of a report: typed columns out of the page, and the rows that all limits let through.

/** Levels into which linked views sort values, and the mark of a value that is missing. */
const LEVELS = 128, NONE = 255;

/** The columns of the page's data block. Values are numbers (NaN: none); those of a category count into its `names`. */
function readTable(meta) {
  const bytes = bytesOf('data');
  const types = { f32: Float32Array, f64: Float64Array, u32: Uint32Array, u16: Uint16Array, u8: Uint8Array };
  const columns = meta.columns.map((stored, index) => {
    const raw = new types[stored.form](bytes.buffer, bytes.byteOffset + stored.offset, meta.rows_shown);
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

/** Range, domain of axes and level of each value of a column. */
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
  const pad = names ? 0.5 : (high - low) * 0.02 || Math.abs(high) * 0.02 || 1;
  const domain = names ? [-0.5, names.length - 0.5] : count ? [low - pad, high + pad] : [0, 1];
  const levels = new Uint8Array(values.length), scale = LEVELS / (domain[1] - domain[0]);
  for (let i = 0; i < values.length; i++) {
    const v = values[i];
    levels[i] = v !== v ? NONE : Math.min(LEVELS - 1, (v - domain[0]) * scale);
  }
  Object.assign(column, { low, high, count, domain, level: levels, varies: high > low });
}

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
    this.listeners = [];
    this.apply();
  }
  /** Calls `listener` whenever the selection has changed. */
  watch(listener) { this.listeners.push(listener); }
  get narrowed() { return this.limits.size > 0; }
  /** Sets limits of columns: { low, high } of numbers, a Set of codes of categories, null for none. Pairs [column, limit]. */
  set(pairs) {
    performance.mark('decore-brush-begins');
    for (const [column, limit] of pairs) {
      if (limit) this.limits.set(column, limit);
      else this.limits.delete(column);
    }
    this.apply();
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
  apply() {
    const inside = new Uint8Array(this.table.rows).fill(1);
    for (const [{ values }, limit] of this.limits) {
      if (limit instanceof Set) {
        for (let i = 0; i < inside.length; i++) if (inside[i] && !limit.has(values[i])) inside[i] = 0;
      } else {
        const { low, high } = limit;
        // A missing value is within no limits: both comparisons fail.
        for (let i = 0; i < inside.length; i++) inside[i] &= values[i] >= low && values[i] <= high ? 1 : 0;
      }
    }
    let count = 0;
    for (let i = 0; i < inside.length; i++) count += inside[i];
    const picked = new Uint32Array(count);
    for (let i = 0, k = 0; i < inside.length; i++) if (inside[i]) picked[k++] = i;
    this.inside = inside;
    this.picked = picked;
  }
}

/** Number of rows on each level of a column, on `parts` parts of its axis. `rows`: indices, or null for all. */
function histogram(column, rows, parts) {
  const { level, values, names } = column;
  const counts = new Uint32Array(names ? names.length : parts), count = rows ? rows.length : level.length;
  const shift = Math.log2(LEVELS / parts);
  for (let k = 0; k < count; k++) {
    const i = rows ? rows[k] : k;
    if (level[i] !== NONE) counts[names ? values[i] : level[i] >> shift]++;
  }
  return counts;
}

/** Mean, least, largest and number of the values of a column in rows. */
function moments(column, rows) {
  let count = 0, sum = 0, squares = 0, low = Infinity, high = -Infinity;
  for (const i of rows) {
    const v = column.values[i];
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

/**
 * Groups of a column's values: each level where there are few and rows share them, else equal parts of its range, of few rows fewer.
 * { names, centres, of(row) }.
 */
function groups(column, most) {
  const { values, names } = column;
  if (names) return { count: names.length, names, centres: names.map((_, i) => i), of: (i) => values[i] };
  const distinct = new Set();
  for (let i = 0; i < values.length && distinct.size <= most; i++) if (values[i] === values[i]) distinct.add(values[i]);
  if (distinct.size <= most && (2 * distinct.size <= column.count || distinct.size < 3)) {
    const centres = [...distinct].sort((a, b) => a - b), place = new Map(centres.map((v, i) => [v, i]));
    return { count: centres.length, centres, of: (i) => place.get(values[i]) ?? NaN };
  }
  const parts = Math.max(2, Math.min(most, Math.floor(Math.sqrt(column.count / 2))));
  const { low, high } = column, width = (high - low) / parts;
  const centres = Array.from({ length: parts }, (_, i) => low + (i + 0.5) * width);
  return { count: parts, centres, width, of: (i) => Math.min(parts - 1, Math.floor((values[i] - low) / width)) };
}

/** Share of an output's variance that lies between groups of a factor, adjusted for their number: what a factor does by itself. */
function influence(factor, output) {
  const group = groups(factor, 12), sums = new Float64Array(group.count), counts = new Float64Array(group.count);
  let sum = 0, squares = 0, count = 0;
  const step = Math.max(1, Math.floor(output.values.length / 20000));
  for (let i = 0; i < output.values.length; i += step) {
    const v = output.values[i], g = group.of(i);
    if (v !== v || g !== g) continue;
    sums[g] += v; counts[g]++; sum += v; squares += v * v; count++;
  }
  const total = squares - sum * sum / count;
  let between = -sum * sum / count;
  let filled = 0;
  for (let g = 0; g < group.count; g++) if (counts[g]) { between += sums[g] ** 2 / counts[g]; filled++; }
  return total > 0 && count > filled ? 1 - (1 - between / total) * (count - 1) / (count - filled) : 0;
}
