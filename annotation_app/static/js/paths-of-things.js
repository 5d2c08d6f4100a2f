// Where things are at a moment of a video: outlines at some moments, and between them on the way.

const SAME_S = 0.002;
const LAST_S = 0.3; // for which an outline stays after its last moment

/** The polygons at a time; null before the first of `moments`, [{time_s, polygons}], which ascend. */
export function polygonsAt(moments, t) {
  const next = moments.findIndex((moment) => moment.time_s > t + SAME_S);
  if (next === 0) return null;
  const a = moments.at(next < 0 ? -1 : next - 1);
  const b = next < 0 ? null : moments[next];
  const isAlike = b && a.polygons.length === b.polygons.length && a.polygons.every((p, i) => p.length === b.polygons[i].length);
  if (!isAlike) return a.polygons;
  const share = Math.max(t - a.time_s, 0) / (b.time_s - a.time_s);
  return a.polygons.map((polygon, i) =>
    polygon.map(([x, y], k) => [x + share * (b.polygons[i][k][0] - x), y + share * (b.polygons[i][k][1] - y)]));
}

/** The polygons of what is seen at a time: null also after the last moment. */
export function seenAt(moments, t) {
  return t > moments.at(-1).time_s + LAST_S ? null : polygonsAt(moments, t);
}
