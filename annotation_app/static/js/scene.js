// What picture and map share: the things of a scene under numbers, from left to right.

/** A scene with numbered things and lettered places; `turn` is how its map lies as the picture does. */
export function numbered(scene) {
  // What is hidden in the picture is on the map only.
  const seen = scene.segmentation.objects.filter((o) => o.box && o.polygons.length);
  const outlines = new Map(seen.map((o) => [o.id, o]));
  const centre = (thing) => {
    const { box, is_drawn } = outlines.get(thing.id) ?? {};
    // What people have drawn comes after what there was.
    return is_drawn ? 2e6 + box[0] : box ? box[0] + box[2] / 2 : 1e6 + thing.footprint[0][0];
  };
  const things = [...scene.map.objects].sort((a, b) => centre(a) - centre(b));
  const turn = scene.map.turn ?? 0;
  const across = ({ polygon: [[x, y]] }) => x * Math.cos(turn) - y * Math.sin(turn);
  const zones = [...scene.map.places].sort((a, b) => across(a) - across(b));
  return {
    ...scene,
    turn,
    things: things.map((thing, i) => ({
      ...thing,
      number: String(i + 1),
      outline: outlines.get(thing.id) ?? null,
      isRobot: thing.id === scene.map.robot,
    })),
    zones: zones.map((zone, i) => ({ ...zone, letter: letter(i) })),
  };
}

// I and O look like 1 and 0; K, M, S, X and Y are keys of the page.
const LETTERS = "ABCDEFGHJLNPQRTUVWZ";

/** A, B, ..., AA, AB, ... */
const letter = (i) => {
  const last = LETTERS[i % LETTERS.length];
  return i < LETTERS.length ? last : letter(Math.floor(i / LETTERS.length) - 1) + last;
};

/** A thing's footprint at a time of the video. */
export function footprintAt(thing, t) {
  const track = thing.track;
  if (!track?.length) return thing.footprint;
  const [, x0, y0, yaw0] = track[0];
  let i = track.findIndex((row) => row[0] >= t);
  if (i < 0) i = track.length - 1;
  const [, x, y, yaw] = track[i];
  const cos = Math.cos(yaw - yaw0);
  const sin = Math.sin(yaw - yaw0);
  return thing.footprint.map(([px, py]) => [
    x + (px - x0) * cos - (py - y0) * sin,
    y + (px - x0) * sin + (py - y0) * cos,
  ]);
}

export function middle(polygon) {
  const sum = polygon.reduce(([x, y], [px, py]) => [x + px, y + py], [0, 0]);
  return [sum[0] / polygon.length, sum[1] / polygon.length];
}
