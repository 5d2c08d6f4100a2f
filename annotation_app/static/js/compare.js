// Where answers are compared: things, places and the map as the people who answered saw them.

import { numbered } from "./scene.js";

const MARGIN = 0.05;
const LETTER = 0.05;

const scene = numbered(JSON.parse(document.getElementById("scene").textContent));
const names = new Map([
  ...scene.things.map((thing) => [thing.id, thing.number]),
  ...scene.zones.map((zone) => [zone.id, zone.letter]),
]);
for (const element of document.querySelectorAll("[data-shown]")) {
  element.textContent = names.get(element.dataset.shown) ?? "";
}

const map = document.querySelector("svg.map");
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
for (const text of map.querySelectorAll("text")) {
  const { x, y } = turned({ x: Number(text.getAttribute("x")), y: Number(text.getAttribute("y")) });
  text.setAttribute("x", x);
  text.setAttribute("y", y);
  text.setAttribute("font-size", LETTER * size);
}
