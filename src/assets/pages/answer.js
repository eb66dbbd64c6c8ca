// The answer to the study's goal: in words, as a plan, over the factors, and beside other placements.

const VERDICTS = {
  proven: ['proven by runs', 'good'], refuted: ['not proven', 'bad'], unchecked: ['predicted, not yet run', 'open'],
  unsure: ['the models are not sure', 'open'], infeasible: ['limits out of reach', 'bad'],
};

/** The two factors of numbers that matter most to the goal and the limits: decisions first. */
function mainAxes(explorer, effects) {
  const most = (k) => Math.max(1e-300, ...effects.map(({ goal, limits }) => [goal, ...limits][k] ?? 0));
  const size = (effect) => [effect.goal, ...effect.limits].reduce((sum, one, k) => sum + one / most(k), 0);
  const known = explorer.factors.map((factor, place) => ({ place, factor, effect: effects.find((one) => one.factor === factor.name) }));
  const rank = ({ effect }) => (effect ? size(effect) + (effect.decision ? 1e6 : 0) : -1);
  return known.filter(({ factor }) => !factor.nominal && factor.range[1] > factor.range[0]).sort((p, q) => rank(q) - rank(p)).slice(0, 2).map(({ place }) => place);
}

/** The place of settings, the other factors in the middle of their ranges. */
function placeOf(explorer, settings) {
  return Float64Array.from(explorer.factors, (factor) => {
    const own = settings.find((one) => one.factor === factor.name);
    return own ? factor.scaled(own.value) : factor.nominal ? 0 : 0.5;
  });
}

/** The values to choose, the goal and the limits as tiles. */
function answerTiles(answer) {
  const tile = (value, text, kind = '') => el('div', { class: `tile ${kind}` }, el('b', {}, value), el('span', {}, text));
  const value = ({ value: of, unit }) => (typeof of === 'number' ? withUnit(brief(of), unit) : String(of));
  const limits = answer.limits.map((limit) => {
    const broken = limit.at_most ? limit.reached > limit.limit : limit.reached < limit.limit;
    return tile(withUnit(brief(limit.reached), limit.unit), `${nameOf(limit)} in ${brief(100 * answer.confidence)} % of runs, limit ${brief(limit.limit)}`, broken ? 'warn' : '');
  });
  const { goal, proof } = answer, name = nameOf(goal);
  return el('div', { class: 'tiles' }, ...answer.settings.map((setting) => tile(value(setting), words(setting.factor), 'choose')),
    tile(withUnit(brief(goal.mean), goal.unit), `${name}, ${brief(goal.low)} to ${brief(goal.high)} in 95 % of runs`), ...limits,
    ...(proof ? [tile(`${proof.held} of ${proof.runs}`, 'checks held all limits')] : []));
}

/** What else decore best prints, a line each. */
function answerTable(answer) {
  const unit = (value, k) => withUnit(brief(value), k ? answer.limits[k - 1].unit : answer.goal.unit);
  const named = (text) => nameOf({ text, unit: answer.limits.find((limit) => limit.text === text)?.unit ?? '' });
  const all = (settings) => settings.map((one) => `${words(one.factor)} ${typeof one.value === 'number' ? withUnit(brief(one.value), one.unit) : one.value}`).join(', ');
  const lines = [
    ...answer.alternatives.map((one, k) => [`Alternative ${k + 1}`, `${all(one.settings)}: ${[one.goal, ...one.reached].map(unit).join(', ')}, ${one.proof ? `held in ${one.proof.held} of ${one.proof.runs} runs` : 'predicted'}`]),
    ...answer.looser.map((one) => [`If ${named(one.text)} could reach ${brief(one.limit)}`, one.goal === null ? 'no place is within the limits' : `${unit(one.goal, 0)} with ${all(one.settings)}`]),
    ...[...answer.factors].sort((p, q) => q.goal - p.goal).map((one) => [`Effect of ${words(one.factor)}`, `${[one.goal, ...one.limits].map(unit).join(', ')} over ${one.decision ? 'a tenth of its range to either side' : 'its 5 % to 95 % points'}`]),
    ['Uncertainty of the goal', `${unit(answer.uncertainty.factors, 0)} by the uncertain factors, ${unit(answer.uncertainty.model, 0)} by the models, ${unit(answer.uncertainty.scatter, 0)} by scatter (standard deviations)`],
    ['To reduce it', answer.uncertainty.advice],
    ...answer.notes.map((text) => ['Note', text]),
  ];
  return el('table', { id: 'answer' }, el('tbody', {}, ...lines.map(([name, text]) => el('tr', { class: name.startsWith('Effect') ? 'more' : '' }, el('th', { class: 'text', scope: 'row' }, name), el('td', { class: 'text' }, text)))));
}

/** The section that begins the page; returns the explorer behind it, or null. */
function answerSection() {
  if (!meta.answer) return null;
  const { found, why } = meta.answer, node = el('section', { class: 'answer' });
  body.append(node);
  if (!found) { node.append(el('p', { class: 'lead' }, 'No answer yet'), note(why)); return null; }
  const { answer } = found, [verdict, kind] = VERDICTS[answer.verdict];
  node.append(el('p', { class: 'lead' }, el('span', { class: `verdict ${kind}` }, verdict), ' ', answer.sentence), answerTiles(answer));
  const explorer = new Explorer({ ...found, model: new PageModel(found.model, pageBytes), confidence: answer.confidence });
  const places = [answer.settings, ...answer.alternatives.map(({ settings }) => settings)].map((settings) => placeOf(explorer, settings));
  exploreInto(node, explorer, { places, effects: answer.factors, plan: found.plan });
  node.append(el('h3', {}, 'Behind the answer'), answerTable(answer));
  return explorer;
}

/** The models of a dataset without a goal: predictions over two factors and at two places. */
function exploreSection() {
  const { found } = meta.models;
  if (meta.answer?.found || !found || !found.model.outputs.some(({ process }) => process)) return;
  const model = new PageModel(found.model, pageBytes), output = Math.max(0, found.model.outputs.findIndex(({ process }) => process));
  const values = [{ text: found.model.outputs[output].output, unit: found.model.outputs[output].unit, output, smaller: false, limit: null }];
  const explorer = new Explorer({ model, values }), places = [placeOf(explorer, [])];
  const effects = factors.map((factor) => ({ factor: factor.subject, decision: true, goal: influence(factor, first), limits: [] }));
  const node = section('Model predictions', note('Expected values over two factors. Set the others with the sliders. Points are rows.'));
  exploreInto(node, explorer, { places, effects });
}
