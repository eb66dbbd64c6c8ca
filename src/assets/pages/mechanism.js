// The mechanism as it moves: hammers, castings, machine, by the signals at one time.

/** Lengths in m that the model does not have and a drawing needs. */
const DRAWN = { block: 0.05, clearance: 0.012, flange: 0.01, piston: 0.03, bushing: 0.02, collar: 0.014, retainer: 0.012, tip: 0.1, casting: 0.05, fixture: 0.06, table: 0.03, arm: 0.05, edge: 0.03 };
/** Factor on the spool's motion: its travel is millimetres. */
const SPOOL_FACTOR = 4;
/** Pixels: height of a hammer's row, half the height of parts. */
const ROW = 132, HALF = { guide: 40, flange: 32, cylinder: 26, bore: 15, shank: 7, collar: 11, casting: 52 };
/** Milliseconds for which a contact that has closed is seen to. */
const FLASH = 160;
const CONTACTS = ['casting_force_n', 'percussion_force_n', 'nose_force_n', 'retainer_force_n', 'rear_wall_force_n', 'top_stop_force_n', 'end_stop_force_n', 'spool_rear_force_n', 'spool_front_force_n'];
const STEEL = '#cfd6de', DARK = '#8d99a6', FLASHED = '#f08a24';

class Mechanism {
  constructor(meta, signals, view) {
    Object.assign(this, { meta, signals, view, before: 0, flashes: new Map(), motions: meta.castings.map((_, c) => new CastingMotion(meta, signals, c)) });
    // Hammers on one casting are neighbours: it is drawn as one.
    this.rows = meta.hammers.map((_, h) => h).sort((a, b) => meta.hammers[a].casting - meta.hammers[b].casting || a - b);
    this.factor = this.structureFactor();
    this.figure = new Figure({
      title: `The mechanism (along the strike axis to scale; motion of the machine × ${this.factor}, of the spool × ${SPOOL_FACTOR})`, height: ROW * this.rows.length + 20,
      paint: (painter, width) => this.paint(painter, width),
    });
    view.watch(() => {}, () => this.move());
  }
  /** A round factor that makes the machine's largest displacement about 10 mm. */
  structureFactor() {
    let largest = 0;
    const take = (trace) => { const [low, high] = trace.range(0, this.signals.end); largest = Math.max(largest, -low, high); };
    this.meta.hammers.forEach((_, h) => take(this.signals.hammer(h, 'arm_displacement_m')));
    this.meta.castings.forEach((casting, c) => casting.fixtures.forEach((_, f) => take(this.signals.fixture(c, f, 'point_displacement_m'))));
    const wanted = 0.01 / largest;
    return Number.isFinite(wanted) ? Math.max(1, roundBelow(wanted)) : 1;
  }
  /** Displacement of a casting where a hammer strikes it or a fixture holds it, along the direction of that. */
  casting(c, kind, index, time) {
    const motion = this.motions[c];
    return motion.own(motion.find(kind, index), time);
  }
  /** Where the parts of a hammer are drawn at a time: m along the strike axis from its guide's rear wall at rest. */
  pose(h, time) {
    const d = DRAWN, of = (quantity) => this.signals.hammer(h, quantity).at(time), hammer = this.meta.hammers[h];
    const guide = of('arm_displacement_m'), cylinder = guide + of('extension_m'), chamber = d.clearance + d.block;
    const seat = hammer.chamber_length_m + d.piston + d.bushing, reach = seat + d.collar + d.tip;
    const first = (quantity) => this.signals.hammer(h, quantity).values[0];
    const face = chamber + first('arm_displacement_m') + first('extension_m') + first('chisel_m') + reach + hammer.standoff_m;
    return {
      guide, cylinder, arm: guide, rear: cylinder + chamber, piston: cylinder + chamber + of('piston_m'),
      shank: cylinder + chamber + of('chisel_m') + hammer.piston_stroke_m + d.piston,
      collar: cylinder + chamber + of('chisel_m') + seat, tip: cylinder + chamber + of('chisel_m') + reach, spool: of('spool_m'),
      casting: face + this.casting(hammer.casting, 'strike', h, time), face,
    };
  }
  /** Follows the view's time; contacts that were closed since flash. */
  move() {
    const { now } = this.view, clock = performance.now(), [from, to] = now >= this.before && now - this.before < 0.1 ? [this.before, now] : [now, now];
    this.meta.hammers.forEach((_, h) => CONTACTS.forEach((quantity) => {
      const trace = this.signals.hammer(h, quantity);
      if (trace.at(to) > 0 || trace.range(from, to)[1] > 0) this.flashes.set(`${h} ${quantity}`, clock);
      else if (to < this.before) this.flashes.delete(`${h} ${quantity}`);
    }));
    this.before = now;
    if (this.figure.near) this.figure.draw();
    const fading = [...this.flashes.values()].some((since) => clock - since < FLASH);
    if (fading && !this.waiting) {
      this.waiting = true;
      setTimeout(() => { this.waiting = false; if (this.figure.near) this.figure.draw(); }, FLASH + 10);
    }
  }
  /** How brightly a contact is shown, 0 to 1. */
  glow(h, quantity) {
    if (this.signals.hammer(h, quantity).at(this.view.now) > 0) return 1;
    const since = this.flashes.get(`${h} ${quantity}`);
    return since === undefined ? 0 : Math.max(0, 1 - (performance.now() - since) / FLASH);
  }
  paint(painter, width) {
    const d = DRAWN, time = this.view.now, poses = this.meta.hammers.map((_, h) => this.pose(h, time));
    const left = d.arm + d.edge, longest = Math.max(...poses.map((pose) => pose.face));
    const scale = (width - 8) / (left + longest + d.casting + d.fixture + d.table + 0.02);
    const x = (metres) => 4 + (metres + left) * scale;
    this.rows.forEach((h, row) => this.hammer(painter, h, poses[h], x, (row + 0.5) * ROW));
    painter.text(`at ${timeText(time)}`, 4, ROW * this.rows.length + 12, { color: SOFT });
    this.meta.castings.forEach((_, c) => this.castingRows(painter, c, poses, x));
    this.rows.forEach((h, row) => {
      const { casting, tip } = poses[h], glow = this.glow(h, 'casting_force_n');
      if (glow) painter.dots([x((casting + tip) / 2), (row + 0.5) * ROW], 9, { color: FLASHED, alpha: 0.9 * glow });
    });
  }
  /** Gas in a chamber: white at ambient pressure, blue at the supply's and above. */
  gas(h, quantity) {
    const { supply_pa } = this.meta.hammers[h], ambient = this.meta.ambient_pa, p = this.signals.hammer(h, quantity).at(this.view.now);
    const part = Math.max(0, Math.min(1, (p - ambient) / (supply_pa - ambient || 1)));
    return `rgb(${[[250, 90], [252, 150], [255, 215]].map(([a, b]) => Math.round(a + part * (b - a))).join()})`;
  }
  hammer(painter, h, pose, x, y) {
    const d = DRAWN, hammer = this.meta.hammers[h], box = (from, to, half, style, middle = y) => painter.rect(x(from), middle - half, x(to) - x(from), 2 * half, style);
    const front = pose.guide + d.clearance + hammer.telescope_stroke_m + d.flange, foot = pose.cylinder + d.clearance;
    const wall = pose.rear + hammer.chamber_length_m + d.piston, seat = wall + d.bushing, mouth = seat + d.collar + hammer.chisel_travel_m, nose = mouth + d.retainer;
    // The arm of the machine, its motion exaggerated.
    const arm = -d.arm + this.factor * pose.arm;
    painter.rect(x(arm - d.edge), y - 58, x(arm) - x(arm - d.edge), 116, { fill: DARK });
    painter.line([x(arm), y, x(pose.guide), y], { color: DARK, width: 5 });
    // Telescope: guide, its two chambers, cylinder.
    box(pose.guide - 0.012, pose.guide, HALF.guide, { fill: DARK });
    for (const side of [-1, 1]) painter.rect(x(pose.guide), y + side * 36 - 4, x(front) - x(pose.guide), 8, { fill: DARK });
    box(pose.guide, foot, HALF.flange, { fill: this.gas(h, 'pressure_top_pa') });
    for (const side of [-1, 1]) {
      painter.rect(x(foot + d.flange), y + side * 29 - 3, x(front) - x(foot + d.flange), 6, { fill: this.gas(h, 'pressure_annulus_pa') });
      painter.rect(x(front), y + side * 33 - 7, x(front + 0.008) - x(front), 14, { fill: DARK });
    }
    box(foot, foot + d.flange, HALF.flange, { fill: STEEL, stroke: SOFT });
    box(foot, nose, HALF.cylinder, { fill: STEEL, stroke: SOFT });
    // The spool in the cylinder's rear.
    const [slot, room] = [foot + 0.008, 0.012 + SPOOL_FACTOR * hammer.spool_travel_m];
    box(slot, slot + room, 6, { fill: '#fff' }, y - 13);
    box(slot + SPOOL_FACTOR * pose.spool, slot + SPOOL_FACTOR * pose.spool + 0.012, 6, { fill: '#6a4c93' }, y - 13);
    // Piston between its chambers.
    box(pose.rear, pose.piston, HALF.bore, { fill: this.gas(h, 'pressure_rear_pa') });
    box(pose.piston + d.piston, wall, HALF.bore, { fill: this.gas(h, 'pressure_front_pa') });
    box(seat, mouth, HALF.collar + 3, { fill: '#fff' });
    painter.polygon([x(pose.shank), y - HALF.shank, x(pose.tip - 0.02), y - HALF.shank, x(pose.tip), y - 3, x(pose.tip), y + 3, x(pose.tip - 0.02), y + HALF.shank, x(pose.shank), y + HALF.shank], { fill: '#5d7f9e', stroke: INK });
    box(pose.collar, pose.collar + d.collar, HALF.collar, { fill: '#5d7f9e', stroke: INK });
    box(pose.piston, pose.piston + d.piston, HALF.bore, { fill: '#d9a441', stroke: INK });
    painter.text(hammer.name, x(-d.arm - d.edge) + 2, y - 60 + 6, { weight: 600, halo: true });
    const flash = (quantity, at, half, middle = y) => {
      const glow = this.glow(h, quantity);
      if (glow) painter.line([x(at), middle - half, x(at), middle + half], { color: FLASHED, width: 4, alpha: glow });
    };
    flash('percussion_force_n', pose.shank, HALF.bore);
    flash('rear_wall_force_n', pose.rear, HALF.bore);
    flash('nose_force_n', seat, HALF.collar + 4);
    flash('retainer_force_n', mouth, HALF.collar + 4);
    flash('top_stop_force_n', pose.guide, HALF.flange);
    flash('end_stop_force_n', front, HALF.flange);
    flash('spool_rear_force_n', slot, 8, y - 13);
    flash('spool_front_force_n', slot + room, 8, y - 13);
  }
  /** A casting before the hammers that strike it, its fixtures, and the machine's points behind them. */
  castingRows(painter, c, poses, x) {
    const d = DRAWN, rows = this.rows.map((h, row) => [h, row]).filter(([h]) => this.meta.hammers[h].casting === c);
    if (!rows.length) return;
    const { name, fixtures } = this.meta.castings[c], at = ([h, row]) => [poses[h].casting, (row + 0.5) * ROW];
    const [first, last] = [at(rows[0]), at(rows[rows.length - 1])], slope = rows.length > 1 ? (last[0] - first[0]) / (last[1] - first[1]) : 0;
    const [top, bottom] = [first[1] - HALF.casting, last[1] + HALF.casting];
    const rest = Math.max(...rows.map(([h]) => poses[h].face)), edge = (y) => first[0] + slope * (y - first[1]);
    painter.polygon([x(edge(top)), top, x(edge(top) + d.casting), top, x(edge(bottom) + d.casting), bottom, x(edge(bottom)), bottom], { fill: '#b98f7a', stroke: INK });
    painter.text(name, x(rest + d.casting / 2), top + 10, { align: 'center', weight: 600, halo: true });
    fixtures.forEach(({ name: fixture }, f) => {
      const y = top + (f + 0.5) * (bottom - top) / fixtures.length, from = rest + d.casting + this.casting(c, 'held', f, this.view.now);
      const table = rest + d.casting + d.fixture + this.factor * this.signals.fixture(c, f, 'point_displacement_m').at(this.view.now);
      const spring = Array.from({ length: 10 }, (_, k) => [x(from + (table - from) * (k / 9)), y + (k === 0 || k === 9 ? 0 : k % 2 ? -6 : 6)]);
      painter.line(spring.flat(), { color: SOFT, width: 1.5 });
      const half = Math.min(26, (bottom - top) / fixtures.length / 2 - 3);
      painter.rect(x(table), y - half, x(table + d.table) - x(table), 2 * half, { fill: DARK });
      painter.text(wrapped(fixture, 16, 1)[0], x(rest + d.casting + d.fixture / 2), y - 14, { size: 10, color: SOFT, align: 'center', halo: true });
    });
  }
}
