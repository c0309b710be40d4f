// Writes dist/ from src/: the same bytes from the same lockfile. `--to FOLDER` writes elsewhere.

import {build} from "esbuild";
import {copyFile, mkdir, readFile} from "node:fs/promises";
import {dirname, join} from "node:path";
import {fileURLToPath} from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const to = process.argv[2] === "--to" ? process.argv[3] : join(here, "dist");

/** MIT asks that its notice goes along. */
async function notices() {
  const mit = await readFile(join(here, "node_modules/uplot/LICENSE"), "utf8");
  const preact = await readFile(join(here, "node_modules/preact/LICENSE"), "utf8");
  const owner = text => text.match(/Copyright.*/)[0];
  return `/*! Firn's page, Apache-2.0. Contains htm (Apache-2.0), ogl (public domain), and under the MIT licence\n` +
    `uPlot (${owner(mit)}) and preact (${owner(preact)}):\n${mit.slice(mit.indexOf("Permission")).trim()} */`;
}

await mkdir(to, {recursive: true});
const each = {
  absWorkingDir: here,
  outdir: to,
  bundle: true,
  minify: true,
  format: "iife",
  target: ["chrome109", "firefox115", "safari16"],
  legalComments: "none",
  charset: "utf8",
  logLevel: "warning",
};
await build({...each, entryPoints: {app: "src/main.ts"}, banner: {js: await notices()}});
await build({...each, entryPoints: {line: "src/line_worker.ts"}});
await copyFile(join(here, "src/index.html"), join(to, "index.html"));
