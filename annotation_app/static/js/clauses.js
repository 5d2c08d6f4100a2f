// The clauses of a command one after another, with their words marked in the command.

import { $, h } from "./dom.js";
import { payload } from "./work.js";
import { _ } from "./speech.js";

/** Buttons for all clauses. `isDone(node)` tells which have an answer; `go(node)` shows one. */
export function clauseBar(clauses, current, isDone, go) {
  return h(
    "nav",
    { class: "clause-bar", "aria-label": _("Clauses") },
    h(
      "ol",
      {},
      clauses.map((clause) =>
        h(
          "li",
          {},
          h(
            "button",
            {
              type: "button",
              class: `clause type-${clause.type}`,
              "aria-current": clause.node === current ? "step" : null,
              "data-key": `clause ${clause.node}`,
              onclick: () => go(clause.node),
            },
            h("bdi", {}, clause.phrase), " ",
            isDone(clause) ? h("span", { class: "tick-mark" }, h("span", { "aria-hidden": "true" }, "✓"), h("span", { class: "unseen" }, _("done"))) : null,
          ),
        ),
      ),
    ),
  );
}

/** Show the command with a clause's words marked, or none's if the node is null. */
export function showCommand(node) {
  const marks = node === null ? [] : spansOf(node);
  const characters = [...payload.command];
  const parts = [];
  let at = 0;
  for (const [text, start] of marks) {
    parts.push(characters.slice(at, start).join(""), h("mark", {}, text));
    at = start + [...text].length;
  }
  parts.push(characters.slice(at).join(""));
  $("command").replaceChildren(...parts);
}

/** The words of a clause, by its number in breadth-first order. */
function spansOf(node) {
  const queue = [...payload.sdcs];
  for (let i = 0; i < node; i += 1) {
    const clause = queue.shift();
    queue.push(...childrenOf(clause));
  }
  const found = [];
  const collect = (clause) => {
    for (const field of ["f", "r"]) {
      for (const word of clause[field] ?? []) if (Array.isArray(word)) found.push(word);
    }
    childrenOf(clause).forEach(collect);
  };
  collect(queue[0]);
  const unique = new Map(found.map((word) => [word[1], word]));
  return [...unique.values()].sort((a, b) => a[1] - b[1]);
}

const childrenOf = (clause) =>
  ["f", "l", "l2"].flatMap((field) => (clause[field] ?? []).filter((child) => !Array.isArray(child)));

/** The clause before or after another one. */
export function neighbour(clauses, node, step) {
  const at = clauses.findIndex((clause) => clause.node === node);
  return clauses[(at + step + clauses.length) % clauses.length].node;
}
