// A casting from the side as it tilts, bends and moves, exaggerated by a factor that the page states.

/** Share of a casting's size that its largest motion has in the drawing. */
const LARGEST = 0.08;
/** Share of its length that a casting is drawn thick if its height is unknown. */
const THICK = 0.16;
/** Stations between the ends of a casting that bends. */
const STATIONS = 48;
/** Share of the largest motion from which on tilt has a view of its own. */
const TILTS = 0.05;
/** Pixels: least and most thickness, largest drawn gap before a chisel, chisel, cylinder, fixture, machine below it. */
const SIDE = { thin: 18, thick: 150, gap: 44, chisel: 34, cylinder: 40, fixture: 40, table: 10, left: 56 };

/** A curve through points (x, y) with rising x: a natural cubic spline, straight beyond its ends. Returns its value at x. */
function spline(points) {
  const n = points.length, x = points.map(([at]) => at), y = points.map(([, value]) => value);
  if (n < 2) return () => y[0] ?? 0;
  const h = x.slice(1).map((at, i) => at - x[i]), slope = h.map((step, i) => (y[i + 1] - y[i]) / step), second = new Array(n).fill(0), share = new Array(n).fill(0);
  for (let i = 1; i < n - 1; i++) {
    const pivot = 2 * (h[i - 1] + h[i]) - h[i - 1] * share[i - 1];
    share[i] = h[i] / pivot;
    second[i] = (6 * (slope[i] - slope[i - 1]) - h[i - 1] * second[i - 1]) / pivot;
  }
  for (let i = n - 2; i > 0; i--) second[i] -= share[i] * second[i + 1];
  const left = slope[0] - h[0] * second[1] / 6, right = slope[n - 2] + h[n - 2] * second[n - 2] / 6;
  return (at) => {
    if (at <= x[0]) return y[0] + left * (at - x[0]);
    if (at >= x[n - 1]) return y[n - 1] + right * (at - x[n - 1]);
    let i = 0;
    while (at > x[i + 1]) i++;
    const a = (x[i + 1] - at) / h[i], b = 1 - a;
    return a * y[i] + b * y[i + 1] + ((a ** 3 - a) * second[i] + (b ** 3 - b) * second[i + 1]) * h[i] ** 2 / 6;
  };
}

/** A casting's body in its frame: ends along both directions across the measured one, and along that; whether they are known. */
class CastingShape {
  constructor(motion) {
    const { casting, points } = motion, { extent_m: extent, outline_m: outline, centre_m: centre } = casting;
    const box = outline && [0, 1].map((axis) => outline[axis].map((end) => end - centre[axis]));
    const reach = (axis) => {
      if (!extent && (!box || casting.axes[axis][2] !== 0)) return null;
      const sides = extent ?? [...box, [0, 0]], corners = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => product(casting.axes[axis], sides.map((ends, k) => ends[(n >> k) & 1])));
      return [Math.min(...corners), Math.max(...corners)];
    };
    const around = (axis) => {
      const at = [0, ...points.map(({ frame }) => frame[axis])], [low, high] = [Math.min(...at), Math.max(...at)], margin = Math.max(0.03, 0.15 * (high - low));
      return [low - margin, high + margin];
    };
    this.known = reach(0) !== null && reach(1) !== null;
    this.across = [0, 1].map((axis) => reach(axis) ?? around(axis));
    this.size = Math.max(...this.across.map(([low, high]) => high - low));
    this.height = extent ? reach(2) : [-0.5 * THICK * this.size, 0.5 * THICK * this.size];
  }
}

/** Motion of a casting for its side views, and the factor that exaggerates it. */
class SideMotion {
  constructor(meta, signals, c) {
    Object.assign(this, { meta, signals, c, motion: new CastingMotion(meta, signals, c) });
    this.shape = new CastingShape(this.motion);
    const { heave, turns } = this.motion, { across } = this.shape, corners = across[0].flatMap((a) => across[1].map((b) => [a, b]));
    const traces = this.motion.points.map(({ trace }) => trace).filter(Boolean), supports = meta.castings[c].held.map((_, f) => signals.fixture(c, f, 'point_displacement_m'));
    const most = ({ values }) => values.reduce((largest, value) => Math.max(largest, Math.abs(value)), 0);
    this.largest = Math.max(...traces.map(most), ...supports.map(most));
    for (const [a, b] of corners) heave.values.forEach((value, k) => { this.largest = Math.max(this.largest, Math.abs(value + b * turns[0].values[k] - a * turns[1].values[k])); });
    const tilt = [most(turns[1]) * this.span(0), most(turns[0]) * this.span(1)], longest = this.span(0) >= this.span(1) ? 0 : 1;
    const bends = meta.castings[c].elastic, shows = (axis) => tilt[axis] >= TILTS * this.largest || (bends && axis === longest);
    /** Directions of the side views: along the larger tilt first, along the longer side first if the casting bends. */
    this.views = [0, 1].filter((axis) => this.largest > 0 && shows(axis)).sort((a, b) => (bends ? this.span(b) - this.span(a) : tilt[b] - tilt[a]));
    if (!this.views.length) this.views = [longest];
  }
  span(axis) { const [low, high] = this.shape.across[axis]; return high - low; }
  /** The round factor that makes the largest motion at most 8 % of the casting's size. */
  factor() {
    const wanted = LARGEST * this.shape.size / this.largest;
    return Number.isFinite(wanted) ? Math.max(1, roundBelow(wanted)) : 1;
  }
  /** Motion of the casting along a direction across the measured one, bending included; `other`: place along the other direction. */
  along(axis, time, other = 0) {
    const { motion } = this, at = (place) => (axis === 0 ? [place, other] : [other, place]);
    if (!motion.casting.elastic) return (place) => motion.rigid(at(place), time);
    const knots = [];
    const known = motion.points.filter(({ trace, along }) => trace && Math.abs(along) >= ALONG).sort((a, b) => a.frame[axis] - b.frame[axis]);
    for (const point of known) {
      const place = point.frame[axis], last = knots[knots.length - 1], bend = motion.bend(point, time);
      // Points above each other give one place of the curve.
      if (last && place - last.place < 0.02 * this.span(axis)) { last.sum += bend; last.count++; } else knots.push({ place, sum: bend, count: 1 });
    }
    const bend = spline(knots.map(({ place, sum, count }) => [place, sum / count]));
    return (place) => motion.rigid(at(place), time) + bend(place);
  }
}

/** The name of a direction of a casting's frame. */
function directionName(axis) {
  const at = axis.findIndex((share) => Math.abs(share) > 1 - 1e-9);
  return at >= 0 ? 'xyz'[at] : `along ${axis.map((share) => Number(share.toFixed(2))).join(', ')}`;
}

/** The side view of a casting along one direction across the measured one. `side()`: { motion: SideMotion, factor }. */
class SideView {
  constructor(view, order, side) {
    Object.assign(this, { view, order, side, node: el('div') });
    this.figure = new Figure({
      title: '', height: (width) => this.place(width).tall,
      paint: (painter, width) => this.paint(painter, width),
      hover: (x, y) => this.hover(x, y),
    });
    this.rename();
    view.watch(() => {}, () => this.figure.redraw());
  }
  /** Direction across the measured one that the view shows; undefined if this casting needs fewer views. */
  get axis() { return this.side().motion.views[this.order]; }
  rename() {
    const { motion, factor } = this.side(), { axis } = this, { casting } = motion.motion;
    // A view that the casting does not need is no figure of the page.
    if (axis === undefined) { figures.delete(this.figure); this.node.replaceChildren(); return; }
    figures.add(this.figure);
    if (!this.figure.node.isConnected) this.node.append(this.figure.node);
    const vertical = directionName(casting.axes[2]), name = this.side().several ? `Casting ${casting.name}` : 'Casting';
    this.figure.retitle(`${name} from the side, ${directionName(casting.axes[axis])} and ${vertical === 'z' ? vertical : 'the measured direction'}: motion\u00a0×\u00a0${brief(factor)}`);
    this.figure.redraw();
  }
  /** Where things are drawn in a width: pixels a metre, and the heights of the parts. */
  place(width) {
    const { motion } = this.side(), { shape, c, meta } = motion, { axis } = this, d = SIDE;
    const places = motion.motion.points.map(({ frame }) => frame[axis]), [low, high] = shape.across[axis];
    const ends = [Math.min(low, ...places), Math.max(high, ...places)], margin = 0.06 * (ends[1] - ends[0]);
    [ends[0], ends[1]] = [ends[0] - margin, ends[1] + margin];
    const room = width - d.left - 14, height = shape.height[1] - shape.height[0];
    // The same scale in both views of a casting, unless fixtures or hammers beside it need more room.
    const scale = Math.min(room / Math.max(1.12 * shape.size, ends[1] - ends[0]), d.thick / height), drawn = Math.max(d.thin, height * scale);
    const swing = 1.15 * LARGEST * shape.size * scale + 6, hammers = meta.hammers.some(({ casting }) => casting === c);
    const above = 10 + (hammers ? d.gap + d.chisel + d.cylinder : d.gap), top = above + swing, bottom = top + drawn;
    const middle = d.left + room / 2 - scale * (ends[0] + ends[1]) / 2, floor = bottom + d.fixture;
    return { scale, ends, top, bottom, floor, x: (across) => middle + scale * across, tall: Math.round(floor + d.table + swing + 66) };
  }
  paint(painter, width) {
    const { motion, factor } = this.side(), { axis } = this, at = this.place(width), time = this.view.now;
    const { motion: points, shape } = motion, box = { left: SIDE.left, top: 6, width: width - SIDE.left - 14, height: at.tall - 46 };
    const offset = product(points.casting.axes[axis], [...points.casting.centre_m, points.casting.centre_height_m]);
    const place = (pixel) => offset + (pixel - at.x(0)) / at.scale;
    axes(painter, box, { low: place(box.left), high: place(box.left + box.width), title: `${directionName(points.casting.axes[axis])} (m)` }, { low: 0, high: 0, names: [] });
    this.pixels = (moved) => factor * at.scale * moved;
    this.marks = [];
    this.fixtures(painter, at, time);
    const ends = shape.across[axis], count = points.casting.elastic ? STATIONS : 1, moved = motion.along(axis, time);
    const stations = Array.from({ length: count + 1 }, (_, k) => ends[0] + (ends[1] - ends[0]) * k / count);
    const edge = (y, to = moved) => stations.map((across) => [at.x(across), y + this.pixels(to(across))]);
    painter.line([at.x(ends[0]), at.top, at.x(ends[1]), at.top, at.x(ends[1]), at.bottom, at.x(ends[0]), at.bottom, at.x(ends[0]), at.top], { color: SOFT, dash: [3, 3] });
    painter.polygon([...edge(at.top), ...edge(at.bottom).reverse()].flat(), { fill: '#b98f7a', stroke: shape.known ? INK : SOFT });
    if (!shape.known) painter.text('schematic: size unknown in this view', at.x(ends[0]) + 6, at.top + this.pixels(moved(ends[0])) + 10, { size: 10, color: '#1c2430' });
    // Its nearer and farther edge, where it tilts also about the axis that the view runs along.
    if (motion.views.length > 1) for (const other of shape.across[1 - axis]) painter.line(edge(at.top, motion.along(axis, time, other)).flat(), { color: INK, alpha: 0.35 });
    this.inner(painter, at, time);
    this.hammers(painter, at, time);
    this.scales(painter, at, box);
  }
  /** Drawn height of a point of the casting that is at rest at `y`. */
  moved(point, y, time) { return y + this.pixels(this.side().motion.motion.at(point, time)); }
  /** Keeps a mark at (x, y) that is at rest at (x, `rest`), for the pointer. */
  mark(point, x, y, rest, time) {
    const { motion } = this.side().motion, text = { strike: 'strike point of', held: 'held by', core: 'core point', measured: '' }[point.kind];
    this.marks.push({ kind: point.kind, index: point.index, x, y, rest, text: `${text} ${point.name}: ${lengthText(Math.abs(motion.at(point, time)))} ${motion.at(point, time) < 0 ? 'back' : 'on'}`.trim() });
  }
  /** Core points and the measuring point. */
  inner(painter, at, time) {
    const { motion, shape } = this.side().motion, middle = (at.top + at.bottom) / 2, height = shape.height[1] - shape.height[0];
    for (const point of motion.points.filter(({ kind }) => kind === 'core' || kind === 'measured')) {
      const deep = Math.max(-0.5, Math.min(0.5, (point.frame[2] - (shape.height[0] + shape.height[1]) / 2) / height));
      const x = at.x(point.frame[this.axis]), rest = point.kind === 'measured' ? at.bottom : middle + deep * (at.bottom - at.top), y = this.moved(point, rest, time);
      pointMark(painter, point.kind, x, y);
      this.mark(point, x, y, rest, time);
    }
  }
  /** Fixtures with the places of the machine that carry them. */
  fixtures(painter, at, time) {
    const { motion: { motion, c, signals, meta } } = this.side(), { casting } = motion, half = 14;
    motion.points.filter(({ kind }) => kind === 'held').forEach((point) => {
      const f = point.index, { kind } = casting.fixtures[f], { along, axis } = casting.held[f], x = at.x(point.frame[this.axis]);
      const sideways = Math.abs(along) < ALONG, above = kind === 'clamp' && along > 0, rest = above ? at.top : at.bottom, y = this.moved(point, rest, time);
      this.mark(point, x, y, rest, time);
      if (sideways) { this.sideways(painter, axis, x, y - rest, at); return; }
      if (above) {
        painter.line([x, y - 32, x, y - 8], { color: SOFT, width: 2 });
        painter.polygon([x - 6, y - 10, x + 6, y - 10, x, y], { fill: SOFT });
        return;
      }
      const floor = at.floor + this.pixels(Math.sign(along) * signals.fixture(c, f, 'point_displacement_m').at(time));
      painter.rect(x - half, floor, 2 * half, SIDE.table, { fill: DARK });
      const lifted = meta.lifted.some((pad) => pad.casting === c && pad.fixture === f && pad.spans_s.some(([from, to]) => from <= time && time <= to));
      if (kind === 'pad') {
        const top = lifted ? Math.max(y, floor - SIDE.fixture) : Math.min(y, floor - 2);
        painter.rect(x - 9, top, 18, floor - top, { fill: lifted ? ORANGE : '#6b7f6a', alpha: 0.85 });
      } else {
        const spring = Array.from({ length: 10 }, (_, k) => [x + (k === 0 || k === 9 ? 0 : k % 2 ? -6 : 6), y + (floor - y) * k / 9]);
        painter.line(spring.flat(), { color: SOFT, width: 1.5 });
      }
    });
  }
  /** A fixture that holds in another direction: its line of action as the view shows it. */
  sideways(painter, axis, x, moved, at) {
    const { casting } = this.side().motion.motion, dx = product(axis, casting.axes[this.axis]), dy = product(axis, casting.axes[2]), length = Math.hypot(dx, dy);
    const y = moved + (dy > 0.5 ? at.bottom : dy < -0.5 ? at.top : (at.top + at.bottom) / 2);
    if (length < 0.2) { pointMark(painter, 'machine', x, y); return; }
    painter.line([x, y, x + 30 * dx / length, y + 30 * dy / length], { color: SOFT, width: 2, dash: [2, 2] });
  }
  /** Hammers above the points that they strike: chisel and front of the cylinder, gaps to scale until they are large. */
  hammers(painter, at, time) {
    const { motion: { motion, meta, signals } } = this.side(), d = SIDE;
    for (const point of motion.points.filter(({ kind }) => kind === 'strike')) {
      const hammer = meta.hammers[point.index], x = at.x(point.frame[this.axis]), y = this.moved(point, at.top, time);
      const dx = product(hammer.axis, motion.casting.axes[this.axis]), dy = product(hammer.axis, motion.casting.axes[2]), length = Math.hypot(dx, dy);
      const struck = signals.hammer(point.index, 'casting_force_n').at(time) > 0, gap = struck ? 0 : Math.min(d.gap, at.scale * this.gap(point, time));
      if (length > 0.2) {
        const [ux, uy] = [dx / length, dy / length], to = (back, aside) => [x - ux * back - uy * aside, y - uy * back + ux * aside];
        const cylinder = gap + d.chisel, tail = cylinder + d.cylinder;
        painter.polygon([to(cylinder, 9), to(tail, 9), to(tail, -9), to(cylinder, -9)].flat(), { fill: STEEL, stroke: SOFT });
        painter.polygon([to(gap, 1.5), to(gap + 8, 4), to(cylinder, 4), to(cylinder, -4), to(gap + 8, -4), to(gap, -1.5)].flat(), { fill: '#5d7f9e', stroke: INK });
        painter.text(words(hammer.name), to(tail - 8, 0)[0] + 13, to(tail - 8, 0)[1], { size: 11, weight: 600, halo: true });
      }
      if (struck) painter.dots([x, y], 8, { color: FLASHED, alpha: 0.9 });
      pointMark(painter, 'strike', x, y);
      this.mark(point, x, y, at.top, time);
    }
  }
  /** Distance in m of a chisel's tip from its casting. */
  gap(point, time) {
    const { motion: { motion, meta, signals } } = this.side(), h = point.index, tip = (at) => ['arm_displacement_m', 'extension_m', 'chisel_m'].reduce((sum, quantity) => sum + signals.hammer(h, quantity).at(at), 0);
    return Math.max(0, meta.hammers[h].standoff_m - (tip(time) - tip(0)) + motion.own(point, time));
  }
  /** Bars for lengths and for the exaggerated motion, and the direction of positive motion. */
  scales(painter, at, box) {
    const { motion, factor } = this.side(), bottom = box.top + box.height, right = box.left + box.width;
    scaleBar(painter, right - 6, bottom - 8, at.scale, box.width / 5);
    const room = 0.5 * LARGEST * motion.shape.size * at.scale + 6, length = roundBelow(room / (factor * at.scale)), high = length * factor * at.scale, x = box.left + 12, y = bottom - 12;
    painter.line([x - 4, y - high, x, y - high, x, y, x - 4, y], { color: INK, width: 1.5 });
    painter.text(`motion: ${lengthText(length)}`, x + 6, y - high / 2, { size: 10, halo: true });
    const name = directionName(motion.motion.casting.axes[2]), up = 24, down = 52;
    painter.line([box.left - 20, up, box.left - 20, down], { color: SOFT });
    if (name === 'z') painter.polygon([box.left - 24, up, box.left - 16, up, box.left - 20, up - 8], { fill: SOFT });
    else painter.polygon([box.left - 24, down, box.left - 16, down, box.left - 20, down + 8], { fill: SOFT });
    if (name === 'z') painter.text(name, box.left - 20, down + 10, { size: 10, color: SOFT, align: 'center' });
    else painter.text('measured', box.left - 4, down + 18, { size: 10, color: SOFT, align: 'right' });
  }
  hover(x, y) { return (this.marks ?? []).filter((mark) => Math.hypot(mark.x - x, mark.y - y) < 10).map(({ text }) => text).join('\n'); }
}

/** Side views of the castings with their controls: casting, factor. */
class SideViews {
  constructor(meta, signals, view) {
    Object.assign(this, { meta, signals, known: new Map(), chosen: meta.hammers[0]?.casting ?? 0, own: null });
    this.input = el('input', { type: 'number', min: '1', step: 'any', onchange: () => this.exaggerate(this.input.valueAsNumber) });
    this.views = [0, 1].map((order) => new SideView(view, order, () => this.side()));
    const controls = el('div', { class: 'controls' }, el('label', {}, 'Motion exaggerated ×', this.input), el('button', { type: 'button', title: `The largest motion of the run is at most ${100 * LARGEST} % of the casting’s size`, onclick: () => this.exaggerate(NaN) }, 'automatic'));
    if (meta.castings.length > 1) controls.prepend(choice('Casting', meta.castings.map(({ name }, c) => [c, name]), this.chosen, (value) => { this.chosen = Number(value); this.rename(); }));
    const [first, second] = this.views.map(({ node }) => node);
    /** The first view with the controls, and the second view. */
    this.nodes = [el('div', {}, controls, first), second];
    this.rename();
  }
  /** Motion and factor of the chosen casting. */
  side() {
    if (!this.known.has(this.chosen)) this.known.set(this.chosen, new SideMotion(this.meta, this.signals, this.chosen));
    const motion = this.known.get(this.chosen);
    return { motion, factor: this.own ?? motion.factor(), several: this.meta.castings.length > 1 };
  }
  /** Exaggerates by another factor; by the automatic one if it is no positive number. */
  exaggerate(factor) {
    this.own = factor > 0 && Number.isFinite(factor) ? factor : null;
    this.rename();
  }
  rename() {
    this.input.value = String(this.side().factor);
    this.views.forEach((view) => view.rename());
  }
}
