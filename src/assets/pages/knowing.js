// What is known beyond the rows: which factor matters, and how well models of the outputs predict.

/** Indices by what was computed: those that are drawn, first the one that factors are sorted by. */
const DRAWN_INDICES = { sobol: ['st', 's1'], morris: ['mu_star', 'sigma'], given: ['shapley', 'rank', 'correlation_ratio'] };
/** What indices are called. */
const INDEX_NAMES = {
  s1: 'S1 (alone)', st: 'ST (alone or with others)', s2: 'S2', mu_star: 'mu*', mu: 'mu', sigma: 'sigma', shapley: 'Shapley effect', rank: 'S1 by ranks',
  correlation_ratio: 'correlation ratio', pawn: 'PAWN', pawn_maximum: 'PAWN, largest', hsic_r2: 'R2-HSIC', hsic_p_value: 'p (HSIC)',
};
const indexColor = (k) => [BLUE, ORANGE][k];

/** The indices of one kind by factor; those of pairs are left out. */
function byFactor(output, kind) {
  return new Map(output.indices.filter((one) => one.index === kind && one.factors.length === 1).map((one) => [one.factors[0], one]));
}

/** Indices of an output's factors with their intervals, side by side. `chosen()`: the output and the kinds. */
function indexFigure(chosen) {
  // Names of many factors stand upright.
  const turned = (width, names) => (width - 72) / names.length < 60;
  const frame = (width, height) => ({ left: 60, top: 8, width: width - 72, height: height - 52 - (turned(width, parts().names) ? UPRIGHT : 0) });
  const parts = () => {
    const { output, kinds } = chosen(), all = kinds.map((kind) => byFactor(output, kind));
    const names = [...all[0].keys()].sort((a, b) => (all[0].get(b).value ?? -1) - (all[0].get(a).value ?? -1));
    return { output, kinds, all, names };
  };
  return new Figure({
    title: 'Which factor matters', height: (width) => 260 + (turned(width, parts().names) ? UPRIGHT : 0),
    paint(painter, width, height) {
      const { output, kinds, all, names } = parts(), box = frame(width, height);
      const ends = all.flatMap((of) => [...of.values()]).flatMap((one) => [one.value, ...(one.interval || [])]).filter(Number.isFinite);
      const inUnit = kinds[0] === 'mu_star', title = inUnit ? titled('effect over the range', output.unit) : 'share of the variance';
      const low = Math.min(0, ...ends), high = inUnit ? Math.max(1e-12, ...ends) : Math.max(1, ...ends);
      const { py } = axes(painter, box, { low: -0.5, high: names.length - 0.5, names, turned: turned(width, names), title: 'factor' }, { low, high: high + 0.05 * (high - low), title });
      const room = box.width / names.length, bar = Math.min(26, 0.36 * room);
      names.forEach((name, at) => all.forEach((of, k) => {
        const one = of.get(name);
        if (!one || one.value === null) return;
        const x = box.left + (at + 0.5) * room + (k - (all.length - 1) / 2) * (bar + 3), [top, bottom] = [py(Math.max(one.value, 0)), py(Math.min(one.value, 0))];
        painter.rect(x - bar / 2, top, bar, Math.max(1, bottom - top), { fill: indexColor(k), alpha: 0.8 });
        if (one.interval) painter.line([x, py(one.interval[0]), x, py(one.interval[1])], { color: INK, width: 1.5 });
      }));
      kinds.forEach((kind, k) => painter.text(INDEX_NAMES[kind], box.left + box.width, box.top + 12 + 15 * k, { align: 'right', color: indexColor(k), halo: true }));
    },
    hover(x) {
      const { kinds, all, names, output } = parts(), box = frame(this.width, this.tall);
      const name = names[Math.floor((x - box.left) / box.width * names.length)];
      if (name === undefined) return '';
      const unit = kinds[0] === 'mu_star' ? output.unit : '';
      return [name, ...kinds.map((kind, k) => all[k].get(name) && `${INDEX_NAMES[kind]}: ${withUnit(estimate(all[k].get(name)), unit)}`).filter(Boolean)].join('\n');
    },
  });
}

/** What an output is called, as elsewhere on the page. */
function labelled({ output, unit }) { return titled(table.named.get(output)?.label ?? output, unit); }

/** A value with its interval. */
function estimate({ value, interval }) {
  return value === null ? 'none' : `${short(value)}${interval ? ` [${interval.map(short).join(', ')}]` : ''}`;
}

/** Every index of an output, a line for each factor or pair. */
function indexTable(output) {
  const kinds = Object.keys(INDEX_NAMES).filter((kind) => output.indices.some((one) => one.index === kind));
  const lines = new Map();
  for (const one of output.indices) {
    const name = one.factors.join(' x ');
    if (!lines.has(name)) lines.set(name, new Map());
    lines.get(name).set(one.index, one);
  }
  const heading = [el('th', { class: 'text' }, 'factor'), ...kinds.map((kind) => el('th', {}, INDEX_NAMES[kind]))];
  const row = ([name, of]) => el('tr', {}, el('td', { class: 'text' }, name), ...kinds.map((kind) => el('td', {}, of.has(kind) ? estimate(of.get(kind)) : '')));
  return el('div', { class: 'scroll' }, el('table', {}, el('thead', {}, el('tr', {}, ...heading)), el('tbody', {}, ...[...lines].map(row))));
}

/** The rows that went into an output's indices, and why others did not. */
function usedWords({ used, refused, notes }) {
  const without = used.left_out.map((one) => `${one.count} ${one.reason}`).join('; ');
  return `${refused ? `${refused[0].toUpperCase()}${refused.slice(1)}. ` : ''}From ${used.whole} of ${used.of} ${used.unit}${without ? ` (left out: ${without})` : ''}.${notes.map((one) => ` Note: ${one}.`).join('')}`;
}

function sensitivitySection() {
  if (table.rows < 2 || !factors.length) return;
  const { found, why } = meta.sensitivity;
  if (!found) { section('Which factor matters', note(why)); return; }
  const kinds = DRAWN_INDICES[found.method.name], usual = found.outputs.find((one) => !one.refused);
  const chosen = () => found.outputs.find((one) => one.output === state.output?.name);
  let output = chosen() ?? usual;
  if (!usual) { section('Which factor matters', ...found.outputs.map((one) => note(`${labelled(one)}: ${usedWords(one)}`))); return; }
  const figure = indexFigure(() => ({ output, kinds: kinds.filter((kind) => output.indices.some((one) => one.index === kind)).slice(0, 2) }));
  const words = note(''), holder = el('div', {});
  const { replicates, level } = found.intervals, origin = { sobol: `Sobol' indices from a Saltelli design (estimator ${found.method.estimator})`, morris: 'Elementary effects from Morris trajectories', given: 'Indices of any rows' }[found.method.name];
  const renew = () => {
    output = chosen() ?? usual;
    words.textContent = `${labelled(output)}. ${output.description} ${usedWords(output)}${chosen() ? '' : ' The chosen output has no indices here: run decore analyse with --output.'}`;
    figure.node.hidden = Boolean(output.refused);
    holder.replaceChildren(...(output.refused ? [] : [indexTable(output)]));
    if (!output.refused) figure.redraw();
  };
  section('Which factor matters', note(`${origin}, for all rows, not only the selected ones. Lines and brackets: ${100 * level} % intervals${replicates ? '' : ' (none)'}. As printed by decore analyse.`), ...found.notes.map(note),
    words, figure.node, holder);
  outputWatchers.push(renew);
  renew();
}

function modelsSection() {
  if (table.rows < 2 || !factors.length) return;
  const { found, why } = meta.models, title = 'Models of the outputs';
  if (!found) { section(title, note(why)); return; }
  const { surrogate, warnings } = found;
  const cells = (output) => {
    const { process, chaos } = output;
    if (!process) return [el('td', { class: 'text', colspan: 6 }, output.refused || 'no model')];
    const success = output.success ? `${short(100 * output.success.share)} %` : 'all';
    return [short(Math.min(process.q2, process.q2_folds ?? process.q2)), chaos ? short(chaos.q2) : '', withUnit(short(process.rms_error), output.unit), withUnit(short(process.noise_std_dev), output.unit), output.twin_scatter === null ? '' : withUnit(short(output.twin_scatter), output.unit), success].map((text) => el('td', {}, text));
  };
  const heading = ['rows', 'Q2', 'Q2, polynomial', 'error of a new row', 'noise', 'scatter of twins', 'rows that have it'];
  const lines = surrogate.outputs.map((output) => el('tr', {}, el('td', { class: 'text', title: output.description }, labelled(output)), el('td', {}, String(output.used)), ...cells(output)));
  section(title, note('Gaussian processes of the outputs over all factors, as in decore surrogate. Q2: share of the variance that is predicted for left-out rows. Error: root mean square error of left-out rows.'), ...surrogate.notes.map(note), ...warnings.map(note),
    el('div', { class: 'scroll' }, el('table', { id: 'models' }, el('thead', {}, el('tr', {}, el('th', { class: 'text' }, 'output'), ...heading.map((text) => el('th', {}, text)))), el('tbody', {}, ...lines))));
}
