// The scene from above, in metres, x to the right and y up.

import { h, s } from "./dom.js";
import { footprintAt, middle } from "./scene.js";

const STEP_M = 1;
const FINE_STEP_M = 0.25;
const FIRST_SIZE_M = 2;
const CLICK_M = 0.3;

const points = (polygon) => polygon.map(([x, y]) => `${x},${-y}`).join(" ");
const square = ([x, y], size) => {
  const r = size / 2;
  return [[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]];
};
const between = ([a, b], [c, d]) => [[a, b], [c, b], [c, d], [a, d]];
const rounded = (polygon) => polygon.map((xy) => xy.map((v) => Math.round(v * 100) / 100));

const MARGIN_M = 2.5;

function around(corners) {
  const xs = corners.map(([x]) => x);
  const ys = corners.map(([, y]) => y);
  const margin = MARGIN_M;
  return [Math.min(...xs) - margin, Math.min(...ys) - margin, Math.max(...xs) + margin, Math.max(...ys) + margin];
}

/**
 * Show a scene's map. `pick(kind, id)` is called with "object" or "place"; null if it is only
 * looked at. `marked(polygon)` is called for a place that was drawn.
 */
export function showMap(world, pick, marked) {
  // The map lies as the picture does; what is marked is turned back.
  const turned = (angle) => ([x, y]) => [
    x * Math.cos(angle) - y * Math.sin(angle),
    x * Math.sin(angle) + y * Math.cos(angle),
  ];
  const angle = world.turn;
  const view = (polygon) => polygon.map(turned(angle));
  const zonesInView = world.zones.map((zone) => ({ ...zone, polygon: view(zone.polygon) }));
  const scene = { ...world, zones: zonesInView };
  const [left, bottom, right, top] = around([
    ...world.things.flatMap((thing) => view(thing.footprint)),
    ...world.things.flatMap((thing) => view((thing.track ?? []).map(([, x, y]) => [x, y]))),
    ...zonesInView.flatMap((zone) => zone.polygon),
  ]);
  const unit = Math.max(right - left, top - bottom) / 100;
  const svg = s("svg", { class: "map", viewBox: `${left} ${-top} ${right - left} ${top - bottom}` });
  const zones = new Map();
  const things = new Map();
  for (let x = Math.ceil(left / 5) * 5; x < right; x += 5) svg.append(s("path", { class: "grid", d: `M${x},${-top}V${-bottom}` }));
  for (let y = Math.ceil(bottom / 5) * 5; y < top; y += 5) svg.append(s("path", { class: "grid", d: `M${left},${-y}H${right}` }));
  for (const zone of scene.zones) {
    const [x, y] = middle(zone.polygon);
    const group = s(
      "g",
      { class: "zone", "data-id": zone.id, onclick: pick && (() => isMarking || pick("place", zone.id)) },
      s("polygon", { points: points(zone.polygon) }),
      s("text", { x, y: -y, "font-size": 4 * unit }, zone.letter),
    );
    zones.set(zone.id, group);
    svg.append(group);
  }
  const drawn = s("g", { class: "drawn" });
  svg.append(drawn);
  for (const thing of scene.things) {
    const group = s(
      "g",
      { class: `thing${thing.isRobot ? " robot" : ""}`, "data-id": thing.id, onclick: pick && (() => isMarking || pick("object", thing.id)) },
      s("polygon", { class: "hit", "stroke-width": 2.4 * unit }),
      s("polygon", { class: "shape" }),
      s("text", { "font-size": 3.6 * unit }, thing.number),
    );
    things.set(thing.id, { thing, group });
    svg.append(group);
  }
  const cursor = s("polygon", { class: "cursor" });
  svg.append(cursor);

  let isMarking = false;
  let from = null;
  let centre = [(left + right) / 2, (bottom + top) / 2];
  let size = FIRST_SIZE_M;
  const help = h("p", { class: "note", role: "status" });
  const board = h("div", { class: "board", tabindex: -1, role: pick ? "application" : null, "aria-label": pick ? "Map. Use the list to choose things." : null }, svg);

  const at = (event) => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [point.x, -point.y];
  };
  const outline = (polygon) => cursor.setAttribute("points", polygon ? points(polygon) : "");

  svg.addEventListener("pointerdown", (event) => {
    if (!isMarking) return;
    from = at(event);
    svg.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  svg.addEventListener("pointermove", (event) => {
    if (!isMarking) return;
    centre = at(event);
    outline(from ? between(from, centre) : square(centre, size));
  });
  svg.addEventListener("pointerup", (event) => {
    if (!isMarking || !from) return;
    const to = at(event);
    const isClick = Math.hypot(to[0] - from[0], to[1] - from[1]) < CLICK_M;
    const polygon = isClick ? square(to, size) : between(from, to);
    from = null;
    finish(polygon);
  });
  board.addEventListener("keydown", (event) => {
    if (!isMarking) return;
    const step = event.shiftKey ? FINE_STEP_M : STEP_M;
    const by = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
    if (by) centre = [centre[0] + by[0], centre[1] + by[1]];
    else if (event.key === "+" || event.key === "=") size = Math.min(size + 0.5, 30);
    else if (event.key === "-") size = Math.max(size - 0.5, 0.5);
    else if (event.key === "Enter" || event.key === " ") return stopHere(event, () => finish(square(centre, size)));
    else if (event.key === "Escape") return stopHere(event, () => stop(true));
    else return;
    stopHere(event, () => {
      centre = [Math.min(Math.max(centre[0], left), right), Math.min(Math.max(centre[1], bottom), top)];
      outline(square(centre, size));
      help.textContent = `${size} m wide, at ${centre[0].toFixed(1)}, ${centre[1].toFixed(1)}. ${near()}`;
    });
  });

  function stopHere(event, then) {
    event.preventDefault();
    event.stopPropagation();
    then();
  }
  function near() {
    const distance = (thing) => {
      const [x, y] = middle(view(thing.footprint));
      return Math.hypot(x - centre[0], y - centre[1]);
    };
    const closest = [...scene.things].sort((a, b) => distance(a) - distance(b))[0];
    return closest ? `${distance(closest).toFixed(0)} m from thing ${closest.number}.` : "";
  }
  function finish(polygon) {
    stop(false);
    marked(rounded(polygon.map(turned(-angle))));
  }
  function stop(isCancelled) {
    isMarking = false;
    from = null;
    outline(null);
    board.classList.remove("marking");
    help.textContent = isCancelled ? "No place was marked." : "";
    board.dispatchEvent(new CustomEvent("stopped"));
  }
  function show(t) {
    for (const { thing, group } of things.values()) {
      const now = view(footprintAt(thing, t));
      const [x, y] = middle(now);
      const tall = Math.max(...now.map((corner) => corner[1])) - y;
      const isSmall = tall < 3 * unit;
      for (const polygon of group.querySelectorAll("polygon")) polygon.setAttribute("points", points(now));
      const label = group.querySelector("text");
      label.setAttribute("x", x);
      label.setAttribute("y", isSmall ? -y - tall - 2.2 * unit : -y);
    }
  }
  show(0);
  return {
    element: h("div", { class: "map-box" }, board, help),
    board,
    show,
    get isMarking() { return isMarking; },
    /** Mark what is chosen: ids of things and places, and corners of what was drawn. */
    mark(ids, placeIds, polygons) {
      for (const [id, { group }] of things) group.classList.toggle("chosen", ids.includes(id));
      for (const [id, group] of zones) group.classList.toggle("chosen", placeIds.includes(id));
      drawn.replaceChildren(...polygons.map((polygon) => s("polygon", { points: points(view(polygon)) })));
    },
    startMarking() {
      isMarking = true;
      board.classList.add("marking");
      outline(square(centre, size));
      help.textContent = "Drag over the map, or click. With keys: arrows move, + and − change the size, Enter sets it, Escape ends.";
      board.focus();
    },
    stop,
  };
}
