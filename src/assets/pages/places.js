// Where the parts of a row's scene are: motion of the castings' points, and the scene from above.

/** Share of a direction along another from which on the motion of a point is drawn along that. */
const ALONG = 0.99;

const product = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** The largest round number up to a value: 1, 2 or 5 times a power of ten. */
function roundBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [5, 2, 1].find((m) => m * power <= value * 1.001);
}

/** A length in the unit that suits it. */
function lengthText(metres) {
  const [unit, factor] = metres >= 1 ? ['m', 1] : metres >= 1e-3 ? ['mm', 1e3] : metres >= 1e-6 ? ['µm', 1e6] : ['nm', 1e9];
  return `${Number((metres * factor).toPrecision(3))} ${unit}`;
}

/**
 * Motion of a casting's points along the direction in which it is measured, m from rest.
 *
 * The point (a, b) in the casting's frame, two directions across that one, moves by `heave + b rx - a ry` if the casting is rigid.
 * Points of an elastic casting have signals of their own.
 */
class CastingMotion {
  constructor(meta, signals, c) {
    const casting = meta.castings[c], of = (quantity) => signals.casting(c, quantity);
    Object.assign(this, { casting, heave: of('heave_m'), turns: [of('rotation_x_rad'), of('rotation_y_rad')] });
    const struck = meta.hammers.map((hammer, h) => [hammer, h]).filter(([hammer]) => hammer.casting === c);
    this.points = [
      ...struck.map(([hammer, h]) => this.point('strike', h, hammer.name, hammer.strike_m, signals.hammer(h, 'casting_displacement_m'), hammer.along)),
      ...casting.held.map((held, f) => this.point('held', f, casting.fixtures[f].name, held.at_m, signals.fixture(c, f, 'casting_displacement_m'), held.along)),
      ...(casting.measured_m ? [this.point('measured', 0, 'measuring point', casting.measured_m, of('measuring_point_displacement_m'))] : []),
      ...casting.cores.map(({ name, at }, k) => this.point('core', k, name, at, signals.core(c, k, 'displacement_m'))),
    ];
  }
  /** `along`: share of the direction of its signal along the casting's. */
  point(kind, index, name, at, trace, along = 1) { return { kind, index, name, at, trace, along, frame: this.frame(at) }; }
  frame(at) { return this.casting.axes.map((axis) => product(axis, at)); }
  find(kind, index) { return this.points.find((point) => point.kind === kind && point.index === index); }
  /** Motion of a place of a rigid casting. */
  rigid([a, b], time) { return this.heave.at(time) + b * this.turns[0].at(time) - a * this.turns[1].at(time); }
  /** Motion of a point along its own direction. */
  own({ trace, along, frame }, time) { return trace ? trace.at(time) : along * this.rigid(frame, time); }
  /** Motion of a point along the casting's direction; if its signal has another one, that of the casting without bending. */
  at(point, time) { return Math.abs(point.along) < ALONG ? this.rigid(point.frame, time) : this.own(point, time) * Math.sign(point.along); }
  /** Motion of a point beyond that of a rigid casting; 0 if its signal has another direction. */
  bend(point, time) { return this.at(point, time) - this.rigid(point.frame, time); }
}

/** Names beside marks: each stands where it covers no other, or not at all. */
class Labels {
  /** `left`, `right`, `bottom`: where names may stand. */
  constructor(left, right, bottom) { Object.assign(this, { left, right, bottom, taken: [] }); }
  /** Keeps a rectangle free. */
  keep(x, y, width, height) { this.taken.push([x, y, x + width, y + height]); }
  text(painter, text, x, y, { gap = 9, size = 10, ...style } = {}) {
    const width = 0.58 * size * text.length + 2, half = 0.6 * size;
    const spots = [['left', x + gap, y], ['right', x - gap, y], ['center', x, y - gap - half], ['center', x, y + gap + half]];
    for (const [align, at, line] of spots) {
      const left = align === 'left' ? at : align === 'right' ? at - width : at - width / 2, box = [left, line - half, left + width, line + half];
      const out = box[0] < this.left || box[1] < 0 || box[2] > this.right || box[3] > this.bottom;
      if (out || this.taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) continue;
      this.taken.push(box);
      painter.text(text, at, line, { size, align, halo: true, ...style });
      return;
    }
  }
}

/** A bar of a round length at (x, y), its right end, as long as fits into `room` pixels. */
function scaleBar(painter, x, y, scale, room) {
  const length = roundBelow(room / scale), left = x - length * scale;
  painter.line([left, y - 4, left, y, x, y, x, y - 4], { color: INK, width: 1.5 });
  painter.text(lengthText(length), (left + x) / 2, y - 9, { size: 10, align: 'center', halo: true });
}

/** A mark of a point from above or from the side. */
function pointMark(painter, kind, x, y) {
  if (kind === 'core') painter.polygon([x, y - 5, x + 5, y, x, y + 5, x - 5, y], { fill: '#8a5fb0' });
  else if (kind === 'measured') { painter.dots([x, y], 5.5, { color: BLUE }); painter.dots([x, y], 3, { color: PAPER }); }
  else if (kind === 'centre') { painter.dots([x, y], 6, { color: INK }); painter.dots([x, y], 4.8, { color: PAPER }); painter.line([x - 6, y, x + 6, y], { color: INK }); painter.line([x, y - 6, x, y + 6], { color: INK }); }
  else if (kind === 'mount') { painter.dots([x, y], 6.5, { color: ORANGE }); painter.dots([x, y], 4.5, { color: PAPER }); }
  else if (kind === 'machine') painter.rect(x - 2.5, y - 2.5, 5, 5, { stroke: SOFT });
  else painter.dots([x, y], 4.5, { color: ORANGE });
}

/** What the marks of a figure mean. `entries`: [name, painter of the mark at (x, y)]; rows of at most `width` pixels. */
function markLegend(entries, left, width) {
  const placed = [];
  let [x, row] = [left, 0];
  for (const [name, mark] of entries) {
    const wide = 26 + 5.6 * name.length;
    if (x > left && x + wide > left + width) { x = left; row++; }
    placed.push({ name, mark, x, row });
    x += wide;
  }
  return { placed, rows: placed.length ? row + 1 : 0 };
}

function drawLegend(painter, { placed }, top) {
  for (const { name, mark, x, row } of placed) {
    mark(x + 7, top + 16 * row);
    painter.text(name, x + 17, top + 16 * row, { size: 10, color: SOFT });
  }
}

/** Everything that the plan of a scene marks: { kind, at, name, text, bare }, in the order in which it is drawn. */
function planMarks(meta) {
  const marks = [];
  const add = (kind, [x, y], name, text) => marks.push({ kind, at: [x, y], name, text });
  meta.castings.forEach((casting) => {
    const place = (at) => [0, 1].map((axis) => casting.centre_m[axis] + at[axis]), of = meta.castings.length > 1 ? `, casting ${casting.name}` : '';
    add('centre', casting.centre_m, '', `centre of mass${of}`);
    casting.fixtures.forEach(({ name, kind, at }, f) => add(kind, at, words(name), `${FIXTURES[kind]} ${name} on ${casting.held[f].point}${of}`));
    casting.cores.forEach(({ name, at }) => add('core', place(at), words(name), `core point ${name}${of}`));
    if (casting.measured_m) add('measured', place(casting.measured_m), 'measured', `measuring point${of}`);
  });
  meta.hammers.forEach(({ name, mount_m: mount, casting, strike_m: strike }) => {
    if (mount) add('mount', mount, '', `mount of hammer ${name}`);
    add('strike', [0, 1].map((axis) => meta.castings[casting].centre_m[axis] + strike[axis]), words(name), `strike point of hammer ${name}`);
  });
  // A point that carries something has its name, but no mark of its own.
  const carries = (at) => marks.some((mark) => Math.hypot(mark.at[0] - at[0], mark.at[1] - at[1]) < 1e-6);
  const points = meta.machine_points.map(({ name, at }) => ({ kind: 'machine', at, name, text: `interface point ${name}`, bare: carries(at) }));
  return [...points, ...marks];
}

const MARK_NAMES = { machine: 'interface point', centre: 'centre of mass', spring: 'spring', pad: 'pad', clamp: 'clamp', core: 'core point', measured: 'measuring point', mount: 'mount', strike: 'strike point' };

/** The scene from above, to scale: machine, castings, fixtures, hammers. */
function sitePlan(meta) {
  const all = planMarks(meta), supports = new Set(meta.castings.flatMap(({ held }) => held.map(({ point }) => point)));
  const shown = all.filter(({ kind, name }) => kind === 'mount' || kind === 'strike' || (kind === 'machine' && supports.has(name)) || kind === 'core' || kind === 'measured');
  const ends = planEnds({ rails: meta.rails, castings: meta.castings, standing: [], tracks: [], points: shown.map(({ at }) => at) });
  const [wide, tall] = ends.map(([low, high]) => high - low), inside = ({ at }) => at.every((v, axis) => v >= ends[axis][0] && v <= ends[axis][1]);
  const marks = all.filter(inside), kinds = Object.keys(MARK_NAMES).filter((kind) => marks.some((mark) => mark.kind === kind && !mark.bare));
  const scaleOf = (width) => Math.min((width - 70) / wide, 380 / tall);
  const draw = (painter, kind, x, y) => (kind in FIXTURES ? fixtureMark(painter, kind, x, y) : pointMark(painter, kind, x, y));
  const legend = (painter, width) => markLegend([...(meta.rails.length ? [['rail', (x, y) => painter.line([x - 6, y, x + 6, y], { color: GREY, width: 5, alpha: 0.7 })]] : []), ...kinds.map((kind) => [MARK_NAMES[kind], (x, y) => draw(painter, kind, x, y)])], 8, width - 16);
  return new Figure({
    title: 'From above, to scale', height: (width) => Math.round(scaleOf(width) * tall) + 60 + 16 * legend(null, width).rows,
    paint(painter, width) {
      const scale = scaleOf(width), box = { left: 52, top: 8, width: scale * wide, height: scale * tall };
      axes(painter, box, { low: ends[0][0], high: ends[0][1], title: 'x (m)' }, { low: ends[1][0], high: ends[1][1], title: 'y (m)' });
      const px = (x) => box.left + (x - ends[0][0]) * scale, py = (y) => box.top + box.height - (y - ends[1][0]) * scale;
      const labels = new Labels(box.left, box.left + box.width, box.top + box.height - 24), within = ([x, y]) => [x, y].map((v, axis) => Math.max(ends[axis][0], Math.min(ends[axis][1], v)));
      for (const casting of meta.castings) castingOutline(painter, casting, [px, py], scale);
      for (const { name, at } of meta.rails) {
        const line = at.map(within).flatMap(([x, y]) => [px(x), py(y)]);
        painter.line(line, { color: GREY, width: 7, alpha: 0.7 });
        if (line.length) labels.text(painter, words(name), line[line.length - 2], line[line.length - 1], { color: SOFT });
      }
      for (const { mount_m: mount, casting, strike_m: strike } of meta.hammers) {
        const { centre_m: centre } = meta.castings[casting];
        if (mount) painter.line([px(mount[0]), py(mount[1]), px(centre[0] + strike[0]), py(centre[1] + strike[1])], { color: ORANGE, dash: [3, 3] });
      }
      this.marks = marks.map((mark) => ({ ...mark, x: px(mark.at[0]), y: py(mark.at[1]) }));
      for (const { kind, x, y, bare } of this.marks) { if (!bare) draw(painter, kind, x, y); labels.keep(x - 6, y - 6, 12, 12); }
      for (const { name, centre_m: centre } of meta.castings) labels.text(painter, words(name), px(centre[0]), py(centre[1]), { color: BLUE, weight: 600, size: 11 });
      const order = ['strike', 'core', 'measured', 'clamp', 'pad', 'spring', 'machine'];
      for (const kind of order) for (const mark of this.marks.filter((one) => one.kind === kind)) labels.text(painter, mark.name, mark.x, mark.y, { color: kind === 'strike' ? ORANGE : SOFT });
      scaleBar(painter, box.left + box.width - 8, box.top + box.height - 8, scale, box.width / 4);
      drawLegend(painter, legend(painter, width), box.top + box.height + 48);
    },
    hover(x, y) {
      const near = (this.marks ?? []).filter((mark) => Math.hypot(mark.x - x, mark.y - y) < 9);
      return near.map(({ text, at }) => `${text}: x ${short(at[0])} m, y ${short(at[1])} m`).join('\n');
    },
  });
}
