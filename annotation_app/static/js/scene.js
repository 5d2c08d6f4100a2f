// What picture and map share: the things of a scene under numbers, from left to right.

/** A scene with numbered things and lettered places. */
export function numbered(scene) {
  // What is hidden in the picture is on the map only.
  const seen = scene.segmentation.objects.filter((o) => o.box && o.polygons.length);
  const outlines = new Map(seen.map((o) => [o.id, o]));
  const centre = (thing) => {
    const box = outlines.get(thing.id)?.box;
    return box ? box[0] + box[2] / 2 : 1e6 + thing.footprint[0][0];
  };
  const things = [...scene.map.objects].sort((a, b) => centre(a) - centre(b));
  const zones = [...scene.map.places].sort((a, b) => a.polygon[0][0] - b.polygon[0][0]);
  return {
    ...scene,
    turn: turnOf(things, outlines),
    things: things.map((thing, i) => ({
      ...thing,
      number: String(i + 1),
      outline: outlines.get(thing.id) ?? null,
      isRobot: thing.id === scene.map.robot,
    })),
    zones: zones.map((zone, i) => ({ ...zone, letter: letter(i) })),
  };
}

/** By how much the map is turned to lie as the picture does: what best fits where things are. */
function turnOf(things, outlines) {
  const pairs = things
    .filter((thing) => outlines.has(thing.id))
    .map((thing) => {
      const [x, y, w, tall] = outlines.get(thing.id).box;
      return [middle(thing.footprint), [x + w / 2, -(y + tall)]];
    });
  if (pairs.length < 2) return 0;
  const [onMap, inPicture] = [0, 1].map((side) => middle(pairs.map((pair) => pair[side])));
  let dot = 0;
  let cross = 0;
  for (const [[x, y], [u, v]] of pairs) {
    const [a, b, c, d] = [x - onMap[0], y - onMap[1], u - inPicture[0], v - inPicture[1]];
    dot += a * c + b * d;
    cross += a * d - b * c;
  }
  return Math.atan2(cross, dot);
}

const letter = (i) => (i < 26 ? String.fromCharCode(65 + i) : letter(Math.floor(i / 26) - 1) + letter(i % 26));

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
