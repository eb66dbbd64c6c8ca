// What factors do: failures, main effects, fronts.

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
      const x = names ? { low: -0.5, high: group.count - 0.5, names } : { low: factor.low, high: factor.high, log: factor.log };
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
  const xs = (one) => (factor.names || one.count === 1 ? { low: -0.5, high: one.count - 0.5 } : { low: factor.domain[0], high: factor.domain[1], log: factor.log });
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
      const v = valueAt({ log: axis.log, domain: [axis.low, axis.high] }, (x - box.left) / box.width);
      const at = one.names || one.count > 1 ? one.centres : [0];
      let g = 0;
      at.forEach((centre, k) => { if (Math.abs(centre - v) < Math.abs(at[g] - v)) g = k; });
      if (!one.counts[g]) return '';
      const where = factor.names ? factor.names[g] : withUnit(short(one.centres[g]), factor.unit);
      return `${factor.label} ${where}\n${output.label}: ${withUnit(short(one.means[g]), output.unit)} ± ${short(one.error(g))} (standard error of the mean, ${one.counts[g]} rows)`;
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
  const place = (column, i, from, length) => from + scaled(column)(column.values[i]) * length;
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
      const [c] = third, part = (i) => scaled(c)(c.values[i]);
      for (const i of best) { painter.dots(at(i), 4.6, { color: INK }); painter.dots(at(i), 3.8, { color: ramp(part(i)) }); }
      scaleBar(painter, box, c.domain, titled(c.label, c.unit));
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
