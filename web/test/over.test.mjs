// A run that is over: resumed, audited, reported from its head; its small picture in the list of runs.

import assert from "node:assert/strict";
import {test} from "node:test";
import {axe, button, gone, picture, see} from "./browser.mjs";
import {until, wait, with_page} from "./with_page.mjs";

const kStopped = "20261122-110000-cuboid";
const kFinished = "20261123-140000-cylinder";
const at = run => ({hash: `#token=right-token&run=${run}`});

test("the head of a run that is over has its verdict against the goal", () => with_page(async page => {
  await see(page, "within tolerance: RMS");
  const head = await page.$eval("header", header => header.innerText);
  assert.match(head, /within tolerance: RMS [\d.]+ µm of the last map, at most 7.6 µm/);
  assert.match(head, /goal: RMS of at most 7.6 µm/);
}, at(kFinished)));

test("the head of a run that was stopped has the error so far beside the goal", () => with_page(async page => {
  await see(page, "after layer 21");
  const head = await page.$eval("header", header => header.innerText);
  assert.match(head, /RMS [\d.]+ µm after layer 21/);
  assert.match(head, /goal: RMS of at most 7.6 µm/);
}, at(kStopped)));

test("a live print has no buttons of a run that is over", () => with_page(async page => {
  await see(page, "Printing layer 8");
  assert.equal(await page.$(".orders"), null);
}));

test("a run whose last layer is printed offers a report and an audit, and no resume", () => with_page(async page => {
  await see(page, "Audit");
  const words = await page.$$eval(".orders > *", all => all.map(one => one.innerText));
  assert.deepEqual(words, ["Report", "Audit"]);
  assert.equal(await page.$eval(".orders a", link => link.getAttribute("href")), `api/report?run=${kFinished}`);
}, at(kFinished)));

test("an audit's verdict is shown in the words of firn audit", () => with_page(async page => {
  await (await button(page, "Audit")).click();
  await see(page, "Audit: clean: 53 layers, 106 passes");
  await see(page, "sealed: 2 seals, 31 files, 0123");
  assert.ok(await page.$(".said .fine"));
  assert.deepEqual(await axe(page), []);
  await picture(page, "audit");
}, at(kFinished)));

test("an audit that finds something is shown as bad, its lines as text", () => with_page(async page => {
  await (await button(page, "Audit")).click();
  await see(page, "Audit: 1 violations: 53 layers");
  await see(page, "altered after the seal: <b>log.lcm</b>");
  assert.equal(await page.$(".said .fine"), null);
  assert.equal(await page.$(".said b"), null);
}, {...at(kFinished), prepare: server => server.audits.set(kFinished, {clean: false, text: "1 violations: 53 layers\naltered after the seal: <b>log.lcm</b>\n"})}));

test("a resume wants a second press, later than a double click, and then shows the print", () => with_page(async (page, server) => {
  await (await button(page, "Resume")).click({count: 2});
  await see(page, "the instruments will move");
  assert.deepEqual(server.resumed, []);
  assert.deepEqual(await axe(page), []);
  await picture(page, "resume");
  await wait(450);
  await (await button(page, "Resume: press again")).click();
  await until(() => server.resumed.length, "the resume");
  await see(page, "● live");
  await gone(page, ".orders");
  assert.deepEqual(server.resumed, [kStopped]);
}, at(kStopped)));

test("a print that was resumed leaves no word of its resume when it is over", () => with_page(async (page, server) => {
  await (await button(page, "Resume")).click();
  await wait(450);
  await (await button(page, "Resume: press again")).click();
  await see(page, "● live");
  server.stop("the lamp is disconnected");
  await button(page, "Audit");
  assert.equal(await page.$eval(".said", said => said.innerText.trim()), "");
}, at(kStopped)));

test("a stop's cause is said once: in its head where that has it, else below", () => with_page(async (page, server) => {
  const stop = words => server.tell({type: "end", outcome: "stopped safely", words, cause: "scheduler: lamp: the lamp is disconnected", do: null, manual: null});
  await see(page, "Printing layer 8");
  stop("stopped safely: lamp: the lamp is disconnected");
  await see(page, "■ stopped safely");
  assert.doesNotMatch(await page.$eval(".stopped", banner => banner.innerText), /Cause:/);
  stop("stopped safely");
  await see(page, "Cause: scheduler: lamp");
}));

test("a resume that is pressed once is forgotten", () => with_page(async (page, server) => {
  await (await button(page, "Resume")).click();
  await see(page, "the instruments will move");
  await button(page, "Resume");  // again, after some seconds
  assert.deepEqual(server.resumed, []);
}, at(kStopped)));

test("a resume that fails is said in the words of its error", () => with_page(async (page, server) => {
  await (await button(page, "Resume")).click();
  await wait(450);
  await (await button(page, "Resume: press again")).click();
  await see(page, "Resume: the stage does not answer");
  assert.deepEqual(server.resumed, []);
  await button(page, "Resume");
}, {...at(kStopped), prepare: server => { server.resume_trouble = "the stage does not answer"; }}));

test("a page that may not resume offers none", () => with_page(async page => {
  await see(page, "after layer 21");
  assert.equal((await page.$$(".orders button")).length, 1);
}, {...at(kStopped), prepare: server => {
  const run = server.run(kStopped);
  const hello = run.hello.bind(run);
  run.hello = state => {
    const one = hello(state);
    return {...one, commands: {...one.commands, resume: false}};
  };
}}));

test("the list shows a small error map of each run that has one", () => with_page(async (page, server) => {
  await see(page, "5 of 5");
  await until(async () => (await page.$$eval(".thumbnail img", all => all.filter(one => one.complete && one.naturalWidth > 0).length)) === 3, "three pictures");
  assert.equal((await page.$$(".thumbnail img")).length, 3);
  assert.deepEqual(new Set(server.asked_thumbnails).size, 4, "of runs that are over, each once");
  assert.equal(server.asked_thumbnails.length, 4);
}, {hash: "#runs", prepare: server => { server.run(kStopped).without_map = true; }}));

test("small pictures are asked for as their rows come into view, each once", () => with_page(async (page, server) => {
  await see(page, "5 of 5");
  const one = server.run(kFinished);
  for (let n = 0; n < 50; ++n) {
    const id = `many-${String(n).padStart(2, "0")}`;
    server.runs.push(Object.assign(Object.create(one), {id, label: id, started_utc: "2020-01-01T00:00:00Z"}));
  }
  await page.reload({waitUntil: "load"});
  await see(page, "55 of 55");
  await until(() => server.asked_thumbnails.includes("many-00"), "the first of the many");
  assert.ok(!server.asked_thumbnails.includes("many-49"), "one far below was asked for");
  for (const place of ["end", "start", "end"]) {
    await page.evaluate(place => (place === "end" ? document.querySelector(".runs tbody tr:last-child") : document.body).scrollIntoView(), place);
    await wait(100);
  }
  await until(() => server.asked_thumbnails.includes("many-49"), "the last, once it was scrolled to");
  const many = server.asked_thumbnails.filter(id => id.startsWith("many-"));
  assert.equal(many.length, new Set(many).size);
}, {hash: "#runs"}));

test("no run named and no print here: the list, without an error in the console", () => with_page(async page => {
  await see(page, "4 of 4");
}, {hash: "", prepare: server => {
  server.live.live = false;
  server.runs = server.runs.filter(run => run !== server.live);
}}));

test("a map that a run does not have is said in words, without an error in the console", () => with_page(async page => {
  await see(page, "All of layer 53");
  await page.select(".surface select", "planned");
  await see(page, "this run has no next layer's plan of layer 53");
}, at(kFinished)));

test("at 400 px no option of a command is broken behind its hyphens", () => with_page(async page => {
  await see(page, "What to do:");
  const lines = await page.$$eval(".detail span", all => all.map(one => [one.innerText, one.getClientRects().length]));
  assert.deepEqual(lines, [["--resume", 1], ["--resume", 1]]);
}, {...at(kStopped), width: 400}));

for (const width of [1280, 400])
  test(`a long part and a long name leave no text of the list out of sight at ${width} px`, () => with_page(async page => {
    await see(page, "6.06 x 6.06 x 0.0251 mm");
    const cut = await page.$$eval(".runs .scroll, .runs tbody *", all => all.filter(one => one.scrollWidth > one.clientWidth + 1 && one.clientWidth > 1).map(one => one.outerHTML.slice(0, 100)));
    assert.deepEqual(cut, []);
    await picture(page, `list-${width}`);
  }, {hash: "#runs", width, prepare: server => {
    for (const run of server.runs) run.part = "lines aerosol-antenna-of-the-second-kind.json, 6.06 x 6.06 x 0.0251 mm";
  }}));
