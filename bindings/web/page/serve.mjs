// Serves the page on this machine: node serve.mjs NPM FOLDER PORT [--not-isolated]
// The page is cross-origin isolated, so that it may use threads; with the option it is not, as on servers that know of no headers.
import { createServer } from "node:http";
import { createRequire } from "node:module";
import path from "node:path";

const [npm, folder, port, option] = process.argv.slice(2);
const isolated = option !== "--not-isolated";
const sirv = createRequire(path.join(path.resolve(npm), "package.json"))("sirv");
const files = sirv(folder, { dev: true, gzip: true, etag: true, setHeaders(response) {
    response.setHeader("Cache-Control", "no-cache");
    if (!isolated) return;
    response.setHeader("Cross-Origin-Opener-Policy", "same-origin");
    response.setHeader("Cross-Origin-Embedder-Policy", "require-corp");
} });
const server = createServer((request, response) => files(request, response, () => {
    response.statusCode = 404;
    response.end("There is no such file.\n");
}));
server.on("error", (error) => {
    console.error(error.code === "EADDRINUSE" ? `port ${port} is taken; choose another: tools/web --port 8081` : error.message);
    process.exit(1);
});
server.listen(Number(port), "localhost", () => console.log(`http://localhost:${server.address().port}/`));
