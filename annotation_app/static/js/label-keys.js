// Keys for labels: 1, 12, A, AA. A label that begins a longer one waits for what follows.

const WAIT_MS = 900;

/**
 * Read labels from keys. `all()` gives all that there are; `found(label)` is called for one that is
 * complete. Gives a function of a key that tells whether the key belongs to a label.
 */
export function labelKeys(all, found) {
  let typed = "";
  let timer = 0;

  function settle() {
    clearTimeout(timer);
    const label = typed;
    typed = "";
    if (all().includes(label)) found(label);
  }

  return function press(key) {
    const next = key.length === 1 ? key.toUpperCase() : "";
    if (!next) return false;
    const labels = all();
    if (typed && !labels.some((label) => label.startsWith(typed + next))) settle();
    if (!labels.some((label) => label.startsWith(typed + next))) return false;
    typed += next;
    clearTimeout(timer);
    if (labels.some((label) => label !== typed && label.startsWith(typed))) timer = setTimeout(settle, WAIT_MS);
    else settle();
    return true;
  };
}
