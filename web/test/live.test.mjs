// Two live prints in a real browser: watched, paused, changed, continued to the end; stopped by a hold and resumed; put
// beside each other. FIRN_BINARY names the program.

import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {mkdtempSync, readdirSync, readFileSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {axe, button, gone, launch, open_tab, picture, see} from "./browser.mjs";
import {ended, hold_stop, note_times, print_with_page, start} from "./live_print.mjs";

const firn = process.env.FIRN_BINARY;
const demo = join(process.env.FIRN_SOURCES, "experiments/demo.toml");
const kPatience_ms = 120_000;
const runs = mkdtempSync(join(tmpdir(), "firn-live-"));
let browser;
before(async () => { browser = await launch(); });
after(async () => {
  await browser?.close();
  rmSync(runs, {recursive: true, force: true});
});

const folders = () => readdirSync(runs).filter(name => name.includes("Z-")).sort();
const layer_of = page => page.$eval(".timeline output", output => Number(/layer (\d+)/.exec(output.innerText)?.[1] ?? 0));

async function layers_beyond(page, n) {
  await page.waitForFunction(n => Number(/layer (\d+)/.exec(document.querySelector(".timeline output").innerText)?.[1] ?? 0) > n,
                             {timeout: kPatience_ms, polling: 100}, n);
}

test("a live print is watched, paused, changed and continued to its end, and replays identical", async () => {
  const print = await print_with_page(firn, demo, runs);
  const page = await open_tab(browser, print.address);
  await (await button(page, "Pause")).click();
  await see(page, "the print waits", kPatience_ms);
  const waits_at = await layer_of(page);
  await page.click(".in-flight summary");
  const field = "#set-control\\.target_offset_mm";
  await page.click(field, {count: 3});
  await page.type(field, "0.005");
  await page.$eval(field, input => input.form.requestSubmit());
  await see(page, "set control.target_offset_mm = 0.005", kPatience_ms);
  assert.deepEqual(await axe(page), []);
  await picture(page, "live-paused");
  await (await button(page, "Continue")).click();
  await layers_beyond(page, waits_at);
  await see(page, "cells seen", kPatience_ms);
  await see(page, "finished", kPatience_ms);
  assert.equal(await ended(print.child, kPatience_ms), 0, print.said.join("\n"));
  await picture(page, "live-finished");
  assert.deepEqual(page.troubles.filter(words => !words.includes("ERR_CONNECTION_REFUSED")), [], "the process ends with its print");
  await page.close();
  const replay = spawnSync(firn, ["replay", join(runs, folders()[0])], {encoding: "utf8"});
  assert.equal(replay.status, 0, replay.stdout + replay.stderr);
});

test("a hold of the stop button makes the lab safe, and the page says why and what to do", async () => {
  const print = await print_with_page(firn, demo, runs, ["--set", "control.scheme=smf", "--set", "part.height_mm=0.12"]);
  const page = await open_tab(browser, "about:blank");
  await note_times(page);
  await page.goto(print.address);
  await hold_stop(page);
  await see(page, "stopped by the operator", kPatience_ms);
  await see(page, "What to do:", kPatience_ms);
  await ended(print.child, kPatience_ms);
  assert.equal(JSON.parse(readFileSync(join(runs, folders()[1], "result.json"), "utf8")).outcome, "stopped safely");
  await page.close();
});

test("a run that was stopped is audited and resumed by firn view, and its page shows the print again", async () => {
  const view = start(firn, ["view", runs, "--json"], text => text.startsWith("{") && JSON.parse(text));
  const {address, token} = await view.line;
  const run = folders()[1];
  const page = await open_tab(browser, `${address}#run=${run}&token=${token}`);
  await (await button(page, "Audit")).click();
  await see(page, "Audit: clean:", kPatience_ms);
  await (await button(page, "Resume")).click();
  await new Promise(done => setTimeout(done, 500));  // no double click
  await (await button(page, "Resume: press again")).click();
  await see(page, "● live", kPatience_ms);
  await gone(page, ".orders");
  await button(page, "Pause");
  const stop = spawnSync(firn, ["ctl", join(runs, run), "stop"], {encoding: "utf8"});
  assert.equal(stop.status, 0, stop.stdout + stop.stderr);
  await see(page, "stopped by the operator", kPatience_ms);
  await button(page, "Resume");
  assert.deepEqual(page.troubles, []);
  await page.close();
  await ended(view.child);
});

test("both runs are listed, noted, and put beside each other with the settings that differ", async () => {
  const view = start(firn, ["view", runs, "--json"], text => text.startsWith("{") && JSON.parse(text));
  const {address, token} = await view.line;
  const page = await open_tab(browser, `${address}#runs&token=${token}`);
  await see(page, "2 of 2", kPatience_ms);
  const [first, second] = folders();
  await (await button(page, `Add tags and a note to ${first}`)).click();
  await page.type("td.notes textarea", "raised by 5 um");
  await (await button(page, "Keep")).click();
  await gone(page, "td.notes textarea");
  assert.match(readFileSync(join(runs, first, "notes.jsonl"), "utf8"), /"kind":"note","text":"raised by 5 um"/);
  for (const id of [first, second]) await page.click(`input[aria-label="Choose ${id}"]`);
  await (await button(page, "Put 2 beside each other")).click();
  await see(page, "control.scheme", kPatience_ms);
  const keys = await page.$$eval('[aria-label="Table of differing settings"] code', list => list.map(one => one.innerText));
  assert.ok(keys.includes("control.scheme") && keys.includes("part.height_mm"), keys.join(", "));
  assert.ok(!keys.includes("grid.nx"), keys.join(", "));
  await see(page, "mpc minus smf", kPatience_ms);
  await picture(page, "live-beside");
  const report = await page.$$eval("a", list => list.find(one => one.innerText === "Open in report").href);
  await page.goto(report);
  await see(page, first, kPatience_ms);
  await page.close();
  await ended(view.child);
});
