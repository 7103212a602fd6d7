// A page with three.js in headless Chromium, for the tools of this folder: no network but a server of its own.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { launch } from "./browser.mjs";

const types = { ".js": "text/javascript", ".html": "text/html" };

/** A tab that has run the module `script`, in which "three" and "three/addons/" can be imported, and sees `folders` by name: { tab, errors, close }.
 * Ends the program with status 77 and a reason where a tool is absent. */
export async function threePage(script, folders) {
  let three;
  try {
    three = path.dirname(path.dirname(createRequire(import.meta.url).resolve("three")));
  } catch {
    console.log("tests/tools has no three; run npm ci there");
    process.exit(77);
  }
  const imports = { three: "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/" };
  const page = `<!doctype html><link rel="icon" href="data:,"><script type="importmap">${JSON.stringify({ imports })}</script>
<script type="module">${script}
window.ready = true;
</script>`;
  const server = createServer(async (request, response) => {
    const { pathname } = new URL(request.url, "http://127.0.0.1");
    try {
      if (pathname === "/") return response.setHeader("content-type", "text/html").end(page);
      const [, root, ...rest] = pathname.split("/").map(decodeURIComponent);
      const file = path.join({ three, ...folders }[root], ...rest);
      response.setHeader("content-type", types[path.extname(file)] ?? "application/octet-stream").end(await readFile(file));
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const browser = await launch();
  const tab = await browser.newPage(), errors = [];
  tab.on("pageerror", (error) => errors.push(String(error)));
  tab.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  await tab.waitForFunction(() => window.ready, null, { timeout: 60000 });
  return { tab, errors, close: async () => { await browser.close(); server.close(); } };
}
