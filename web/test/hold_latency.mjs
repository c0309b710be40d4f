// From the end of a hold of the stop button to SAFE_STOP on the bus, in live prints, hop by hop: node test/hold_latency.mjs
// STOPS FIRN [OTHER_FIRN]. Two programs take turns.

import {mkdtempSync, readdirSync, rmSync} from "node:fs";
import {loadavg, tmpdir} from "node:os";
import {join} from "node:path";
import {launch, open_tab} from "./browser.mjs";
import {bus_times, ended, hold_stop, note_times, print_with_page} from "./live_print.mjs";

const [stops, ...programs] = [Number(process.argv[2]), ...process.argv.slice(3)];
const kSlow = ["--set", "run.time_scale=1", "--set", "process.scan_speed_mm_s=1"];  // a busy machine loses no rows
const kHops = [["tab", "ended_ms", "sent_ms"], ["page and launcher", "sent_ms", "ordered_ms"], ["safety and bus", "ordered_ms", "stopped_ms"],
               ["hold's end to SAFE_STOP heard", "ended_ms", "stopped_ms"], ["hold's end to the answer in the tab", "ended_ms", "answered_ms"]];
const root = mkdtempSync(join(tmpdir(), "firn-hold-"));
const browser = await launch();

async function stop_one(firn, n) {
  const runs = mkdtempSync(join(root, "r"));
  const print = await print_with_page(firn, "experiments/demo.toml", runs, kSlow);
  const page = await open_tab(browser, "about:blank");
  await note_times(page);
  await page.goto(print.address);
  await new Promise(resolve => setTimeout(resolve, 300 + ((n * 617) % 1300)));
  const times = await hold_stop(page);
  await page.close();
  await ended(print.child, 20_000);
  const run = join(runs, readdirSync(runs).find(name => name.includes("Z-")));
  const all = {...times, ...bus_times(firn, run)};
  rmSync(runs, {recursive: true, force: true});
  return all;
}

const at = (values, share) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(share * values.length))];
let worst = 0;
const took = programs.map(() => []);
try {
  for (let n = 0; n < stops; ++n)
    for (const [which, firn] of programs.entries()) took[which].push(await stop_one(firn, n));
} finally {
  await browser.close();
  rmSync(root, {recursive: true, force: true});
}
for (const [which, firn] of programs.entries()) {
  console.log(`${firn}: ${took[which].length} holds, load ${loadavg()[0].toFixed(1)}`);
  for (const [words, from, to] of kHops) {
    const ms = took[which].map(times => times[to] - times[from]);
    console.log(`  ${words.padEnd(36)} p50 ${at(ms, 0.5).toFixed(1)}, p90 ${at(ms, 0.9).toFixed(1)}, p99 ${at(ms, 0.99).toFixed(1)}, most ${at(ms, 1).toFixed(1)} ms`);
    if (which === 0 && to === "stopped_ms" && from === "ended_ms") worst = at(ms, 0.99);
  }
}
process.exit(worst <= 20 ? 0 : 1);
