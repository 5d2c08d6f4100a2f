// The scene from above, in metres, turned as the picture is; x to the right and y up.

import { h, s } from "./dom.js";
import { boxAround } from "./labels.js";
import { labelLayer, unitOf } from "./label-layer.js";
import { hit } from "./map-hits.js";
import { marking } from "./map-marking.js";
import { zoomable } from "./map-view.js";
import { footprintAt } from "./scene.js";
import { data } from "./work.js";
import { _ } from "./speech.js";

const MARGIN_M = 2.5;
const GRID_M = 5;
const REACH_PX = 22;
const FLATTEST = 0.7;

const points = (polygon) => polygon.map(([x, y]) => `${x},${-y}`).join(" ");
const down = (polygon) => polygon.map(([x, y]) => [x, -y]);
const rounded = (polygon) => polygon.map((xy) => xy.map((v) => Math.round(v * 100) / 100));

/** Lines of a grid, also beside a frame, where the drawing's box may be wider. */
function grid({ x, y, w, h: tall }) {
  const steps = (from, to) => Array.from({ length: Math.ceil((to - from) / GRID_M) }, (_, i) => (Math.ceil(from / GRID_M) + i) * GRID_M);
  const upright = steps(x - w, x + 2 * w).map((at) => `M${at},${y - tall}v${3 * tall}`);
  const level = steps(y - tall, y + 2 * tall).map((at) => `M${x - w},${at}h${3 * w}`);
  return s("path", { class: "grid", d: [...upright, ...level].join("") });
}

/** A frame around a box with room for labels, not too flat. */
function framed({ x, y, w, h: tall }) {
  const height = Math.max(tall + 2 * MARGIN_M, FLATTEST * w);
  return { x: x - MARGIN_M, y: y + (tall - height) / 2, w: w + 2 * MARGIN_M, h: height };
}

/**
 * Show a scene's map. `pick(kind, id)` is called with "object" or "place"; null if it is only
 * looked at. `marked(polygon)` is called for a place that was drawn.
 */
export function showMap(scene, pick, marked) {
  // The map lies as the picture does; what is marked is turned back.
  const turned = (angle) => ([x, y]) => [x * Math.cos(angle) - y * Math.sin(angle), x * Math.sin(angle) + y * Math.cos(angle)];
  const seen = (polygon) => polygon.map(turned(scene.turn));
  const zones = scene.zones.map((zone) => ({ ...zone, kind: "place", polygon: seen(zone.polygon) }));
  // What is on something else is drawn after it.
  const things = [...scene.things].sort((a, b) => a.z - b.z).map((thing) => ({ ...thing, kind: "object", polygon: seen(thing.footprint) }));
  const tracks = things.flatMap((thing) => seen((thing.track ?? []).map(([, x, y]) => [x, y])));
  const corners = [...things, ...zones].flatMap(({ polygon }) => polygon).concat(tracks);
  const around = boxAround(down(corners.length ? corners : [[0, 0]])); // a picture may have no things
  const whole = framed(around);

  const svg = s("svg", { class: "map", viewBox: `${whole.x} ${whole.y} ${whole.w} ${whole.h}` });
  svg.append(grid(whole));
  for (const thing of things) {
    thing.group = s("g", { class: `thing${thing.isRobot ? " robot" : ""}`, "data-id": thing.id }, s("polygon", { class: "shape" }));
    svg.append(thing.group);
  }
  // Places lie over things and are seen through: one may be on a thing.
  const drawn = s("g", { class: "drawn" });
  for (const zone of zones) {
    zone.group = s("g", { class: "zone", "data-id": zone.id }, s("polygon", { points: points(zone.polygon) }));
    svg.append(zone.group);
  }
  const labels = labelLayer();
  const legend = [
    _("Seen from above."),
    things.some((thing) => thing.isRobot) ? _("Green: %(robot)s.", data.labels) : "",
    zones.length ? _("Dashed: places.") : "",
  ].filter(Boolean).join(" ");
  const help = h("p", { class: "note", role: "status" }, legend);
  const board = h("div", { class: "board", tabindex: -1, role: pick ? "application" : null, "aria-label": pick ? _("Map. Use the list to choose things.") : null }, svg);

  let wanted = null;
  let isPlanned = false;
  const zoomed = zoomable(svg, whole, () => marker.isMarking, label);
  const marker = marking({
    svg, board, help, legend,
    view: () => zoomed.view,
    things: () => things,
    finish: (polygon) => marked(rounded(polygon.map(turned(-scene.turn)))),
  });
  svg.append(drawn, labels.element, marker.cursor);

  function under(event) {
    const cap = event.target.closest?.(".cap");
    if (cap) return { kind: cap.dataset.kind, id: cap.dataset.id };
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return hit([...things, ...zones], [point.x, -point.y], wanted, REACH_PX * unitOf(svg));
  }
  function lighten(shape) {
    for (const { group, id, kind } of [...things, ...zones]) group.classList.toggle("hover", shape?.id === id && shape.kind === kind);
    svg.classList.toggle("at-something", Boolean(shape));
  }
  if (pick) {
    svg.addEventListener("pointermove", (event) => lighten(marker.isMarking || event.pointerType === "touch" ? null : under(event)));
    svg.addEventListener("pointerleave", () => lighten(null));
    // A second click of a double click would answer the next question.
    svg.addEventListener("click", (event) => {
      const shape = zoomed.wasDragged || justMarked || event.detail > 1 ? null : under(event);
      justMarked = false;
      if (shape && !marker.isMarking) pick(shape.kind, shape.id);
    });
  }
  // The click that ends the drawing of a place chooses nothing.
  let justMarked = false;
  svg.addEventListener("pointerdown", () => (justMarked = marker.isMarking), { capture: true });

  /** Labels are laid out anew, once for all that changes at a time. */
  function label() {
    if (isPlanned) return;
    isPlanned = true;
    requestAnimationFrame(() => {
      isPlanned = false;
      const unit = unitOf(svg);
      if (!unit) return;
      const shown = [...things, ...zones].map((one) => ({
        id: one.id, kind: one.kind, text: one.number ?? one.letter, box: boxAround(down(one.polygon)),
        isChosen: one.group.classList.contains("chosen"),
        isMinor: Boolean(wanted) && one.kind !== wanted,
      }));
      // What is asked for has the best spots, and small things before large ones.
      shown.sort((a, b) => a.isMinor - b.isMinor || a.box.w * a.box.h - b.box.w * b.box.h);
      labels.put(shown, zoomed.view, unit);
    });
  }
  new ResizeObserver(label).observe(svg);

  function show(t) {
    for (const thing of things) {
      thing.polygon = seen(footprintAt(thing, t));
      thing.group.firstChild.setAttribute("points", points(thing.polygon));
    }
    label();
  }
  show(0);
  return {
    element: h("div", { class: "map-box" }, board, h("div", { class: "map-foot" }, help, zoomed.element)),
    board,
    show,
    get isMarking() { return marker.isMarking; },
    /** What a click means where a thing and a place lie over each other: "object" or "place". */
    prefer(kind) {
      wanted = kind;
      label();
    },
    /** Mark what is chosen: ids of things and places, and corners of what was drawn. */
    mark(ids, placeIds, polygons) {
      for (const { id, group } of things) group.classList.toggle("chosen", ids.includes(id));
      for (const { id, group } of zones) group.classList.toggle("chosen", placeIds.includes(id));
      drawn.replaceChildren(...polygons.map((polygon) => s("polygon", { points: points(seen(polygon)) })));
      label();
    },
    startMarking: marker.start,
    stop: marker.stop,
  };
}
