// Have the browser show a page of ours where the study can't be reached.

const root = document.querySelector('meta[name="root"]')?.content ?? "";
navigator.serviceWorker?.register(`${root}/offline-worker.js`).catch(() => {});
