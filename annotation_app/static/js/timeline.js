// Timelines of a video, for the mouse, fingers and keys: a part of it with a handle at each end, or steps
// with a handle where each begins.

import { h } from "./dom.js";
import { _, number } from "./speech.js";

const SECOND = 1;
const REACH_PX = { mouse: 10, pen: 14, touch: 22 };
const LEAST_FRAME_PX = 8;
const USUAL_STEP_PX = 44;

const rounded = (seconds) => Math.round(1000 * seconds) / 1000;
const place = (part, t, duration) => part.style.setProperty("left", `${(100 * t) / duration}%`);

/** Follow a pointer until it is let go: `move(event)`, `end()`. */
function follow(event, move, end) {
  event.preventDefault();
  const target = event.currentTarget;
  target.setPointerCapture(event.pointerId);
  move(event);
  target.addEventListener("pointermove", move);
  target.addEventListener("lostpointercapture", () => {
    target.removeEventListener("pointermove", move);
    end();
  }, { once: true });
}

/** The time at which a pointer is on a track. */
function timeAt({ clientX }, track, duration) {
  const box = track.getBoundingClientRect();
  return Math.max(0, Math.min(1, (clientX - box.left) / box.width)) * duration;
}

/** Where a key moves a handle that is at `t`: a frame, a second, to either end; null for other keys. */
function timeByKey(event, t, { frame, duration }) {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
  const pages = { PageDown: -SECOND, PageUp: SECOND }[event.key];
  const to = event.key === "Home" ? 0 : event.key === "End" ? duration
    : steps ? t + steps * (event.shiftKey ? SECOND : frame)
    : pages ? t + pages : null;
  if (to === null) return null;
  event.preventDefault();
  event.stopPropagation();
  return to;
}

/** The nearest frame to a time, within limits. */
const onFrame = (t, low, high, frame) => rounded(Math.max(low, Math.min(high, Math.round(t / frame) * frame)));

/**
 * Show a part of a video. `duration` in seconds; `frame` is how long one frame lasts; `marks` are times that may be ends;
 * `moved(t)` is called while a handle or the cursor is moved, so that the video shows that moment;
 * `chosen([start, end])` when one has been set: null for an end that nobody has set yet.
 */
export function showTimeline({ duration, frame, marks = [], moved, chosen }) {
  const ends = [null, null];
  const NAMES = ["Start", "End"];
  const LABELS = [_("Start of the part"), _("End of the part")];
  const selection = h("div", { class: "selection" });
  const cursor = h("div", { class: "now" });
  const handles = NAMES.map((name, i) =>
    h("div", {
      class: `handle handle-${name.toLowerCase()}`, role: "slider", tabindex: 0, "aria-label": LABELS[i],
      "aria-valuemin": 0, "aria-valuemax": duration, "data-key": name,
      onkeydown: (event) => byKey(i, event),
      onpointerdown: (event) => {
        event.currentTarget.focus({ preventScroll: true });
        follow(event, (moving) => put(i, timeAt(moving, track, duration)), () => tell());
      },
    }),
  );
  const track = h("div", {
    class: "track",
    onpointerdown: (event) => event.target.closest(".handle") || follow(event, (moving) => seek(timeAt(moving, track, duration)), () => {}),
  }, selection, ...marks.map(tick), cursor, ...handles);
  const element = h("div", { class: "timeline", dir: "ltr" }, track);

  function tick(t) {
    const line = h("div", { class: "tick" });
    place(line, t, duration);
    return line;
  }
  const rest = (i) => ends[i] ?? (i ? duration : 0);
  /** Whole frames, and the start before the end. */
  function put(i, t) {
    const [low, high] = i ? [rest(0) + frame, duration] : [0, rest(1) - frame];
    ends[i] = onFrame(t, low, high, frame);
    draw();
    seek(ends[i]);
  }
  function seek(t) {
    place(cursor, t, duration);
    moved(t);
  }
  const tell = () => chosen([...ends]);

  function byKey(i, event) {
    const to = timeByKey(event, rest(i), { frame, duration });
    if (to === null) return;
    put(i, to);
    tell();
  }

  function draw() {
    handles.forEach((handle, i) => {
      const t = rest(i);
      place(handle, t, duration);
      handle.classList.toggle("unset", ends[i] === null);
      handle.setAttribute("aria-valuenow", t);
      handle.setAttribute("aria-valuetext", ends[i] === null ? _("not set") : _("%(time)s seconds", { time: number(t) }));
    });
    place(selection, rest(0), duration);
    selection.style.setProperty("width", `${(100 * (rest(1) - rest(0))) / duration}%`);
    selection.hidden = ends[0] === null && ends[1] === null;
  }
  draw();
  place(cursor, 0, duration);
  return {
    element,
    /** Set an end, 0 or 1, to a time of the video. */
    set(i, t) {
      put(i, t);
      tell();
    },
    /** Show a part, of which an end may be null. */
    show([start, end]) {
      [ends[0], ends[1]] = [start, end];
      draw();
    },
    /** Show where the video is. */
    at(t) { place(cursor, Math.min(t, duration), duration); },
  };
}

/**
 * Show steps, each from its beginning to the next one's. `moved(t, i)` is called while the cursor, or the beginning of
 * step `i`, is moved; `chosen(i, t)` when a beginning has been moved.
 *
 * Only what changes is drawn while something is dragged, so that an hour of steps takes no longer than one.
 */
export function showSteps({ duration, frame, moved, chosen }) {
  let steps = []; // {start_s, text, state}
  let current = 0;
  let zoom = 0; // the exponent of 2; 0 shows all
  let isZoomed = false; // by somebody
  let isHeld = false; // something is dragged
  const blocks = [];
  const handles = [];
  const cursor = h("div", { class: "now" });
  const track = h("div", { class: "track", onpointerdown: press }, cursor);
  const ruler = h("div", { class: "ruler", "aria-hidden": "true" });
  const view = h("div", { class: "view", role: "group", "aria-label": _("Timeline of the steps") }, h("div", { class: "reel" }, ruler, track));
  const button = (text, label, by) => h("button", { type: "button", class: "small", title: label, "aria-label": label, onclick: () => zoomBy(by) }, text);
  const out = button("−", _("Show a longer part"), -1);
  const into = button("+", _("Show a shorter part"), 1);
  const element = h("div", { class: "timeline step-timeline", dir: "ltr" }, view, h("div", { class: "zoom" }, out, into));

  const limits = (i) => [(steps[i - 1]?.start_s ?? 0) + frame, (steps[i + 1]?.start_s ?? duration) - frame];
  const end = (i) => steps[i + 1]?.start_s ?? duration;

  /** Draw the beginning of a step, and both steps that meet there. */
  function drawAt(i) {
    const { start_s } = steps[i];
    for (const j of [i - 1, i]) {
      if (!blocks[j]) continue;
      place(blocks[j], steps[j].start_s, duration);
      blocks[j].style.setProperty("width", `${(100 * (end(j) - steps[j].start_s)) / duration}%`);
    }
    place(handles[i], start_s, duration);
    handles[i].setAttribute("aria-valuenow", start_s);
    handles[i].setAttribute("aria-valuetext", _("%(time)s seconds", { time: number(start_s, 2) }));
  }

  function put(i, t) {
    const to = onFrame(t, ...limits(i), frame);
    if (to !== steps[i].start_s) {
      steps[i] = { ...steps[i], start_s: to };
      drawAt(i);
    }
    place(cursor, to, duration);
    moved(to, i);
  }

  function press(event) {
    const t = timeAt(event, track, duration);
    isHeld = true;
    const reach = ((REACH_PX[event.pointerType] ?? REACH_PX.mouse) * duration) / track.clientWidth;
    let nearest = 0;
    for (let i = 1; i < steps.length; i += 1) {
      if (!nearest || Math.abs(steps[i].start_s - t) < Math.abs(steps[nearest].start_s - t)) nearest = i;
    }
    if (!nearest || Math.abs(steps[nearest].start_s - t) > reach) {
      return follow(event, (moving) => seek(timeAt(moving, track, duration)), () => (isHeld = false));
    }
    const before = steps[nearest].start_s;
    const grabbed = t - before; // the handle stays under the finger where it was taken
    focus(nearest);
    follow(event, (moving) => put(nearest, timeAt(moving, track, duration) - grabbed), () => {
      isHeld = false;
      if (steps[nearest] && steps[nearest].start_s !== before) chosen(nearest, steps[nearest].start_s);
    });
  }
  function seek(t) {
    place(cursor, t, duration);
    moved(t);
  }
  function focus(i) {
    handles.forEach((handle, j) => (handle.tabIndex = j === i ? 0 : -1));
    handles[i].focus({ preventScroll: true });
  }
  function byKey(handle, event) {
    const i = handles.indexOf(handle);
    const to = timeByKey(event, steps[i].start_s, { frame, duration });
    if (to === null) return;
    const before = steps[i].start_s;
    put(i, to);
    if (steps[i].start_s !== before) chosen(i, steps[i].start_s);
  }

  /** Show half as much for each step of zooming, or twice as much. */
  function zoomBy(by) {
    isZoomed = true;
    setZoom(zoom + by);
  }
  function most() {
    return Math.max(0, Math.ceil(Math.log2((LEAST_FRAME_PX * duration) / frame / (view.clientWidth || 1))));
  }
  function setZoom(to) {
    zoom = Math.max(0, Math.min(most(), to));
    view.firstChild.style.setProperty("width", `${100 * 2 ** zoom}%`);
    out.disabled = zoom === 0;
    into.disabled = zoom === most();
    drawRuler();
    keepInView();
  }
  /** A label every so many seconds, so that they don't meet. */
  function drawRuler() {
    const width = track.clientWidth || 1;
    const wanted = (70 * duration) / width;
    const every = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600].find((s) => s >= wanted) ?? 1800;
    const labels = [];
    for (let n = 0; n * every < duration - every / 3 && labels.length < 2000; n += 1) {
      const label = h("span", {}, number(n * every, every < 1 ? 1 : 0));
      place(label, n * every, duration);
      labels.push(label);
    }
    ruler.replaceChildren(...labels);
  }
  let shown = 0;
  function keepInView() {
    if (!zoom) return;
    const x = (shown / duration) * track.clientWidth;
    const margin = view.clientWidth / 8;
    if (x < view.scrollLeft + margin || x > view.scrollLeft + view.clientWidth - margin) view.scrollLeft = x - view.clientWidth / 3;
  }
  new ResizeObserver(() => {
    if (isZoomed) return setZoom(zoom);
    // Steps wide enough to be read and hit.
    setZoom(Math.ceil(Math.log2(Math.max(1, (steps.length * USUAL_STEP_PX) / (view.clientWidth || 1)))));
  }).observe(view);

  return {
    element,
    zoomBy,
    /** Show steps: when each begins, its text, and its state as a class. */
    show(next) {
      steps = next;
      while (blocks.length > steps.length) {
        blocks.pop().remove();
        handles.pop().remove();
      }
      while (blocks.length < steps.length) {
        const block = h("div", { class: "block" }, h("span", { dir: "auto" }));
        const handle = h("div", {
          class: "boundary", role: "slider", tabindex: -1, "aria-valuemin": 0, "aria-valuemax": duration,
          onkeydown: (event) => byKey(handle, event),
        });
        handle.hidden = !handles.length;
        blocks.push(block);
        handles.push(handle);
        cursor.before(block);
        track.append(handle);
      }
      steps.forEach(({ text, state }, i) => {
        blocks[i].dataset.state = state;
        if (blocks[i].firstChild.textContent !== text) blocks[i].firstChild.textContent = text;
        blocks[i].title = text;
        handles[i].setAttribute("aria-label", _("Beginning of step %(number)s", { number: i + 1 }));
        drawAt(i);
      });
      if (!handles.some((handle) => handle.tabIndex === 0)) handles.slice(1, 2).forEach((handle) => (handle.tabIndex = 0));
      view.tabIndex = handles.length > 1 ? -1 : 0; // what scrolls has something to focus
    },
    /** Mark the step at which the video is. */
    mark(i) {
      blocks[current]?.classList.remove("current");
      current = i;
      blocks[i]?.classList.add("current");
    },
    /** Show where the video is. */
    at(t) {
      if (isHeld) return; // the cursor is under the finger
      shown = Math.min(t, duration);
      place(cursor, shown, duration);
      keepInView();
    },
    focus,
  };
}
