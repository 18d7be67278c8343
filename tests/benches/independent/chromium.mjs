// Opens `page.html` in headless Chromium with a software GPU and keeps what it draws of each file.
//
//   node chromium.mjs MODULES WORK CHROMIUM NAME...
//
// MODULES is a `node_modules` with three and puppeteer-core; WORK/NAME.glb becomes WORK/NAME.three.f32 (RGB, rows from above).
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { readFile, writeFile } from "node:fs/promises";
import { join, normalize } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [modules, work, chromium, ...names] = process.argv.slice(2);
const entry = createRequire(join(modules, "..", "package.json")).resolve("puppeteer-core");
const { default: puppeteer } = await import(pathToFileURL(entry));

const page_file = fileURLToPath(new URL("page.html", import.meta.url));
const types = { html: "text/html", js: "text/javascript", json: "application/json" };
const server = createServer(async (request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, "http://host").pathname));
  const file = path.startsWith("/modules/") ? join(modules, path.slice(9)) : path.startsWith("/work/") ? join(work, path.slice(6)) : page_file;
  try {
    response.setHeader("Content-Type", types[file.split(".").pop()] ?? "application/octet-stream");
    response.end(await readFile(file));
  } catch {
    response.writeHead(404).end();
  }
}).listen(0, "127.0.0.1");
await new Promise((listening) => server.once("listening", listening));

const browser = await puppeteer.launch({
  executablePath: chromium,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
  protocolTimeout: 600000,
});
try {
  const page = await browser.newPage();
  page.on("console", (message) => console.error(`page: ${message.text()}`));
  page.on("pageerror", (error) => console.error(`page: ${error}`));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.waitForFunction("window.is_ready", { timeout: 120000 });
  console.log(`three.js r${await page.evaluate("window.is_ready")}, ${await browser.version()}`);
  for (const name of names) {
    const text = await page.evaluate((file) => window.draw(file), `/work/${name}.glb`);
    await writeFile(join(work, `${name}.three.f32`), Buffer.from(text, "base64"));
    console.error(`three.js: ${name}`);
  }
} finally {
  await browser.close();
  server.close();
}
