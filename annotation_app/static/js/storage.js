// What the browser keeps when a tab is closed. In frames it may be switched off: then it is kept
// as long as the page is open.

const inPage = new Map();
const inBrowser = storageOfBrowser();

function storageOfBrowser() {
  try {
    return window.localStorage;
  } catch {
    return null;
  }
}

export const read = (name) => (inBrowser ? inBrowser.getItem(name) : (inPage.get(name) ?? null));

/** Throws if the browser's storage is full. */
export function write(name, text) {
  if (inBrowser) inBrowser.setItem(name, text);
  else inPage.set(name, text);
}

/** Keep what holds for this page anyway: the storage may be full. */
export function keep(name, text) {
  try {
    write(name, text);
  } catch {
    // as said above
  }
}

export function erase(name) {
  inPage.delete(name);
  inBrowser?.removeItem(name);
}

export const names = () => (inBrowser ? Object.keys(inBrowser) : [...inPage.keys()]);
