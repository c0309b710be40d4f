// The committed bundle: what its sources build, light, and without foreign addresses or ways to run foreign text.

import assert from "node:assert/strict";
import {execFile} from "node:child_process";
import {mkdtemp, readdir, readFile, rm} from "node:fs/promises";
import {tmpdir} from "node:os";
import {dirname, join} from "node:path";
import {test} from "node:test";
import {fileURLToPath} from "node:url";
import {promisify} from "node:util";
import {gzipSync} from "node:zlib";

const web = join(dirname(fileURLToPath(import.meta.url)), "..");
const run = promisify(execFile);
const kMostGzip = 120_000;

async function sources(folder) {
  const names = await readdir(folder, {withFileTypes: true});
  const lists = await Promise.all(names.map(name => (name.isDirectory() ? sources(join(folder, name.name)) : [join(folder, name.name)])));
  return lists.flat();
}

test("dist/ is what src/ and the lockfile build, byte for byte", async () => {
  const folder = await mkdtemp(join(tmpdir(), "firn-web-"));
  try {
    await run("node", ["build.mjs", "--to", folder], {cwd: web});
    const names = (await readdir(join(web, "dist"))).sort();
    assert.deepEqual((await readdir(folder)).sort(), names);
    for (const name of names)
      assert.ok((await readFile(join(folder, name))).equals(await readFile(join(web, "dist", name))), `dist/${name} is not what its sources build: run "npm run build" in web/`);
  } finally {
    await rm(folder, {recursive: true});
  }
});

test("everything weighs at most 120 kB by gzip", async () => {
  let bytes = 0;
  for (const name of await readdir(join(web, "dist"))) bytes += gzipSync(await readFile(join(web, "dist", name)), {level: 9}).length;
  console.log(`gzip: ${bytes} bytes`);
  assert.ok(bytes <= kMostGzip, `${bytes} bytes, at most ${kMostGzip}`);
});

test("types hold", async () => {
  await run("node", ["node_modules/typescript/bin/tsc", "--noEmit", "-p", "."], {cwd: web}).catch(error => assert.fail(error.stdout));
});

test("no source turns text into markup or code", async () => {
  for (const file of await sources(join(web, "src")))
    assert.doesNotMatch(await readFile(file, "utf8"), /innerHTML|outerHTML|insertAdjacentHTML|document\.write|dangerouslySet|\beval\(|new Function/, file);
});

test("the page asks for nothing but its own origin, and runs nothing inline", async () => {
  const page = await readFile(join(web, "dist/index.html"), "utf8");
  assert.doesNotMatch(page, /https?:|<style|style=|\son\w+=|<script(?![^>]*\ssrc=)/);
  for (const name of ["app.js", "line.js", "app.css"]) {
    const addresses = (await readFile(join(web, "dist", name), "utf8")).match(/\b(?:https?:)?\/\/[a-z0-9.-]+\.[a-z]{2,}[^\s"'`)]*/gi) ?? [];
    assert.deepEqual([...new Set(addresses)].filter(address => !address.startsWith("http://www.w3.org/")), [], name);
  }
});
