// Sliders over the factors, and two placements side by side.

/** The outputs that two placements are compared by: [name, unit, model, output, value], the goal and the limits first. */
function comparedOutputs(explorer) {
  const own = explorer.values.map((value) => ({ name: value.text, unit: value.unit, model: explorer.model, output: explorer.output(value), value }));
  const others = meta.answer?.found?.others, plain = (model) => model.outputs.filter((output) => model.has(output)).map((output) => ({ name: output.output, unit: output.unit, model, output, value: null }));
  if (!meta.answer?.found) return plain(explorer.model);
  return others ? [...own, ...plain(new PageModel(others, pageBytes))] : own;
}

/** A slider for each factor; uncertain ones may also be left to their distribution. `moved(factor)` is called when one moves. */
function sliders(explorer, place, moved) {
  const lines = explorer.factors.map((factor, k) => {
    const value = el('output', {}, ''), uncertain = explorer.uncertain.includes(k);
    const input = factor.nominal
      ? el('select', { 'aria-label': words(factor.name), onchange: () => { place()[k] = Number(input.value); moved(); } }, ...factor.names.map((name, code) => el('option', { value: String(code) }, name)))
      : el('input', { type: 'range', min: '0', max: '1', step: '0.002', 'aria-label': words(factor.name), oninput: () => { place()[k] = Number(input.value); moved(); } });
    const box = uncertain && el('input', { type: 'checkbox', checked: true, onchange: () => { explorer.pinned[box.checked ? 'delete' : 'add'](k); moved(); } });
    const show = () => {
      input.value = String(place()[k]);
      input.disabled = uncertain && box.checked;
      value.textContent = input.disabled ? '' : factor.text(place()[k]);
    };
    return { node: el('div', { class: 'slider' }, el('label', {}, el('span', {}, words(factor.name)), input), value, ...(uncertain ? [el('label', { class: 'all' }, box, 'over its distribution')] : [])), show };
  });
  return { node: el('div', { class: 'sliders' }, ...lines.map((line) => line.node)), show: () => lines.forEach((line) => line.show()) };
}

/** A difference with its sign, to three digits. */
function change(value, unit) { return withUnit(`${value > 0 ? '+' : ''}${value === 0 ? '0' : brief(Number(value.toPrecision(3)))}`, unit); }

/** The values of two placements and their difference. `chosen()`: the two places. */
function comparison(explorer, outputs, chosen, headings) {
  const holder = el('tbody', {}), head = el('tr', {});
  const cell = (found, { unit }) => `${withUnit(brief(found.mean), unit)} (${brief(found.low)} to ${brief(found.high)})`;
  const line = (of, [a, b]) => {
    const limit = of.value?.limit ?? null, name = nameOf({ text: of.name, unit: of.unit });
    const [p, q] = [a, b].map((place) => explorer.expected(of.output, translated(explorer, of.model, place), of.model));
    const mark = (place) => {
      if (limit === null) return '';
      return breaks(of.value, explorer.reached(of.value, place)) ? 'warn' : '';
    };
    const title = limit === null ? name : `${name}, limit ${brief(limit)}`;
    return el('tr', {}, el('th', { class: 'text', scope: 'row' }, title), el('td', { class: mark(a) }, cell(p, of)), el('td', { class: mark(b) }, cell(q, of)), el('td', {}, change(q.mean - p.mean, of.unit)));
  };
  const show = () => {
    const places = chosen(), limited = explorer.values.some(({ limit }) => limit !== null);
    const set = explorer.factors.map((factor, k) => el('tr', {}, el('th', { class: 'text', scope: 'row' }, words(factor.name)), ...places.map((place) => el('td', {}, explorer.free().some(([free]) => free === k) ? 'uncertain' : factor.text(place[k]))), el('td', {}, '')));
    const share = places.map((place) => explorer.held(place));
    const held = limited ? [el('tr', {}, el('th', { class: 'text', scope: 'row' }, 'runs that hold all limits, at least'), ...share.map((one) => el('td', { class: one < explorer.confidence ? 'warn' : '' }, `${one < 5e-5 ? '0' : brief(100 * one)} %`)), el('td', {}, ''))] : [];
    head.replaceChildren(el('th', { class: 'text' }, ''), ...headings().map((text) => el('th', {}, text)), el('th', {}, 'change'));
    holder.replaceChildren(...set, ...held, ...outputs.map((of) => line(of, places)));
  };
  return { node: el('div', { class: 'scroll' }, el('table', { id: 'compared' }, el('thead', {}, head), holder)), show };
}

/** A place of the explorer's factors in another model's. */
function translated(explorer, model, place) {
  if (model === explorer.model) return place;
  return Float64Array.from(model.factors, (factor) => {
    const own = explorer.factors.findIndex(({ name }) => name === factor.name);
    return own < 0 ? 0.5 : factor.scaled(explorer.factors[own].value(place[own]));
  });
}

/** Plan, contours, sliders and comparison of an explorer, in a section. `places`: the proposal, then the alternatives. */
function exploreInto(node, explorer, { places, effects, plan }) {
  const yours = Float64Array.from(places[0]), outputs = comparedOutputs(explorer);
  let [a, b] = mainAxes(explorer, effects), beside = places.length > 1 ? 1 : 0;
  const right = () => (beside ? places[beside] : yours), names = ['Placement B', ...places.slice(1).map((_, k) => `Alternative ${k + 1}`)];
  const shown = () => outputs.find(({ name }) => name === state.output?.name) ?? outputs[0];
  const marks = () => [[yours, 'B', BLUE], ...places.slice(1).map((place, k) => [place, String(k + 1), SOFT]), [places[0], 'A', ORANGE]];
  const contours = b === undefined ? null : contourFigure(state, explorer, () => {
    const { model, output, name } = shown();
    return { place: yours, axes: [a, b], output, model, column: state.table.named.get(name), marks: marks() };
  }, (at) => { yours.set(at); beside = 0; renew(); });
  const drawing = plan && planFigure(plan, explorer.factors, () => yours);
  const controls = sliders(explorer, () => yours, () => { beside = 0; renew(); });
  const table = comparison(explorer, outputs, () => [places[0], right()], () => [plan === undefined ? 'Placement A' : 'Proposal A', names[beside]]);
  const pickers = el('div', { class: 'controls' });
  const numbers = explorer.factors.map((factor, place) => [place, words(factor.name)]).filter(([place]) => !explorer.factors[place].nominal);
  const renew = () => {
    contours?.follow();
    controls.show();
    drawing?.redraw();
    const choose = choice('Compare A with', names.map((name, k) => [k, name]), beside, (value) => { beside = Number(value); renew(); });
    pickers.replaceChildren(choose, el('button', { type: 'button', onclick: () => { yours.set(places[0]); beside = 0; renew(); } }, 'set B to A'));
    clearTimeout(renew.waiting);
    renew.waiting = setTimeout(table.show, REST_MS);
  };
  const axisChoice = (label, value, set) => choice(label, numbers, value, (place) => { set(Number(place)); contours.rest(); });
  const legend = explorer.values.some(({ limit }) => limit !== null) ? 'Orange line: the limit. Hatched: a limit is violated. Pale: the model is uncertain. ' : '';
  const over = contours ? el('div', {}, contours.node, el('div', { class: 'controls' }, axisChoice('Across', a, (place) => { a = place; }), axisChoice('Up', b, (place) => { b = place; })),
    note(`${legend}Points: rows; strong points have similar other factors. Click to move B.`)) : '';
  node.append(el('div', { class: `pair ${drawing && contours ? '' : 'one'}` }, drawing ? el('div', {}, drawing.node, note(`A: the proposal.${places.length > 1 ? ' Numbers: alternatives.' : ''} B: the placement of the sliders.${plan.tracks.length ? ' Orange: where hammers can stand.' : ''}`)) : '', over),
    el('h3', {}, 'Two placements'), el('div', { class: 'pair narrow' }, el('div', {}, note('Set placement B: the model predicts its outputs. In brackets: range of 95 % of the runs, including the error of the model.'), controls.node), el('div', {}, pickers, table.node)));
  outputWatchers.push(() => contours?.rest());
  state.selection.watch(() => contours?.redraw());
  controls.show();
  pickers.replaceChildren();
  renew();
}
