// Marking a place on the map: by dragging, by a click, or with the arrow keys.

import { s } from "./dom.js";
import { middle } from "./scene.js";
import { _, decimal, number } from "./speech.js";

const STEP_M = 1;
const FINE_STEP_M = 0.25;
const FIRST_SIZE_M = 2;
const CLICK_M = 0.3;

const square = ([x, y], size) => {
  const r = size / 2;
  return [[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]];
};
const between = ([a, b], [c, d]) => [[a, b], [c, b], [c, d], [a, d]];

/**
 * Let places be marked on a map's SVG, whose y goes down. `help` is what they are told, `legend` when nothing
 * is being marked. `view()` is the part that is shown, {x, y, w, h}; `things()` what is on it, [{number, polygon}]; `finish(polygon)` gets what was drawn, y upwards.
 */
export function marking({ svg, board, help, legend, view, things, finish }) {
  let isMarking = false;
  let from = null;
  let centre = [0, 0];
  let size = FIRST_SIZE_M;
  const cursor = s("polygon", { class: "cursor" });
  const outline = (polygon) => cursor.setAttribute("points", polygon ? polygon.map(([x, y]) => `${x},${-y}`).join(" ") : "");
  const at = (event) => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [point.x, -point.y];
  };

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
    stop(false);
    finish(polygon);
  });
  board.addEventListener("keydown", (event) => {
    if (!isMarking) return;
    const step = event.shiftKey ? FINE_STEP_M : STEP_M;
    const by = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
    if (by) centre = [centre[0] + by[0], centre[1] + by[1]];
    else if (event.key === "+" || event.key === "=") size = Math.min(size + 0.5, 30);
    else if (event.key === "-") size = Math.max(size - 0.5, 0.5);
    else if (event.key === "Enter" || event.key === " ") {
      stop(false);
      finish(square(centre, size));
    } else if (event.key === "Escape") stop(true);
    else return;
    event.preventDefault();
    event.stopPropagation();
    if (!isMarking) return;
    const { x, y, w, h } = view();
    centre = [Math.min(Math.max(centre[0], x), x + w), Math.min(Math.max(centre[1], -y - h), -y)];
    outline(square(centre, size));
    help.textContent = `${_("%(size)s m wide, at %(x)s; %(y)s.", { size: decimal(size), x: number(centre[0]), y: number(centre[1]) })} ${near()}`;
  });

  function near() {
    const distance = ({ polygon }) => Math.hypot(...middle(polygon).map((v, i) => v - centre[i]));
    const closest = [...things()].sort((a, b) => distance(a) - distance(b))[0];
    return closest ? _("%(distance)s m from thing %(number)s.", { distance: number(distance(closest), 0), number: closest.number }) : "";
  }
  function start() {
    const { x, y, w, h } = view();
    isMarking = true;
    centre = [x + w / 2, -y - h / 2];
    board.classList.add("marking");
    outline(square(centre, size));
    help.textContent = _("Drag over the map, or click. With keys: arrows move, + and − change the size, Enter sets it, Escape ends.");
    board.focus();
  }
  function stop(isCancelled) {
    isMarking = false;
    from = null;
    outline(null);
    board.classList.remove("marking");
    help.textContent = isCancelled ? _("No place was marked.") : legend;
    board.dispatchEvent(new CustomEvent("stopped"));
  }
  return { cursor, start, stop, get isMarking() { return isMarking; } };
}
