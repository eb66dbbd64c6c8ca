// The page of a row: player, mechanism, plots, blows, spectra, outputs.

/** Slow motion that can be chosen: simulated seconds a second. */
const SPEEDS = [[0.001, '1/1000'], [0.002, '1/500'], [0.005, '1/200'], [0.01, '1/100'], [0.02, '1/50'], [0.05, '1/20'], [0.1, '1/10'], [0.5, '1/2'], [1, 'real time']];
/** Time before a blow to which jumps go, s. */
const BEFORE_BLOW = 0.0005;
/** Rows up to which a table is not folded. */
const SHORT_TABLE = 12;

/** Plays the mechanism: moves the view's time while the reader watches. */
class Player {
  constructor(view, blows) {
    Object.assign(this, { view, blows, speed: 0.01, playing: false, frames: 0 });
    this.button = el('button', { type: 'button', onclick: () => this.toggle() }, 'Play');
    this.slider = el('input', { type: 'range', min: '0', max: String(view.end), step: 'any', 'aria-label': 'Time', oninput: () => view.seek(this.slider.valueAsNumber) });
    this.clock = el('span', { class: 'count', role: 'timer' });
    view.watch(() => {}, () => this.show());
    this.show();
  }
  show() {
    this.slider.value = String(this.view.now);
    this.clock.textContent = timeText(this.view.now);
  }
  toggle() {
    this.playing = !this.playing;
    this.button.textContent = this.playing ? 'Pause' : 'Play';
    if (!this.playing) return;
    if (this.view.now >= this.view.end) this.view.seek(0);
    let last = performance.now();
    const frame = (clock) => {
      if (!this.playing) return;
      // A page that was out of sight does not leap.
      this.view.seek(this.view.now + this.speed * Math.max(0, Math.min(100, clock - last)) / 1000);
      last = clock;
      this.frames++;
      if (this.view.now >= this.view.end) this.toggle();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
  /** To shortly before the next blow, or the one before. */
  jump(forward) {
    const starts = this.blows.map((blow) => Math.max(0, blow.start_s - BEFORE_BLOW)), { now } = this.view, least = 1e-6;
    const to = forward ? starts.find((start) => start > now + least) : starts.findLast((start) => start < now - least);
    if (to !== undefined) this.view.seek(to);
  }
}

function sceneHead(meta) {
  const tile = (value, text, kind = '') => el('div', { class: `tile ${kind}` }, el('b', {}, value), el('span', {}, text));
  const output = (of, name) => meta.outputs.find((one) => one.of === of && one.name === name)?.value;
  const tiles = [tile(words(meta.status), 'status', meta.status === 'done' ? '' : 'warn'), tile(`${meta.blows.length}`, 'blows')];
  const number = (text) => short(Number(text));
  for (const { name } of meta.hammers) {
    const of = `hammer ${name}`, energy = output(of, 'periodic_energy_mean_j'), rate = output(of, 'hit_frequency_hz');
    if (energy && rate) tiles.push(tile(`${number(energy)} J, ${number(rate)} Hz`, `${name}: periodic blows`));
  }
  const work = output('run', 'delivered_work_j'), residual = output('run', 'energy_residual');
  if (work) tiles.push(tile(`${number(work)} J`, 'work on castings'));
  if (residual) tiles.push(tile(`${short(100 * Math.abs(Number(residual)))} %`, 'energy residual'));
  body.append(el('h1', {}, meta.title), el('p', { class: 'soft' }, `Study ${meta.study_hash.slice(0, 12)}, seed ${meta.seed}, decore ${meta.version}`), el('div', { class: 'tiles' }, ...tiles));
  if (meta.reason) body.append(el('p', {}, meta.reason));
  const factors = meta.factors.map(([name, value, unit]) => `${name} = ${withUnit(value, unit)}`);
  if (factors.length) body.append(el('p', {}, factors.join(', ')));
}

/** What the plots show: title, unit and factor from SI, [name, quantity] of each hammer, a quantity of castings, fixtures or points, or `run` of the run. */
const PLOTS = [
  { title: 'Velocity of the arm at the mount', unit: 'mm/s', scale: 1e3, hammer: [['arm', 'arm_velocity_m_s']] },
  { title: 'Velocity of further points of the machine', unit: 'mm/s', scale: 1e3, points: 'velocity_m_s' },
  { title: 'Velocity of the chisel', unit: 'm/s', hammer: [['chisel', 'chisel_velocity_m_s']] },
  { title: 'Velocity of the casting at the strike point, and blows', unit: 'm/s', hammer: [['casting', 'casting_velocity_m_s']], blows: true },
  { title: 'Acceleration of the casting’s centre of mass', unit: 'm/s²', castings: 'heave_acceleration_m_s2' },
  { title: 'Positions: telescope, piston and chisel in the cylinder', unit: 'mm', scale: 1e3, hammer: [['telescope', 'extension_m'], ['piston', 'piston_m'], ['chisel', 'chisel_m']] },
  { title: 'Position of the spool in the cylinder', unit: 'mm', scale: 1e3, hammer: [['spool', 'spool_m']] },
  { title: 'Pressures in the chambers, absolute', unit: 'bar', scale: 1e-5, hammer: [['telescope, top (P1)', 'pressure_top_pa'], ['telescope, annulus (P2)', 'pressure_annulus_pa'], ['behind the piston (P3)', 'pressure_rear_pa'], ['before the piston (P4)', 'pressure_front_pa']] },
  { title: 'Forces of blows', unit: 'kN', scale: 1e-3, hammer: [['chisel on casting', 'casting_force_n'], ['piston on chisel', 'percussion_force_n']] },
  { title: 'Forces of stops', unit: 'kN', scale: 1e-3, hammer: [['nose', 'nose_force_n'], ['retainer', 'retainer_force_n'], ['rear wall', 'rear_wall_force_n'], ['telescope, top', 'top_stop_force_n'], ['telescope, end', 'end_stop_force_n'], ['spool, rear', 'spool_rear_force_n'], ['spool, front', 'spool_front_force_n']] },
  { title: 'Force on the mount', unit: 'kN', scale: 1e-3, hammer: [['mount', 'mount_force_n']] },
  { title: 'Forces of the fixtures on the machine', unit: 'kN', scale: 1e-3, fixtures: 'force_n', lifted: true },
  { title: 'Energy balance', unit: 'J', run: [['work put in', 'work_put_in_j'], ['stored', 'stored_energy_j'], ['dissipated', 'dissipated_energy_j']] },
  { title: 'Energy error: supplied work minus stored and dissipated energy', unit: 'J', run: [['unaccounted', 'energy_unaccounted_j']] },
];

/** What the views of the castings in place show and what they leave out. */
const PLACE_NOTE = 'From the side, lengths are to scale, and motion from rest is exaggerated by the factor shown: tilt, displacement, and for elastic castings bending, drawn through the points that have signals. The dashed outline is the casting at rest. Pads that carry nothing are orange. The heights of rigid castings, fixtures and hammers are schematic.';

/** Colour of what was measured: of no hammer and no quantity. */
const MEASURED = '#7b8692';

/** Measured curves of a signal, named by their channels. */
const measuredOf = (signals, of, quantity) => signals.measured(of, quantity).map(({ name, trace }) => ({ name: `measured: ${name}`, trace, color: MEASURED, dash: [2, 2] }));

/** The curves of a plot for the hammers that are shown: of one each quantity has its colour, of several each hammer. */
function curvesOf(meta, signals, plot, shown) {
  const color = (k) => CURVES[k % CURVES.length], dash = (k) => DASHES[k % DASHES.length];
  if (plot.run) return plot.run.map(([name, quantity], k) => ({ name, trace: signals.run(quantity), color: color(k), dash: [] }));
  if (plot.points) return meta.points.flatMap((name, p) => [{ name, trace: signals.point(p, plot.points), color: color(p), dash: dash(Math.floor(p / CURVES.length)) }, ...measuredOf(signals, { point: p }, plot.points)]);
  const struck = new Set(shown.map((h) => meta.hammers[h].casting));
  if (plot.castings) return [...struck].flatMap((c) => [{ name: meta.castings[c].name, trace: signals.casting(c, plot.castings), color: color(c), dash: dash(Math.floor(c / CURVES.length)) }, ...measuredOf(signals, { casting: c }, plot.castings)]);
  if (plot.fixtures) {
    const all = [...struck].flatMap((c) => meta.castings[c].fixtures.map(({ name }, f) => [meta.castings.length > 1 ? `${meta.castings[c].name}: ${name}` : name, c, f]));
    return all.flatMap(([name, c, f], k) => [{ name, trace: signals.fixture(c, f, plot.fixtures), color: color(k), dash: dash(Math.floor(k / CURVES.length)) }, ...measuredOf(signals, { fixture: [c, f] }, plot.fixtures)]);
  }
  return shown.flatMap((h) => plot.hammer.flatMap(([name, quantity], k) => [{
    name: shown.length > 1 ? (plot.hammer.length > 1 ? `${meta.hammers[h].name}: ${name}` : meta.hammers[h].name) : name,
    trace: signals.hammer(h, quantity), color: color(shown.length > 1 ? h : k), dash: shown.length > 1 ? dash(k) : [],
  }, ...measuredOf(signals, { hammer: h }, quantity)]));
}

/** Times at which the pads of the castings that are shown carry nothing, each with its row of bars: name, colour, spans in s. */
function liftedOf(meta, shown) {
  const struck = [...new Set(shown.map((h) => meta.hammers[h].casting))];
  const places = struck.flatMap((c) => meta.castings[c].fixtures.map((_, f) => [c, f]));
  return places.flatMap(([c, f], k) => meta.lifted.filter((pad) => pad.casting === c && pad.fixture === f && pad.spans_s.length).map(({ spans_s: spans }) => ({ name: meta.castings[c].fixtures[f].name, color: CURVES[k % CURVES.length], spans })));
}

/** The bar that stays in sight: time, jumps, zoom, hammers. */
function controlBar(meta, view, player, hammers) {
  const button = (text, label, act) => el('button', { type: 'button', title: label, 'aria-label': label, onclick: act }, text);
  const bar = el('div', { class: 'bar player' }, player.button,
    choice('Speed', SPEEDS, player.speed, (value) => { player.speed = Number(value); }), player.slider, player.clock,
    el('span', { class: 'keys' }, button('◀ blow', 'Previous blow (p)', () => player.jump(false)), button('blow ▶', 'Next blow (n)', () => player.jump(true))),
    el('span', { class: 'keys' }, button('+', 'Zoom in (+)', () => view.zoom(0.5, view.now)), button('−', 'Zoom out (-)', () => view.zoom(2, view.now)), button('all', 'The whole time (0)', () => view.all())));
  if (meta.hammers.length > 1) bar.append(choice('Plots of', [...meta.hammers.map((hammer, h) => [h, hammer.name]), ['all', 'all hammers']], hammers.chosen, (value) => hammers.choose(value)));
  body.append(bar);
}

function keyboard(view, player) {
  const acts = { ' ': () => player.toggle(), n: () => player.jump(true), p: () => player.jump(false), '+': () => view.zoom(0.5, view.now), '=': () => view.zoom(0.5, view.now), '-': () => view.zoom(2, view.now), 0: () => view.all(), ArrowLeft: () => view.pan(-0.2), ArrowRight: () => view.pan(0.2), ',': () => view.seek(view.now - view.step), '.': () => view.seek(view.now + view.step) };
  document.addEventListener('keydown', (event) => {
    const own = event.target.closest('input, select, textarea') || (event.key === ' ' && event.target.closest('button, summary'));
    if (own || event.ctrlKey || event.metaKey || event.altKey || !(event.key in acts)) return;
    event.preventDefault();
    acts[event.key]();
  });
}

function blowTable(meta, player) {
  if (!meta.blows.length) { section('Blows', el('p', {}, 'The row has no blow.')); return; }
  const heading = [el('th', { class: 'text' }, 'hammer'), el('th', {}, 'no.'), el('th', { class: 'text' }, 'kind'), ...meta.figures.map((figure) => el('th', { title: figure.text }, titled(figure.heading, figure.unit))), el('th', {}, '')];
  const decimals = (unit) => ({ s: 6, N: 0 })[unit] ?? 4;
  const row = (blow) => el('tr', {}, el('td', { class: 'text' }, meta.hammers[blow.hammer].name), el('td', {}, String(blow.number)), el('td', { class: 'text' }, words(blow.kind)),
    ...blow.figures.map((value, k) => el('td', {}, value === null ? '–' : value.toFixed(decimals(meta.figures[k].unit)))),
    el('td', {}, el('button', { type: 'button', 'aria-label': `Show blow ${blow.number} of ${meta.hammers[blow.hammer].name}`, onclick: () => { player.view.show(blow.start_s - 0.005, blow.start_s + 0.015); player.view.seek(Math.max(0, blow.start_s - BEFORE_BLOW)); } }, 'show')));
  const table = el('div', { class: 'scroll' }, el('table', {}, el('thead', {}, el('tr', {}, ...heading)), el('tbody', {}, ...meta.blows.map(row))));
  section('Blows', meta.blows.length > SHORT_TABLE ? el('details', {}, el('summary', {}, `${meta.blows.length} blows`), table) : table);
}

/** A signal's name without the unit that ends it. */
const bareName = ({ name, unit }) => name.replace(new RegExp(`_${unit.toLowerCase().replace(/\W/g, '_')}$`), '');

function spectraSection(meta, bytes) {
  const title = { arm_velocity_m_s: ['Arm', 'mm/s', 1e3], chisel_velocity_m_s: ['Chisel', 'm/s', 1], casting_velocity_m_s: ['Casting', 'm/s', 1] };
  const parts = meta.hammers.map((hammer, h) => {
    const plots = meta.spectra.filter((lines) => lines.hammer === h).map((lines) => {
      const [name, unit, scale] = title[lines.quantity] ?? [words(bareName(lines)), lines.unit, 1];
      const values = (own) => new Float32Array(bytes.buffer, bytes.byteOffset + own.offset, own.count);
      const curve = (own, named, color, dash) => ({ name: named, values: values(own), resolution: own.resolution_hz, color, dash });
      const measured = lines.measured.filter((one) => one.lines), missing = lines.measured.filter((one) => !one.lines);
      const curves = [curve(lines, 'calculated', BLUE, []), ...measured.map((one) => curve(one.lines, `measured: ${one.column}`, MEASURED, [2, 2]))];
      const note = missing.map((one) => `; ${one.column} has too little of it`).join('');
      const span = ([from, to]) => `${short(1000 * from)} to ${short(1000 * to)} ms`, whole = lines.cut_from_s ? ` (what is measured of ${span(lines.cut_from_s)})` : '';
      return spectrumPlot(`${name}, ${lines.phase}: ${span([lines.from_s, lines.to_s])}${whole}${note}`, curves, unit, scale).node;
    });
    return el('div', {}, meta.hammers.length > 1 ? el('h3', {}, hammer.name) : '', el('div', { class: 'grid' }, ...plots));
  });
  section('Spectra', note('Amplitudes of velocities up to 1 kHz, phase by phase: single-sided, rectangular window, distance of the lines 1 / duration, without the mean. With a measurement, both use the longest time of the phase that both cover.'), ...parts);
}

/** Shock spectra of the core points: of the run in full lines, of the first impact in broken ones. */
function shockSection({ frequencies_hz: hz, cores }) {
  if (!cores.length) return;
  const curves = cores.flatMap(([name, of], k) => [
    { name, values: of.pseudo_velocity_m_s, color: CURVES[k % CURVES.length], dash: [] },
    { name: `${name}, first impact`, values: of.first_impact_pseudo_velocity_m_s, color: CURVES[k % CURVES.length], dash: [4, 3] },
  ]);
  section('Shock at the core points', note(GRADES_TEXT), shockPlot('Shock spectra', hz, curves).node);
}

function outputsSection(meta) {
  if (!meta.outputs.length) return;
  const groups = [...new Set(meta.outputs.map((one) => one.of))];
  const number = (text) => (text === null ? '–' : text !== '' && Number.isFinite(Number(text)) ? String(Number(Number(text).toPrecision(7))) : words(text));
  const table = (of) => el('details', {}, el('summary', {}, of), el('div', { class: 'scroll' }, el('table', {}, ...meta.outputs.filter((one) => one.of === of).map((one) => el('tr', {}, el('td', { class: 'text' }, one.name), el('td', {}, withUnit(number(one.value), one.unit)), el('td', { class: 'text' }, one.text))))));
  section('Outputs', ...groups.map(table));
}

async function scenePage() {
  sceneHead(meta);
  if (meta.samples < 2) { section('Signals', el('p', {}, 'The row has no signals, because it ended before they began.')); provenance(meta); return null; }
  const bytes = await unpacked('data'), signals = new Signals(meta, bytes);
  const view = new View(signals.end, Math.min(signals.end, 8 * signals.interval)), player = new Player(view, meta.blows);
  view.step = signals.interval;
  const hammers = { chosen: meta.hammers.length > 1 ? 'all' : '0', shown: meta.hammers.map((_, h) => h), plots: [] };
  hammers.choose = (value) => {
    hammers.shown = value === 'all' ? meta.hammers.map((_, h) => h) : [Number(value)];
    hammers.plots.forEach((figure) => figure.redraw());
  };
  controlBar(meta, view, player, hammers);
  const mechanism = meta.hammers.length ? new Mechanism(meta, signals, view) : null;
  if (mechanism) section('In motion', mechanism.figure.node, note('Contacts flash when they close. Chambers: white at ambient pressure, blue at the supply’s. Keys: space plays, n and p jump to the next and the previous blow, comma and full stop move by one sample.'));
  const sides = new SideViews(meta, signals, view);
  section('In place', note(PLACE_NOTE), el('div', { class: 'pair views' }, sitePlan(meta).node, ...sides.nodes));
  hammers.plots = PLOTS.filter((plot) => !plot.points || meta.points.length).map((plot) => tracePlot(view, {
    ...plot, curves: () => curvesOf(meta, signals, plot, hammers.shown),
    blows: plot.blows ? () => meta.blows.filter((blow) => hammers.shown.includes(blow.hammer)) : undefined,
    lifted: plot.lifted ? () => liftedOf(meta, hammers.shown) : undefined,
    title: plot.lifted && meta.lifted.some((pad) => pad.spans_s.length) ? `${plot.title}; bars: lifted off` : plot.title,
  }));
  const every = `One sample every ${short(1e6 * signals.interval)} µs, none left out: if samples are closer than pixels, their smallest and largest values are drawn.`;
  section('Over time', note(`${every} Drag to zoom, drag with Shift to move, click to set the time. Use the wheel with Ctrl to zoom, with Shift to move, or the arrows, +, − and 0.`), ...hammers.plots.map((figure) => figure.node));
  blowTable(meta, player);
  spectraSection(meta, bytes);
  shockSection(meta.shocks);
  outputsSection(meta);
  provenance(meta);
  keyboard(view, player);
  return { view, player, mechanism, sides, signals, plots: hammers.plots };
}

/** What the page is made of, for those who look into it with the browser's tools. */
const scene = scenePage();
scene.then(() => {
  figures.forEach((figure) => { if (figure.node.getBoundingClientRect().top < innerHeight) figure.draw(); });
  performance.mark('decore-drawn');
  performance.mark('decore-whole');
});
