// Keeps the page for the next visit without a network, with the headers that isolate it where the server sends them. The
// build fills in VERSION and FILES. The page registers it as offline.js?threads where it uses the module with threads: only
// one of the two modules is kept.
const VERSION = "__VERSION__", UNUSED = `brittle_wasm${location.search === "?threads" ? "" : "_threads"}.wasm`;
const FILES = __FILES__.filter((file) => file !== UNUSED);

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
