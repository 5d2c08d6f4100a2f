// Where labels go, so that none covers another: a pure function of boxes, y downwards.

const GAP = 2;
const LARGE = 2.2; // times a label: on what is smaller a label would hide it
const RINGS = 3;
const DIRECTIONS = 16;

/** Whether two boxes {x, y, w, h} share anything. */
export const overlap = (a, b) => a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;

/**
 * Place labels: `wanted` is [{id, w, h, box, isMinor}] with the box of what each is about, the most
 * important first. Gives a Map from ids to {x, y, w, h, line}; `line` is where a line from the label
 * to its thing ends, [x, y], or null if the label is at its thing. Labels for which there is no
 * room are left out. All lie within `frame`; they keep off each other's small things while they can.
 * Minor ones do so always, and have no lines.
 */
export function layOut(wanted, frame) {
  const placed = new Map();
  const taken = [];
  for (const label of wanted) {
    const others = wanted.filter((other) => other !== label).map((other) => other.box);
    const open = [...candidates(label)].filter((spot) =>
      !(label.isMinor && spot.line) && isWithin(spot, frame) && !taken.some((box) => overlap(box, spot)));
    const clear = open.find((spot) => !others.some((box) => isSmall(box, label) && overlap(box, spot)));
    const spot = clear ?? (label.isMinor ? null : open[0]);
    if (!spot) continue;
    taken.push(spot);
    placed.set(label.id, spot);
  }
  return placed;
}

const isWithin = (spot, frame) =>
  spot.x >= frame.x && spot.y >= frame.y && spot.x + spot.w <= frame.x + frame.w && spot.y + spot.h <= frame.y + frame.h;

/** A label hides what is small; on a large thing another one's label does no harm. */
const isSmall = (box, label) => box.w * box.h < 6 * label.w * label.h;

/** Spots for a label: on its thing if that is large enough, around it, then further out with a line. */
function* candidates({ w, h, box }) {
  const [cx, cy] = [box.x + box.w / 2, box.y + box.h / 2];
  const spot = (x, y, line = null) => ({ x: x - w / 2, y: y - h / 2, w, h, line });
  const [aside, above] = [box.w / 2 + w / 2 + GAP, box.h / 2 + h / 2 + GAP];
  if (box.w >= LARGE * w && box.h >= LARGE * h) {
    yield spot(cx, cy);
    const [dx, dy] = [(box.w - w) / 2 - GAP, (box.h - h) / 2 - GAP];
    for (const [sx, sy] of [[0, -1], [0, 1], [-1, 0], [1, 0], [-1, -1], [1, -1], [-1, 1], [1, 1]]) yield spot(cx + sx * dx, cy + sy * dy);
  }
  yield spot(cx, cy - above);
  yield spot(cx, cy + above);
  yield spot(cx + aside, cy);
  yield spot(cx - aside, cy);
  for (const [sx, sy] of [[1, -1], [-1, -1], [1, 1], [-1, 1]]) yield spot(cx + sx * aside, cy + sy * above);
  for (let ring = 1; ring <= RINGS; ring += 1) {
    for (let k = 0; k < DIRECTIONS; k += 1) {
      const angle = -Math.PI / 2 + (2 * Math.PI * k) / DIRECTIONS;
      const [x, y] = [cx + Math.cos(angle) * (aside + ring * 0.8 * w), cy + Math.sin(angle) * (above + ring * 0.8 * h)];
      yield spot(x, y, [cx, cy]);
    }
  }
}

/** The box around corners. */
export function boxAround(corners) {
  const xs = corners.map(([x]) => x);
  const ys = corners.map(([, y]) => y);
  const [x, y] = [Math.min(...xs), Math.min(...ys)];
  return { x, y, w: Math.max(...xs) - x, h: Math.max(...ys) - y };
}
