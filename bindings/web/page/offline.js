// Keeps the page for the next visit without a network. The build fills in VERSION and FILES.
const VERSION = "__VERSION__", FILES = __FILES__;

self.addEventListener("install", (event) => event.waitUntil((async () => {
    await (await caches.open(VERSION)).addAll(FILES);
    await self.skipWaiting();
})()));
self.addEventListener("activate", (event) => event.waitUntil((async () => {
    for (const name of await caches.keys())
        if (name !== VERSION) await caches.delete(name);
    await self.clients.claim();
})()));
self.addEventListener("fetch", (event) => {
    if (event.request.method !== "GET") return;
    event.respondWith((async () => await caches.match(event.request, { ignoreSearch: true, cacheName: VERSION }) ?? fetch(event.request))());
});
