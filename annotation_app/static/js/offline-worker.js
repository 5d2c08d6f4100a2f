// Keeps one page with its style for times without a connection. Nothing else is kept or answered here.

const PAGE = "offline";
const CACHE = "offline";

self.addEventListener("install", (event) => event.waitUntil(keep().then(() => self.skipWaiting())));

async function keep() {
  const page = await fetch(PAGE, { cache: "reload" });
  const styles = [...(await page.clone().text()).matchAll(/<(?:link|img)[^>]*(?:href|src)="([^"]+)"/g)].map(([, url]) => url);
  await caches.delete(CACHE);
  const cache = await caches.open(CACHE);
  await Promise.all([cache.put(PAGE, page), cache.addAll([...new Set(styles)])]);
}

self.addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.method !== "GET") return;
  if (request.mode === "navigate") event.respondWith(fetch(request).catch(() => caches.match(PAGE)));
  else if (["style", "image"].includes(request.destination) && request.url.includes("/static/")) {
    event.respondWith(fetch(request).catch(async () => (await caches.match(request)) ?? Response.error()));
  }
});
