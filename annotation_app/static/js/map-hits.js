// What a point on the map is about.

/** How far from a polygon a point is; 0 within it. */
export function distanceTo(polygon, [x, y]) {
  let isIn = false;
  let least = Infinity;
  polygon.forEach(([x1, y1], i) => {
    const [x2, y2] = polygon[(i + 1) % polygon.length];
    if (y1 > y !== y2 > y && x < x1 + ((y - y1) / (y2 - y1)) * (x2 - x1)) isIn = !isIn;
    const [dx, dy] = [x2 - x1, y2 - y1];
    const share = dx || dy ? Math.min(1, Math.max(0, ((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy))) : 0;
    least = Math.min(least, Math.hypot(x - x1 - share * dx, y - y1 - share * dy));
  });
  return isIn ? 0 : least;
}

export function areaOf(polygon) {
  const twice = polygon.reduce((sum, [x1, y1], i) => {
    const [x2, y2] = polygon[(i + 1) % polygon.length];
    return sum + x1 * y2 - x2 * y1;
  }, 0);
  return Math.abs(twice) / 2;
}

/**
 * What is meant by a point: one of `shapes`, [{kind, id, polygon}], or null. What is asked for
 * (`wanted`, a kind) comes before what lies at the same place, and small things before large
 * ones. Points up to `reach` beside a thing still mean it.
 */
export function hit(shapes, point, wanted, reach) {
  const found = shapes
    .map((shape) => ({ shape, far: distanceTo(shape.polygon, point), area: areaOf(shape.polygon) }))
    .filter(({ far }) => far <= reach)
    .map((one) => ({ ...one, cost: one.far + (wanted && one.shape.kind !== wanted ? 1.01 * reach : 0) }))
    .sort((a, b) => a.cost - b.cost || a.area - b.area);
  return found[0]?.shape ?? null;
}
