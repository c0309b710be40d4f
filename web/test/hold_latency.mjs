// From the end of a hold of the stop button to the answer that SAFE_STOP is on the bus, in live prints:
// node test/hold_latency.mjs FIRN STOPS.

import {mkdtempSync, rmSync} from "node:fs";
import {loadavg, tmpdir} from "node:os";
import {join} from "node:path";
import {launch, open_tab} from "./browser.mjs";
import {ended, hold_stop, note_times, print_with_page} from "./live_print.mjs";

const [firn, stops] = [process.argv[2], Number(process.argv[3])];
const kSlow = ["--set", "run.time_scale=1", "--set", "process.scan_speed_mm_s=1"];  // a busy machine loses no rows
const runs = mkdtempSync(join(tmpdir(), "firn-hold-"));
const browser = await launch();
const took_ms = [];
try {
  for (let n = 0; n < stops; ++n) {
    const print = await print_with_page(firn, "experiments/demo.toml", runs, kSlow);
    const page = await open_tab(browser, "about:blank");
    await note_times(page);
    await page.goto(print.address);
    await new Promise(resolve => setTimeout(resolve, 300 + ((n * 617) % 1300)));
    took_ms.push(await hold_stop(page));
    await page.close();
    await ended(print.child, 20_000);
  }
} finally {
  await browser.close();
  rmSync(runs, {recursive: true, force: true});
}
const at = (values, share) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(share * values.length))];
const words = values => `p50 ${at(values, 0.5).toFixed(1)}, p90 ${at(values, 0.9).toFixed(1)}, p99 ${at(values, 0.99).toFixed(1)}, most ${at(values, 1).toFixed(1)} ms`;
const whole = took_ms.map(([tab, rest]) => tab + rest);
console.log(`${whole.length} holds, to the answer: ${words(whole)}; load ${loadavg()[0].toFixed(1)}`);
console.log(`until the command leaves the tab: ${words(took_ms.map(([tab]) => tab))}; from there: ${words(took_ms.map(([, rest]) => rest))}`);
process.exit(at(whole, 0.99) <= 20 ? 0 : 1);
