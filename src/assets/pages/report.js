// The page of a dataset: sections, the reader's choices, the rows.

const table = readTable(meta);
const selection = new Selection(table);
const isOutput = (column) => !column.names && ['hammer', 'casting', 'aggregate', 'run'].includes(column.group);
// Of one row all factors and outputs are of interest; of more, those that differ.
const factors = table.columns.filter((column) => column.group === 'factor' && (column.varies || column.names?.length > 1 || table.rows === 1));
const outputs = table.columns.filter((column) => isOutput(column) && (column.varies || (table.rows === 1 && column.count)));
const main = [...outputs].filter((column) => column.rank >= 0).sort((a, b) => a.rank - b.rank);
const first = main[0] || outputs[0];
const state = {
  table, selection, shown: [], row: table.named.get('row'), status: table.named.get('status'), reason: table.named.get('reason'),
  /** What hovering over a row tells. */
  describe(row, columns = this.shown) {
    const lines = columns.slice(0, 14).map((column) => `${column.label}: ${withUnit(readable(column, row), column.unit)}`);
    return [`row ${this.row.values[row]}`, ...lines].join('\n');
  },
  /** The output that colours rows, is modelled, explained and sorted by. */
  output: first,
  /** The colour of a row, by the chosen output. */
  color(row) {
    const { output } = this, part = output ? (output.values[row] - output.low) / (output.high - output.low || 1) : NaN;
    return part === part ? SHADES[Math.round(part * (SHADES.length - 1))] : GREY;
  },
  /** The selected rows by their colours, as one Map. */
  byColor() {
    const found = new Kept(() => []);
    for (const row of selection.picked) found.of(this.color(row)).push(row);
    return found;
  },
};
/** Colours of rows: few, so that those alike are drawn together. */
const SHADES = Array.from({ length: 24 }, (_, k) => ramp(k / 23));
/** Called when another output is chosen. */
const outputWatchers = [];

/** Factors by what they do to the first output, most first; the study's order among equals. */
function leading() {
  if (!first) return factors;
  const shares = new Map(factors.map((factor) => [factor, influence(factor, first)]));
  return [...factors].sort((a, b) => shares.get(b) - shares.get(a));
}

const ordered = leading();
state.shown = [...factors.filter((factor) => ordered.indexOf(factor) < 6), ...(main.length ? main : outputs).slice(0, 6)];

function head() {
  const done = meta.statuses.done || 0, tile = (value, words, kind = '') => el('div', { class: `tile ${kind}` }, el('b', {}, value), el('span', {}, words));
  const others = Object.entries(meta.statuses).filter(([status]) => status !== 'done');
  const tiles = [tile(`${meta.rows_there} of ${meta.rows}`, 'rows are there'), tile(String(done), 'done'), ...others.map(([status, count]) => tile(String(count), status.replaceAll('_', ' '), 'warn')), tile(String(meta.blows), 'blows')];
  if (meta.worst_residual !== null) tiles.push(tile(`${short(100 * meta.worst_residual)} %`, 'largest energy residual'));
  if (!meta.answer) body.append(el('h1', {}, meta.title));
  else body.append(el('h2', {}, 'Rows'));
  body.append(el('p', { class: 'soft' }, `Study ${meta.study_hash.slice(0, 12)}, seed ${meta.seed}, decore ${meta.version}`), el('div', { class: 'tiles' }, ...tiles));
  for (const text of meta.notes) body.append(note(text));
}

/** The bar that stays in sight: how many rows are selected, the limits, a form for a new one. */
function limitBar() {
  const count = el('span', { class: 'count', role: 'status' }), chips = el('span', { class: 'controls' });
  const column = choice('Limit', [...factors, ...outputs].map((one) => [one.index, one.label]), (main[0] || outputs[0] || factors[0])?.index, () => {}).querySelector('select');
  const add = () => {
    const one = table.columns[Number(column.value)];
    // A limit that is there stays as it is.
    if (one && !selection.limits.has(one)) selection.set([[one, one.names ? new Set(one.names.keys()) : { low: one.low, high: one.high }]]);
  };
  const form = el('form', { class: 'controls', onsubmit: (event) => { event.preventDefault(); add(); } }, el('label', {}, 'Limit', column), el('button', {}, 'add'));
  const output = outputs.length ? choice('Output', outputs.map((one) => [one.index, titled(one.label, one.unit)]), state.output.index, (value) => { state.output = table.columns[value]; outputWatchers.forEach((changed) => changed()); }) : '';
  if (output) output.title = 'Colours rows and models. Effects, indices and the list of rows begin with this output.';
  const bar = el('div', { class: 'bar' }, el('span', { class: 'controls' }, output), count, chips, form, el('button', { type: 'button', onclick: () => selection.clear() }, 'clear all'));
  const show = () => {
    count.textContent = `${selection.picked.length} of ${table.rows} rows selected`;
    if (!chips.contains(document.activeElement)) chips.replaceChildren(...[...selection.limits].map(([one, limit]) => chip(one, limit)));
  };
  chips.addEventListener('focusout', () => setTimeout(show));
  selection.watch(show);
  body.append(bar);
  show();
}

function chip(column, limit) {
  const node = el('span', { class: 'chip' }, `${titled(column.label, column.unit)} `);
  if (column.columns) {
    node.append('brushed ');
  } else if (limit instanceof Set) {
    for (const [code, name] of column.names.entries()) {
      const box = el('input', { type: 'checkbox', checked: limit.has(code), onchange: () => {
        if (box.checked) limit.add(code); else limit.delete(code);
        selection.set([[column, limit]]);
      } });
      box.style.width = 'auto';
      node.append(el('label', {}, box, name));
    }
  } else {
    for (const end of ['low', 'high']) {
      const field = el('input', { type: 'number', step: 'any', 'aria-label': `${column.label}, ${end === 'low' ? 'least' : 'largest'}`, value: String(Number(limit[end].toPrecision(5))), onchange: () => {
        if (Number.isFinite(field.valueAsNumber)) selection.set([[column, { ...selection.limits.get(column), [end]: field.valueAsNumber }]]);
      } });
      node.append(field, end === 'low' ? ' to ' : '');
    }
  }
  node.append(el('button', { type: 'button', 'aria-label': `Remove the limit of ${column.label}`, onclick: (event) => { event.currentTarget.blur(); selection.set([[column, null]]); } }, '×'));
  return node;
}

/** The linked views and the choice of their columns; returns the views. */
function linkedViews() {
  if (!state.shown.length || table.rows < 2) {
    section('All rows', el('p', {}, 'These views need at least two rows that differ.'));
    return [];
  }
  const parallel = new Parallel(state), matrix = new Matrix(state), grid = el('div', { class: 'grid' });
  const watched = new Set();
  const choose = () => {
    const some = state.shown.filter((column) => column.group === 'factor').sort((a, b) => ordered.indexOf(a) - ordered.indexOf(b)).slice(0, 3);
    for (const figure of watched) figures.delete(figure);
    watched.clear();
    for (const column of state.shown) watched.add(distribution(state, column));
    grid.replaceChildren(...[...watched].map((figure) => figure.node));
    parallel.renew();
    matrix.renew([...some, ...state.shown.filter((column) => column.group !== 'factor')].slice(0, 6));
  };
  const boxes = el('div', { class: 'choice' });
  for (const [group, title] of [['factor', 'Factors'], ['aggregate', 'Over all hammers and castings'], ['run', 'Run'], ['hammer', 'Hammers'], ['casting', 'Castings'], ['row', 'Row'], ['solver', 'Solver']]) {
    const members = table.columns.filter((column) => column.group === group);
    if (members.length) boxes.append(el('b', {}, title));
    for (const column of members) {
      const box = el('input', { type: 'checkbox', checked: state.shown.includes(column), onchange: () => {
        state.shown = table.columns.filter((other) => (other === column ? box.checked : state.shown.includes(other)));
        choose();
        rows();
      } });
      boxes.append(el('label', { title: `${column.name}: ${column.text}` }, box, titled(column.label, column.unit)));
    }
  }
  section('All rows', note('Drag along an axis or over a panel to select rows; click there to cancel the selection. All plots and the list of rows follow. Colours: the chosen output, from low (dark) to high (light).'),
    el('details', { class: 'choices' }, el('summary', {}, `Columns (${table.columns.length})`), boxes), parallel.figure.node);
  section('Distributions', note('Grey: all rows. Blue: the selected ones.'), grid);
  section('Pairs of columns', note('Below the diagonal: rows over two columns. Above it: correlation of the selected rows.'), matrix.figure.node);
  choose();
  outputWatchers.push(() => { parallel.figure.redraw(); matrix.figure.redraw(); });
  selection.watch(() => { parallel.figure.redraw(); matrix.figure.redraw(); watched.forEach((figure) => figure.redraw()); });
  return [parallel, matrix];
}

let rows = () => {};

/** The selected rows, sorted; the best under the reader's limits are the first. */
function rowList() {
  let by = state.output || state.row, falling = !by.smaller, most = 20;
  outputWatchers.push(() => { by = state.output; falling = !by.smaller; rows(); });
  const holder = el('div', { class: 'scroll' });
  const study = el('input', { value: 'STUDY.toml', 'aria-label': 'study file' });
  const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;
  /** Order of two rows: missing values come last, equal ones in the order of the table. */
  const order = () => {
    const { values } = by, sign = falling ? -1 : 1;
    return (p, q) => {
      const a = values[p], b = values[q];
      return a !== a || b !== b ? (a !== a) - (b !== b) || p - q : sign * (a - b) || p - q;
    };
  };
  const sorted = () => Array.from(selection.picked).sort(order());
  const columns = () => [state.row, state.status, ...state.shown.filter((column) => ![state.row, state.status].includes(column))];
  const csv = () => {
    const cell = (text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    return [columns().map((column) => column.name), ...sorted().map((i) => columns().map((column) => exact(column, i)))].map((line) => line.map(cell).join(',')).join('\n') + '\n';
  };
  const commands = () => sorted().map((i) => [`decore scene ${quoted(study.value)} --row ${state.row.values[i]}`, ...meta.overrides.map((one) => `--set ${quoted(one)}`)].join(' ')).join('\n') + '\n';
  rows = () => {
    const header = columns().map((column) => el('th', { title: column.text, 'aria-sort': column === by ? (falling ? 'descending' : 'ascending') : 'none' }, el('button', { type: 'button', onclick: () => { falling = column === by ? !falling : !column.smaller; by = column; rows(); } }, `${titled(column.label, column.unit)}${column === by ? (falling ? ' ▾' : ' ▴') : ''}`)));
    const lines = leastOf(selection.picked, order(), most).map((i) => el('tr', {}, ...columns().map((column) => el('td', { class: column.names ? 'text' : '', title: exact(column, i) }, readable(column, i)))));
    holder.replaceChildren(el('table', { id: 'rows' }, el('thead', {}, el('tr', {}, ...header)), el('tbody', {}, ...lines)));
  };
  const button = (text, make) => el('button', { type: 'button', onclick: (event) => copy(make(), event.currentTarget) }, text);
  section('Best rows', note('The selected rows, sorted by the marked column. Click a heading to sort by its column.'),
    el('div', { class: 'controls' }, choice('Rows shown', [[20, '20'], [100, '100'], [500, '500']], most, (value) => { most = Number(value); rows(); }), button('Copy as CSV', csv), button('Copy the commands to run them again', commands), el('label', {}, 'of study file', study)), holder);
  // Sorting a large table waits until the plots have followed a brush.
  let waiting = 0;
  selection.watch(() => { clearTimeout(waiting); waiting = setTimeout(rows, 120); });
  rows();
}

/** Most factors over which failures and main effects are drawn. */
const MOST_FAILURES = 12, MOST_EFFECTS = 24;

/** Says how many factors are not among those that are drawn. */
function leftOut(drawn) {
  const count = ordered.length - drawn.length;
  return drawn.length && count > 0 ? [note(`The figure shows the ${drawn.length} factors with the largest effect on ${first ? first.label : 'the outputs'}; ${count} more are hidden.`)] : [];
}

function failures() {
  const failed = meta.reasons.reduce((sum, [, count]) => sum + count, 0), coming = meta.rows - meta.rows_there;
  const left = coming > 0 ? [el('p', {}, `${coming} of ${meta.rows} rows are still to come.`)] : [];
  if (!failed) {
    section('Rows that are not done', ...left, el('p', {}, coming > 0 ? `All ${meta.rows_there} existing rows are done.` : 'All rows are done.'));
    return;
  }
  const lines = meta.reasons.map(([reason, count]) => el('tr', {}, el('td', {}, String(count)), el('td', { class: 'text' }, reason)));
  const counts = new Map();
  state.status.values.forEach((status, i) => { if (state.status.names[status] !== 'done') counts.set(state.reason.values[i], (counts.get(state.reason.values[i]) || 0) + 1); });
  const reasons = [...counts].sort((a, b) => b[1] - a[1]).map(([code]) => code).slice(0, REASON_COLORS.length);
  const drawn = table.rows > 1 ? ordered.slice(0, MOST_FAILURES) : [];
  section('Rows that are not done', ...left, el('table', {}, el('tr', {}, el('th', {}, 'rows'), el('th', { class: 'text' }, 'reason (figures of single rows as …)')), ...lines),
    ...leftOut(drawn), el('div', { class: 'grid' }, ...drawn.map((factor) => failureFigure(state, factor, reasons).node)));
}

/** What is known of how far an output is off in one row: columns beside it of its scatter between twins and its standard error. */
function besides(output) {
  const names = [`${output.name}_scatter`, output.name.replace(/_([a-z]+|m_s|n_s)$/, '_error_$1')];
  const columns = names.map((name) => table.named.get(name)).filter((column) => column && column !== output && column.count);
  const { mean, deviation } = moments(output, selection.picked);
  return [
    `All selected rows: mean ${withUnit(short(mean), output.unit)}, standard deviation ${withUnit(short(deviation), output.unit)}.`,
    ...columns.map((column) => `${column.label} of single rows: mean ${withUnit(short(moments(column, selection.picked).mean), column.unit)}, largest ${short(column.high)}.`),
  ];
}

function effectsSection() {
  if (!factors.length || !first || table.rows < 2) return;
  const drawn = ordered.slice(0, MOST_EFFECTS);
  let cache = null;
  const scatter = note('');
  const tell = () => { scatter.textContent = ['Means of the selected rows in groups of each factor; bars: standard error of the mean.', ...besides(state.output)].join(' '); };
  const effects = () => {
    if (cache) return cache;
    const { output } = state;
    const of = new Map(drawn.map((factor) => [factor, effect(factor, output, selection.picked)]));
    let [low, high] = [Infinity, -Infinity];
    for (const one of of.values()) one.means.forEach((m, g) => { if (one.counts[g]) [low, high] = [Math.min(low, m - one.error(g)), Math.max(high, m + one.error(g))]; });
    const pad = (high - low) * 0.06 || Math.abs(high) * 0.05 || 1;
    cache = { output, of, range: low <= high ? [low - pad, high + pad] : [0, 1] };
    return cache;
  };
  const all = drawn.map((factor) => effectFigure(state, factor, effects));
  const renew = () => { cache = null; tell(); all.forEach((figure) => figure.redraw()); };
  section('Main effects', scatter, ...leftOut(drawn), el('div', { class: 'grid' }, ...all.map((figure) => figure.node)));
  outputWatchers.push(renew);
  selection.watch(renew);
  tell();
}

function fronts() {
  const candidates = main.length > 1 ? main : outputs;
  if (candidates.length < 2 || table.rows < 2) return;
  const other = candidates.find((column) => column.smaller !== candidates[0].smaller) || candidates[1];
  const goals = [candidates[0], other, null].map((column) => ({ column, sign: column?.smaller ? -1 : 1 }));
  const found = note('');
  const figure = frontFigure(state, () => goals.filter((goal) => goal.column).map((goal) => [goal.column, goal.sign]), (best) => { found.textContent = `${best.length} rows that no other selected row beats in all goals: ${best.slice(0, 30).map((i) => state.row.values[i]).join(', ')}${best.length > 30 ? ' …' : ''}`; });
  const controls = goals.map((goal, k) => {
    const sign = choice('', [[1, 'large'], [-1, 'small']], goal.sign, (value) => { goal.sign = Number(value); figure.redraw(); });
    const options = [...(k === 2 ? [['', '(none)']] : []), ...outputs.map((column) => [column.index, column.label])];
    const column = choice(`Goal ${k + 1}`, options, goal.column ? goal.column.index : '', (value) => { goal.column = value === '' ? null : table.columns[value]; figure.redraw(); });
    return el('span', { class: 'controls' }, column, sign);
  });
  section('Pareto front', el('div', { class: 'controls' }, ...controls), figure.node, found);
  selection.watch(() => figure.redraw());
}

function ending() {
  const residual = table.named.get('energy_residual');
  provenance(meta, ...(residual?.count ? [distribution(state, residual).node, note(residual.text)] : []));
}

if (meta.answer) {
  body.append(el('h1', {}, meta.title));
  answerSection();
}
head();
limitBar();
const linked = linkedViews();
figures.forEach((figure) => { if (figure.node.getBoundingClientRect().top < innerHeight) figure.draw(); });
performance.mark('decore-drawn');
// What is below comes when the reader has something to see.
setTimeout(() => {
  rowList();
  failures();
  exploreSection();
  effectsSection();
  sensitivitySection();
  modelsSection();
  fronts();
  shockSection();
  ending();
  performance.mark('decore-whole');
  // What lies under a selection is made ready before the first one.
  requestIdleCallback(() => { if (table.rows > SINGLE_ROWS) linked.forEach((view) => view.prepare()); });
});
