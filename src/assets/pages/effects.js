// What factors do: failures, main effects, response surfaces, fronts.

/** Colours of a surface from low to high, each lighter than the next, legible without colour vision. */
const RAMP = [[247, 251, 255], [198, 219, 239], [107, 174, 214], [33, 113, 181], [8, 48, 107]];

function ramp(part) {
  const at = Math.max(0, Math.min(0.9999, part)) * (RAMP.length - 1), k = Math.floor(at), t = at - k;
  return `rgb(${RAMP[k].map((c, i) => Math.round(c + t * (RAMP[k + 1][i] - c))).join()})`;
}

const REASON_COLORS = ['#a3341c', '#d58a1f', '#6a4c93', '#4a7a4a', '#55606e'];

/** Share of rows that are not done over a factor, stacked by reason. `reasons`: the codes shown, most frequent first. */
function failureFigure(state, factor, reasons) {
  const { status, reason } = state, group = groups(factor, 16), done = status.names.indexOf('done');
  const all = new Uint32Array(group.count), parts = reasons.map(() => new Uint32Array(group.count));
  for (let i = 0; i < status.values.length; i++) {
    const g = group.of[i];
    if (g === UNGROUPED) continue;
    all[g]++;
    if (status.values[i] !== done) {
      const at = reasons.indexOf(reason.values[i]);
      parts[at < 0 ? parts.length - 1 : at][g]++;
    }
  }
  const frame = (width, height) => ({ left: 52, top: 6, width: width - 62, height: height - 44 });
  const share = (g) => 100 * parts.reduce((sum, part) => sum + part[g], 0) / (all[g] || 1);
  return new Figure({
    title: `Rows not done (%) over ${factor.label}`, height: 175,
    paint(painter, width, height) {
      const box = frame(width, height), most = Math.max(1e-9, ...all.keys().map(share));
      const names = factor.names || (group.width ? null : group.centres.map((v) => short(v)));
      const x = names ? { low: -0.5, high: group.count - 0.5, names } : { low: factor.low, high: factor.high };
      const { py } = axes(painter, box, { ...x, title: titled(factor.label, factor.unit) }, { low: 0, high: most });
      const width1 = box.width / group.count;
      for (let g = 0; g < group.count; g++) {
        let below = 0;
        parts.forEach((part, r) => {
          const size = 100 * part[g] / (all[g] || 1);
          painter.rect(box.left + g * width1 + 1, py(below + size), Math.max(1, width1 - 2), py(below) - py(below + size), { fill: REASON_COLORS[r] });
          below += size;
        });
      }
    },
    hover(x) {
      const box = frame(this.width, this.tall), g = Math.floor((x - box.left) / box.width * group.count);
      if (!(g in group.centres)) return '';
      const lines = reasons.map((code, r) => (parts[r][g] ? `\n${parts[r][g]} x ${reason.names[code]}` : ''));
      return `${factor.label} ${factor.names ? factor.names[g] : withUnit(short(group.centres[g]), factor.unit)}: ${short(share(g))} % of ${all[g]} rows${lines.join('')}`;
    },
  });
}

/** Means of an output in the groups of a factor, over the selected rows. */
function effect(factor, output, rows) {
  const group = groups(factor, 12), n = group.count;
  const counts = new Uint32Array(n), means = new Float64Array(n), squares = new Float64Array(n);
  for (let k = 0; k < rows.length; k++) {
    const v = output.values[rows[k]], g = group.of[rows[k]];
    if (v !== v || g === UNGROUPED) continue;
    const before = means[g];
    counts[g]++;
    means[g] += (v - before) / counts[g];
    squares[g] += (v - before) * (v - means[g]);
  }
  const error = (g) => (counts[g] > 1 ? Math.sqrt(squares[g] / (counts[g] - 1) / counts[g]) : 0);
  return { ...group, counts, means, error };
}

/** Main effect of a factor on the output that the reader has chosen: means with their standard errors, one scale for all factors. */
function effectFigure(state, factor, effects) {
  const frame = (width, height) => ({ left: 60, top: 8, width: width - 72, height: height - 52 });
  const xs = (one) => (factor.names || one.count === 1 ? { low: -0.5, high: one.count - 0.5 } : { low: factor.domain[0], high: factor.domain[1] });
  return new Figure({
    title: factor.label, height: 190,
    paint(painter, width, height) {
      const { range, output, of } = effects(), one = of.get(factor), box = frame(width, height);
      const at = one.names || one.count > 1 ? one.centres : [0];
      const names = factor.names || (one.count === 1 ? [short(one.centres[0])] : null);
      const { px, py } = axes(painter, box, { ...xs(one), names, title: titled(factor.label, factor.unit) }, { low: range[0], high: range[1], title: titled(output.label, output.unit) });
      const seen = at.map((_, g) => g).filter((g) => one.counts[g]);
      if (!factor.names) painter.line(seen.flatMap((g) => [px(at[g]), py(one.means[g])]), { color: BLUE, width: 1.5 });
      for (const g of seen) painter.line([px(at[g]), py(one.means[g] - one.error(g)), px(at[g]), py(one.means[g] + one.error(g))], { color: BLUE, width: 3, alpha: 0.4 });
      painter.dots(seen.flatMap((g) => [px(at[g]), py(one.means[g])]), 3.2);
    },
    hover(x) {
      const { output, of } = effects(), one = of.get(factor), box = frame(this.width, this.tall), axis = xs(one);
      const v = axis.low + (x - box.left) / box.width * (axis.high - axis.low);
      const at = one.names || one.count > 1 ? one.centres : [0];
      let g = 0;
      at.forEach((centre, k) => { if (Math.abs(centre - v) < Math.abs(at[g] - v)) g = k; });
      if (!one.counts[g]) return '';
      const where = factor.names ? factor.names[g] : withUnit(short(one.centres[g]), factor.unit);
      return `${factor.label} ${where}\n${output.label}: ${withUnit(short(one.means[g]), output.unit)} ± ${short(one.error(g))} (standard error of the mean, ${one.counts[g]} rows)`;
    },
  });
}

/** Mean of an output over two factors, over the selected rows. `chosen()`: { output, a, b }. */
function surfaceFigure(state, chosen) {
  const frame = (width, height) => ({ left: 66, top: 8, width: width - 190, height: height - 54 });
  const compute = () => {
    const { output, a, b } = chosen(), [ga, gb] = [groups(a, 16), groups(b, 16)];
    const means = new Float64Array(ga.count * gb.count), squares = new Float64Array(means.length), counts = new Uint32Array(means.length);
    const { picked } = state.selection;
    for (let p = 0; p < picked.length; p++) {
      const i = picked[p], v = output.values[i], k = ga.of[i] * gb.count + gb.of[i];
      if (v === v && ga.of[i] !== UNGROUPED && gb.of[i] !== UNGROUPED) {
        const before = means[k];
        counts[k]++;
        means[k] += (v - before) / counts[k];
        squares[k] += (v - before) * (v - means[k]);
      }
    }
    counts.forEach((count, k) => { if (!count) means[k] = NaN; });
    const there = means.filter((m) => m === m), deviation = (k) => (counts[k] > 1 ? Math.sqrt(squares[k] / (counts[k] - 1)) : NaN);
    const range = there.reduce(([low, high], m) => [Math.min(low, m), Math.max(high, m)], [Infinity, -Infinity]);
    return { output, a, b, ga, gb, counts, means, deviation, range };
  };
  const axis = (column, group) => {
    const names = column.names || (group.width ? null : group.centres.map((v) => short(v)));
    const ends = names ? { low: -0.5, high: group.count - 0.5, names } : { low: column.low, high: column.high };
    return { ...ends, title: titled(column.label, column.unit) };
  };
  return new Figure({
    title: 'Response surface', height: 380,
    paint(painter, width, height) {
      const s = this.surface = compute(), box = frame(width, height), [w, h] = [box.width / s.ga.count, box.height / s.gb.count];
      axes(painter, box, axis(s.a, s.ga), axis(s.b, s.gb));
      const span = s.range[1] - s.range[0] || 1;
      for (let i = 0; i < s.ga.count; i++) {
        for (let j = 0; j < s.gb.count; j++) {
          const mean = s.means[i * s.gb.count + j];
          if (mean === mean) painter.rect(box.left + i * w, box.top + box.height - (j + 1) * h, w + 0.3, h + 0.3, { fill: ramp((mean - s.range[0]) / span) });
        }
      }
      if (!(s.range[1] >= s.range[0])) { painter.text('no selected row has this output', box.left + 20, box.top + 30, {}); return; }
      const [x, steps] = [box.left + box.width + 28, 48];
      for (let k = 0; k < steps; k++) painter.rect(x, box.top + box.height * (1 - (k + 1) / steps), 16, box.height / steps + 0.5, { fill: ramp((k + 0.5) / steps) });
      painter.rect(x, box.top, 16, box.height, { stroke: SOFT });
      for (const [v, text] of zip(ticks(s.range[0], s.range[1], 6))) painter.text(text, x + 21, box.top + box.height * (1 - (v - s.range[0]) / span), { size: 10, color: SOFT });
      painter.text(wrapped(titled(s.output.label, s.output.unit), Math.floor(box.height / 5.9), 1)[0], x + 84, box.top + box.height / 2, { align: 'center', turned: true });
    },
    hover(x, y) {
      const s = this.surface, box = frame(this.width, this.tall);
      const i = Math.floor((x - box.left) / box.width * s.ga.count), j = Math.floor((1 - (y - box.top) / box.height) * s.gb.count);
      const k = i * s.gb.count + j;
      if (!(i in s.ga.centres) || !(j in s.gb.centres) || !s.counts[k]) return '';
      const at = (column, group, g) => `${column.label}: ${column.names ? column.names[g] : withUnit(short(group.centres[g]), column.unit)}`;
      return `${at(s.a, s.ga, i)}\n${at(s.b, s.gb, j)}\n${s.output.label}: ${withUnit(short(s.means[k]), s.output.unit)} ± ${short(s.deviation(k) / Math.sqrt(s.counts[k]))} (mean of ${s.counts[k]} rows and its standard error; scatter of rows ${short(s.deviation(k))})`;
    },
  });
}

/**
 * Rows that no other row beats: none is at least as good in all goals and better in one. `goals`: [column, sign], sign 1 for larger
 * is better. Sorted by the first goal, a row need only be compared with the front found so far.
 */
function front(all, goals) {
  const rows = unbeaten(all, goals), size = rows.length, keys = goals.map(([column, sign]) => Float64Array.from(rows, (i) => sign * column.values[i]));
  const order = Array.from({ length: size }, (_, k) => k).filter((k) => keys.every((key) => key[k] === key[k]));
  order.sort((p, q) => { for (const key of keys) if (key[p] !== key[q]) return key[q] - key[p]; return p - q; });
  const kept = [];
  const beaten = (k) => kept.some((other) => keys.every((key) => key[other] >= key[k]) && keys.some((key) => key[other] > key[k]));
  let best = -Infinity, tie = NaN;
  for (const k of order) {
    if (keys.length === 2) {
      // In this order only a larger second goal is not beaten, or a row equal to the last one kept.
      if (keys[1][k] > best) [best, tie] = [keys[1][k], keys[0][k]];
      else if (keys[1][k] !== best || keys[0][k] !== tie) continue;
      kept.push(k);
    } else if (!beaten(k)) kept.push(k);
  }
  return kept.map((k) => rows[k]);
}

/**
 * Rows less those that are beaten in the last goal by a row on higher levels of the others: of many rows few are left to be sorted.
 * On each pair of levels stands the best last goal of all rows on these or higher levels.
 */
function unbeaten(rows, goals) {
  const [across, up, last] = [goals[0], goals.length > 2 ? goals[1] : null, goals[goals.length - 1]], size = STRIDE + 1;
  const rank = ([column, sign]) => { const level = levels.of(column); return (i) => (sign > 0 || level[i] === NONE ? level[i] : NONE - 1 - level[i]); };
  const [x, y] = [rank(across), up ? rank(up) : () => 0], place = places.of(last[0]), sign = last[1];
  const best = new Float32Array(size * size).fill(-Infinity), kept = new Uint32Array(rows.length);
  for (let k = 0; k < rows.length; k++) {
    const i = rows[k], a = x(i), b = y(i), value = sign * place[i];
    if (a !== NONE && b !== NONE && value > best[a * size + b]) best[a * size + b] = value;
  }
  for (let a = size - 2; a >= 0; a--) for (let b = size - 2; b >= 0; b--) best[a * size + b] = Math.max(best[a * size + b], best[(a + 1) * size + b], best[a * size + b + 1]);
  const higher = up ? size + 1 : size;
  let count = 0;
  for (let k = 0; k < rows.length; k++) {
    const i = rows[k];
    if (!(sign * place[i] < best[x(i) * size + y(i) + higher])) kept[count++] = i;
  }
  return kept.subarray(0, count);
}

/** The front of two or three outputs over the selected rows. `chosen()`: goals as [front] takes them. */
function frontFigure(state, chosen, found) {
  const frame = (width, height) => ({ left: 66, top: 10, width: width - 190, height: height - 56 });
  const place = (column, i, from, length) => from + (column.values[i] - column.domain[0]) / (column.domain[1] - column.domain[0]) * length;
  return new Figure({
    title: 'Pareto front', height: 400, ground: new Densities([LEVELS, LEVELS], GREY_RGB),
    paint(painter, width, height) {
      const goals = chosen(), [[a], [b], third] = goals, box = frame(width, height), rows = state.selection.picked;
      const best = this.best = front(rows, goals);
      found(best);
      axes(painter, box, { low: a.domain[0], high: a.domain[1], title: titled(a.label, a.unit) }, { low: b.domain[0], high: b.domain[1], title: titled(b.label, b.unit) });
      const at = (i) => [place(a, i, box.left, box.width), place(b, i, box.top + box.height, -box.height)];
      if (rows.length > SINGLE_ROWS) {
        const found = state.selection.levels;
        this.ground.fill(pointsOn(found.of(a), found.of(b)));
        painter.image(this.ground.show(), box.left, box.top, box.width, box.height);
      } else painter.dots(Array.from(rows).flatMap(at).filter(Number.isFinite), 2, { color: GREY, alpha: 0.8 });
      if (!third) {
        painter.dots(best.flatMap(at), 4, { color: ORANGE });
        return;
      }
      const [c] = third, part = (i) => (c.values[i] - c.domain[0]) / (c.domain[1] - c.domain[0]);
      for (const i of best) { painter.dots(at(i), 4.6, { color: INK }); painter.dots(at(i), 3.8, { color: ramp(part(i)) }); }
      const x = box.left + box.width + 28;
      for (let k = 0; k < 48; k++) painter.rect(x, box.top + box.height * (1 - (k + 1) / 48), 16, box.height / 48 + 0.5, { fill: ramp((k + 0.5) / 48) });
      painter.rect(x, box.top, 16, box.height, { stroke: SOFT });
      for (const [v, text] of zip(ticks(c.low, c.high, 6))) painter.text(text, x + 21, box.top + box.height * (1 - (v - c.domain[0]) / (c.domain[1] - c.domain[0])), { size: 10, color: SOFT });
      painter.text(wrapped(titled(c.label, c.unit), Math.floor(box.height / 5.9), 1)[0], x + 84, box.top + box.height / 2, { align: 'center', turned: true });
    },
    hover(x, y) {
      const goals = chosen(), [[a], [b]] = goals, box = frame(this.width, this.tall);
      let nearest = 100, row = -1;
      for (const i of this.best || []) {
        const dx = place(a, i, box.left, box.width) - x, dy = place(b, i, box.top + box.height, -box.height) - y;
        if (dx * dx + dy * dy < nearest) [nearest, row] = [dx * dx + dy * dy, i];
      }
      return row < 0 ? '' : state.describe(row, goals.map(([column]) => column));
    },
  });
}
