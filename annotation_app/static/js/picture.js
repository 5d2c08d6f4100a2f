// The video with the outlines of things over it, which can be clicked at its first moment.

import { h, s } from "./dom.js";
import { watchToEnd } from "./player.js";
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
    poster: scene.map.missing && scene.poster ? mediaUrl(scene.poster) : null,
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
  const duration = scene.duration_s;
  const slider = h("input", { type: "range", min: 0, max: duration, step: 0.1, value: 0, "aria-label": "Time in the video, in seconds" });
  const play = h("button", { type: "button", class: "play" }, "Play");
  const toStart = h("button", { type: "button" }, "To the start");
  const clock = h("output", { class: "clock" }, "0.0 s");
  const hint = h("p", { class: "note" });

  function seek(t) {
    video.currentTime = t;
    show(t);
  }
  function show(t) {
    slider.value = t;
    slider.setAttribute("aria-valuetext", `${t.toFixed(1)} seconds`);
    clock.textContent = `${t.toFixed(1)} / ${duration.toFixed(1)} s`;
    const isFirst = t <= FIRST_MOMENT_S;
    layer.classList.toggle("away", !isFirst);
    toStart.disabled = isFirst;
    hint.textContent = isFirst ? "" : "Outlines are shown at the start of the video. The map moves with it.";
    moved(t);
  }
  slider.addEventListener("input", () => {
    video.pause();
    seek(Number(slider.value));
  });
  toStart.addEventListener("click", () => {
    video.pause();
    seek(0);
  });
  play.addEventListener("click", () => (video.paused ? video.play() : video.pause()));
  for (const name of ["play", "pause", "ended"]) {
    video.addEventListener(name, () => (play.textContent = video.paused ? "Play" : "Pause"));
  }
  video.addEventListener("timeupdate", () => show(video.currentTime));

  const note = h("p", { class: "note", role: "status" });

  const element = h(
    "div",
    { class: "picture" },
    h("div", { class: "screen" }, video, layer),
    h("div", { class: "transport" }, play, toStart, slider, clock),
    note,
    hint,
  );
  show(0);
  return {
    element,
    seek,
    get time() { return video.currentTime || 0; },
    /** Have the video watched to its end: `watched(seconds)` is called when it has been. */
    requireWatching(alreadyWatched, watched) {
      watchToEnd(video, note, alreadyWatched, watched);
    },
    /** Mark what is chosen. */
    mark(ids) {
      for (const [id, group] of shapes) group.classList.toggle("chosen", ids.includes(id));
    },
  };
}
