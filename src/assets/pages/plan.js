// The machine from above: rails, castings, fixtures, and where the hammers stand.

/** Ends of all places of a plan, in m, with a margin. `points`: further places that it shows. */
function planEnds({ rails, castings, standing, tracks, points = [] }) {
  const corners = ({ centre_m: centre, outline_m: outline }) => (outline ? [0, 1].map((end) => outline.map((ends) => ends[end])) : [centre]);
  const near = [...points, ...standing.flat(), ...tracks.flatMap(({ hammers }) => hammers.flat()), ...castings.flatMap((one) => [...corners(one), ...one.fixtures.map(({ at }) => at)])];
  const all = near.length ? near : rails.flatMap(({ at }) => at);
  const ends = [0, 1].map((axis) => [Math.min(...all.map((at) => at[axis])), Math.max(...all.map((at) => at[axis]))]);
  const margin = 0.08 * Math.max(...ends.map(([low, high]) => high - low)) || 0.05;
  return ends.map(([low, high]) => [low - margin, high + margin]);
}

/** Where the hammers stand with other values of the factors that move them: each moves them from where they are proposed. */
function standingAt(plan, factors, place) {
  const from = plan.standing[0];
  if (!from) return [];
  return from.map((proposed, h) => {
    const moved = plan.tracks.map(({ factor, at, hammers }) => {
      const here = place[factors.findIndex(({ name }) => name === factor)], k = Math.max(1, at.findIndex((one) => one >= here - 1e-12));
      if (at.length < 2) return proposed;
      const t = Math.max(0, Math.min(1, (here - at[k - 1]) / (at[k] - at[k - 1] || 1)));
      return [0, 1].map((axis) => hammers[k - 1][h][axis] + t * (hammers[k][h][axis] - hammers[k - 1][h][axis]));
    });
    return [0, 1].map((axis) => moved.reduce((sum, one) => sum + one[axis] - proposed[axis], proposed[axis]));
  });
}

/** A mark with a letter or number in it. */
function marker(painter, x, y, text, { fill, radius = 9 }) {
  painter.dots([x, y], radius + 1.5, { color: PAPER });
  painter.dots([x, y], radius, { color: fill });
  painter.text(text, x, y + 0.5, { align: 'center', color: PAPER, size: radius + 2, weight: 700 });
}

/** Words for the kinds of fixtures. */
const FIXTURES = { spring: 'spring', pad: 'pad', clamp: 'clamp' };

/** A mark of a fixture from above: a triangle for a spring, a square for a pad, a ring with a cross for a clamp. */
function fixtureMark(painter, kind, x, y, color = SOFT) {
  if (kind === 'spring') painter.polygon([x - 5, y + 5, x + 5, y + 5, x, y - 5], { fill: color });
  else if (kind === 'pad') painter.rect(x - 5, y - 5, 10, 10, { fill: color });
  else {
    painter.dots([x, y], 6.5, { color });
    painter.dots([x, y], 4.5, { color: PAPER });
    painter.line([x - 3, y - 3, x + 3, y + 3], { color, width: 1.4 });
    painter.line([x - 3, y + 3, x + 3, y - 3], { color, width: 1.4 });
  }
}

/** The outline of a casting from above, if its size is known. */
function castingOutline(painter, { outline_m: outline }, [px, py], scale) {
  if (!outline) return;
  const [[x0, x1], [y0, y1]] = outline, box = [px(x0), py(y1), (x1 - x0) * scale, (y1 - y0) * scale];
  painter.rect(...box, { fill: BLUE, alpha: 0.12 });
  painter.rect(...box, { stroke: BLUE });
}

function drawCasting(painter, casting, [px, py], scale) {
  const { name, centre_m: centre, outline_m: outline, fixtures } = casting;
  castingOutline(painter, casting, [px, py], scale);
  if (outline) painter.text(`casting ${name}`, px(outline[0][0]) + 6, py(centre[1]), { color: BLUE });
  for (const { name: fixture, kind, at } of fixtures) {
    const [x, y] = [px(at[0]), py(at[1])], right = at[0] > centre[0];
    fixtureMark(painter, kind, x, y);
    painter.text(words(fixture), x + (right ? -8 : 8), y + (at[1] > centre[1] ? 12 : -10), { color: SOFT, size: 10, align: right ? 'right' : 'left', halo: true });
  }
}

/** The plan view to scale: the proposal A, alternatives by number, and the reader's placement B. `chosen()`: its place, or null. */
function planFigure(plan, factors, chosen) {
  const ends = planEnds(plan), [wide, tall] = ends.map(([low, high]) => high - low);
  const scaleOf = (width) => Math.min((width - 70) / wide, 330 / tall);
  return new Figure({
    title: 'Plan of the machine, from above', height: (width) => Math.round(scaleOf(width) * tall) + 50,
    paint(painter, width, height) {
      const scale = scaleOf(width), box = { left: 52, top: 8, width: scale * wide, height: height - 50 };
      axes(painter, box, { low: ends[0][0], high: ends[0][1], title: 'x (m)' }, { low: ends[1][0], high: ends[1][1], title: 'y (m)' });
      const px = (x) => box.left + (x - ends[0][0]) * scale, py = (y) => box.top + box.height - (y - ends[1][0]) * scale;
      const inside = ([x, y]) => [Math.max(ends[0][0], Math.min(ends[0][1], x)), Math.max(ends[1][0], Math.min(ends[1][1], y))];
      for (const casting of plan.castings) drawCasting(painter, casting, [px, py], scale);
      for (const { name, at } of plan.rails) {
        const line = at.map(inside).flatMap(([x, y]) => [px(x), py(y)]);
        painter.line(line, { color: GREY, width: 7, alpha: 0.7 });
        painter.text(words(name), line[line.length - 2] + 8, Math.max(box.top + 8, Math.min(box.top + box.height - 8, line[line.length - 1])), { color: SOFT, size: 10, halo: true });
      }
      for (const { hammers } of plan.tracks) plan.hammers.forEach((_, h) => painter.line(hammers.flatMap((at) => [px(at[h][0]), py(at[h][1])]), { color: ORANGE, width: 2, alpha: 0.6 }));
      this.marks = [];
      const stand = (at, text, fill, radius) => at.forEach(([x, y], h) => {
        marker(painter, px(x), py(y), text, { fill, radius });
        this.marks.push({ x: px(x), y: py(y), text: `${text === 'A' ? 'Proposal' : text === 'B' ? 'Placement B' : `Alternative ${text}`}, ${words(plan.hammers[h])}\nx ${short(x)} m, y ${short(y)} m` });
      });
      plan.standing.forEach((at, k) => { if (k) stand(at, String(k), SOFT, 7); });
      const place = chosen();
      if (place) stand(standingAt(plan, factors, place), 'B', BLUE, 9);
      if (plan.standing[0]) stand(plan.standing[0], 'A', ORANGE, 11);
    },
    hover(x, y) { return this.marks?.findLast((mark) => Math.hypot(mark.x - x, mark.y - y) < 12)?.text ?? ''; },
  });
}
