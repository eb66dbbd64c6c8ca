// Shock spectra of two rows of a dataset.

/** The columns of each core point's spectrum by the point's name: [{ hz, column }]. */
function spectraColumns() {
  const found = new Map();
  for (const column of table.columns) {
    const named = column.group === 'core' && /(first_impact_)?pseudo_velocity_(\d+)hz_m_s$/.exec(column.name);
    if (!named || named[1]) continue;
    if (!found.has(column.subject)) found.set(column.subject, []);
    found.get(column.subject).push({ hz: Number(named[2]), column });
  }
  return found;
}

/** Shock spectra at the core points in two rows, at first in the best and the worst by the core point that gets least. */
function shockSection() {
  const cores = spectraColumns(), least = table.named.get('least_core_pseudo_velocity_98hz_10khz_m_s');
  if (!cores.size || !least?.count) return;
  const known = Array.from(least.values.keys()).filter((i) => Number.isFinite(least.values[i])).sort((i, j) => least.values[j] - least.values[i]);
  const names = [...cores.keys()], hz = cores.get(names[0]).map((one) => one.hz), holder = el('div', {});
  const rows = [known[0], known.at(-1)];
  let core = 'all', figure = null;
  const redraw = () => {
    const shown = names.filter((name) => core === 'all' || name === core);
    const curves = shown.flatMap((name) => rows.map((i, k) => ({
      name: `${name}, row ${state.row.values[i]}`, values: cores.get(name).map(({ column }) => column.values[i]), color: CURVES[names.indexOf(name) % CURVES.length], dash: DASHES[k],
    })));
    if (figure) figures.delete(figure);
    figure = shockPlot('Shock spectra of two rows', hz, curves);
    holder.replaceChildren(figure.node);
  };
  const field = (label, k) => {
    const input = el('input', { type: 'number', min: '0', step: '1', 'aria-label': label, value: String(state.row.values[rows[k]]), onchange: () => {
      const found = known.find((i) => state.row.values[i] === input.valueAsNumber);
      if (found === undefined) { input.value = String(state.row.values[rows[k]]); return; }
      rows[k] = found;
      redraw();
    } });
    return el('label', {}, label, input);
  };
  const which = names.length > 1 ? choice('Core point', [['all', 'all'], ...names.map((name) => [name, name])], core, (value) => { core = value; redraw(); }) : '';
  section('Shock at the core points', note(`${GRADES_TEXT} Full lines: the first row; broken ones: the second.`), el('div', { class: 'controls' }, field('Row', 0), field('Beside row', 1), which), holder);
  redraw();
}
