// The time from the address to the painted surface: node test/first_paint.mjs FIRN RUN|live ROUNDS.

import {mkdtempSync, readFileSync, rmSync} from "node:fs";
import {loadavg, tmpdir} from "node:os";
import {basename, join} from "node:path";
import {launch} from "./browser.mjs";
import {ended, start} from "./live_print.mjs";

const [firn, run, rounds] = [process.argv[2], process.argv[3], Number(process.argv[4])];
const kLimit_s = run === "live" ? 1 : 2;

/** Processor time of a process [s]. */
function cpu_s(pid) {
  const words = readFileSync(`/proc/${pid}/stat`, "utf8").replace(/.*\) /s, "").split(" ");
  return (Number(words[11]) + Number(words[12])) / 100;
}

/** Seconds from navigation until the canvas of the surface has its map and a frame was drawn after it. */
async function painted_s(page, address) {
  await page.evaluateOnNewDocument(() => {
    window.painted = new Promise(resolve => {
      const look = () => {
        if (/cells seen/.test(document.querySelector(".readout")?.textContent ?? "")) requestAnimationFrame(() => setTimeout(() => resolve(performance.now() / 1000)));
        else setTimeout(look, 5);
      };
      addEventListener("DOMContentLoaded", look);
    });
  });
  await page.goto(address, {waitUntil: "domcontentloaded"});
  return page.evaluate(() => window.painted);
}

const middle = list => [...list].sort((a, b) => a - b)[list.length >> 1];
const browser = await launch();
const first = [];
const again = [];
const cpu = [];
const scratch = mkdtempSync(join(tmpdir(), "firn-first-paint-"));
let print = null;
try {
  if (run === "live") {
    print = start(firn, ["print", "experiments/demo.toml", "--runs", scratch, "--no-page"], text => text.match(/run folder (\S+)/)?.[1]);
    await print.line;
    await new Promise(resolve => setTimeout(resolve, 8000));  // until something was measured
  }
  const shown = run === "live" ? await print.line : run;
  for (let n = 0; n < rounds; ++n) {
    const view = start(firn, ["view", shown, "--json"], text => text.startsWith("{") && JSON.parse(text).address);
    const address = `${await view.line}#run=${encodeURIComponent(basename(shown))}`;
    const before_s = cpu_s(view.child.pid);
    for (const list of [first, again]) {
      const page = await browser.newPage();
      await page.setViewport({width: 1280, height: 900});
      list.push(await painted_s(page, address));
      await page.close();
      if (list === first) cpu.push(cpu_s(view.child.pid) - before_s);
    }
    await ended(view.child);
  }
} finally {
  if (print) await ended(print.child);
  await browser.close();
  rmSync(scratch, {recursive: true, force: true});
}
const list = values => values.map(value => value.toFixed(2)).join(" ");
console.log(`first paint of ${run}: ${list(first)} s (middle ${middle(first).toFixed(2)}); by a page that has the run: ${list(again)} s`);
console.log(`processor time of the page until then: ${list(cpu)} s; load ${loadavg()[0].toFixed(1)}`);
process.exit(middle(first) <= kLimit_s ? 0 : 1);
