// The video with the outlines of things over it, which can be clicked at its first moment.

import { h } from "./dom.js";
import { showOutlines } from "./outlines.js";
import { equip, watchToEnd } from "./player.js";
import { mediaUrl } from "./server.js";
import { _, listed } from "./speech.js";

const FIRST_MOMENT_S = 0.15;

/**
 * Show a scene's video. `pick(id)` is called for a thing that is clicked; null if none can be.
 * `moved(t)` is called as the video goes on.
 */
export function showPicture(scene, pick, moved) {
  const video = h("video", {
    src: scene.video && mediaUrl(scene.video),
    // A poster of a rendered film may show a later moment, on which no outline fits.
    poster: scene.map.missing && scene.poster ? mediaUrl(scene.poster) : null,
    preload: "auto",
    muted: true,
    playsinline: true,
    disablepictureinpicture: true,
    "aria-label": _("The video"),
  });
  const outlines = showOutlines(scene, pick);
  const known = scene.things.filter((thing) => thing.outline);
  const isFollowed = known.length > 0 && known.every((thing) => thing.outline.moments);
  const come = known.filter((thing) => thing.outline.moments?.[0].time_s > FIRST_MOMENT_S).map((thing) => thing.number);
  const later = come.length ? _("Later in the video: %(numbers)s", { numbers: listed(come) }) : "";
  const hint = h("p", { class: "note" });
  const element = h(
    "div",
    { class: "picture player", "data-fps": scene.fps, "data-duration": scene.duration_s, "data-beside": scene.beside && JSON.stringify(scene.beside) },
    h("div", { class: "screen" }, video, outlines.element),
  );
  const player = equip(element, (t) => {
    const isFirst = t <= FIRST_MOMENT_S;
    outlines.at(t, isFirst);
    hint.textContent = isFirst ? later : isFollowed ? "" : scene.map.missing ? _("Outlines are shown at the start of the video.")
      : _("Outlines are shown at the start of the video. The map moves with it.");
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
    mark: outlines.mark,
  };
}
