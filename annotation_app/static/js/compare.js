// Where answers are compared: things, places and the map as the people who answered saw them.

import { labelLayer, unitOf } from "./label-layer.js";
import { boxAround } from "./labels.js";
import { numbered } from "./scene.js";

const MARGIN = 0.05;

const scene = numbered(JSON.parse(document.getElementById("scene").textContent));
const names = new Map([
  ...scene.things.map((thing) => [thing.id, thing.number]),
  ...scene.zones.map((zone) => [zone.id, zone.letter]),
]);
for (const element of document.querySelectorAll("[data-shown]")) {
  element.textContent = names.get(element.dataset.shown) ?? "";
}

const map = document.querySelector("svg.map");
if (map) turn();

/** Turn the map as people see it. */
function turn() {
  const [cos, sin] = [Math.cos(-scene.turn), Math.sin(-scene.turn)]; // y is downwards in SVG
  const turned = ({ x, y }) => ({ x: x * cos - y * sin, y: x * sin + y * cos });
  const corners = [];
  for (const polygon of map.querySelectorAll("polygon")) {
    const points = [...polygon.points].map(turned);
    polygon.setAttribute("points", points.map(({ x, y }) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" "));
    corners.push(...points);
  }
  const [xs, ys] = [corners.map(({ x }) => x), corners.map(({ y }) => y)];
  const size = Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys));
  const [left, top] = [Math.min(...xs) - MARGIN * size, Math.min(...ys) - MARGIN * size];
  const [right, bottom] = [Math.max(...xs) + MARGIN * size, Math.max(...ys) + MARGIN * size];
  map.setAttribute("viewBox", `${left} ${top} ${right - left} ${bottom - top}`);
}

for (const drawing of [document.querySelector(".frame svg"), map]) {
  if (drawing) label(drawing);
}

/** Label what the answers name; no label covers another, and what they differ in comes first. */
function label(drawing) {
  const caps = labelLayer();
  const labels = [...drawing.querySelectorAll("[data-label]")].map((outline) => ({
    id: outline.dataset.label,
    kind: outline.classList.contains("place") ? "place" : "object",
    text: String(names.get(outline.dataset.label) ?? "?"),
    box: boxAround([...outline.querySelectorAll("polygon")].flatMap((polygon) => [...polygon.points].map(({ x, y }) => [x, y]))),
    isChosen: outline.classList.contains("disputed"),
  }));
  drawing.append(caps.element);
  const { x, y, width: w, height: h } = drawing.viewBox.baseVal;
  new ResizeObserver(() => unitOf(drawing) && caps.put(labels, { x, y, w, h }, unitOf(drawing))).observe(drawing);
}
