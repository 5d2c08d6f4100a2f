// The video with the outlines of things over it, which can be clicked at its first moment.

import { h, s } from "./dom.js";
import { equip, watchToEnd } from "./player.js";
import { mediaUrl } from "./server.js";

const FIRST_MOMENT_S = 0.15;

/**
 * Show a scene's video. `pick(id)` is called for a thing that is clicked; null if none can be.
 * `moved(t)` is called as the video goes on.
 */
export function showPicture(scene, pick, moved) {
  const { width, height } = scene.segmentation;
  const video = h("video", {
    src: scene.video && mediaUrl(scene.video),
    poster: scene.poster && mediaUrl(scene.poster),
    preload: "auto",
    muted: true,
    playsinline: true,
    disablepictureinpicture: true,
    "aria-label": "The video",
  });
  const shapes = new Map();
  const layer = s("svg", { class: "outlines", viewBox: `0 0 ${width || 1} ${height || 1}`, "aria-hidden": "true" });
  const unit = width / 640;
  const letter = (matchMedia("(max-width: 40rem)").matches ? 24 : 15) * unit;
  for (const thing of scene.things) {
    if (!thing.outline) continue;
    const d = thing.outline.polygons.map((p) => `M${p.map((xy) => xy.join(",")).join("L")}Z`).join("");
    const [x, y, w, tall] = thing.outline.box;
    const group = s(
      "g",
      { class: "thing", "data-id": thing.id, onclick: pick && (() => pick(thing.id)) },
      s("path", { class: "hit", d, "stroke-width": 14 * unit }),
      s("path", { class: "shape", d }),
      s("text", { x: x + w / 2, y: Math.max(y - 3 * unit, 0.95 * letter), "font-size": letter }, thing.number),
    );
    shapes.set(thing.id, group);
    layer.append(group);
  }
  const hint = h("p", { class: "note" });
  const element = h(
    "div",
    { class: "picture player", "data-fps": scene.fps, "data-duration": scene.duration_s },
    h("div", { class: "screen" }, video, layer),
  );
  const player = equip(element, (t) => {
    const isFirst = t <= FIRST_MOMENT_S;
    layer.classList.toggle("away", !isFirst);
    hint.textContent = isFirst ? "" : "Outlines are shown at the start of the video. The map moves with it.";
    moved(t);
  });
  element.append(hint);
  return {
    element,
    seek: player.seek,
    get time() { return player.time; },
    /** Have the video watched to its end: `watched({watched_s, speed})` is called when it has been. */
    requireWatching(alreadyWatched, watched) {
      watchToEnd(player, alreadyWatched, watched);
    },
    /** Mark what is chosen. */
    mark(ids) {
      for (const [id, group] of shapes) group.classList.toggle("chosen", ids.includes(id));
    },
  };
}
