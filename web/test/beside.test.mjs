// Runs beside each other: one scale, one unit, differences, ends of runs of unequal length.

import assert from "node:assert/strict";
import {test} from "node:test";
import {picture, see} from "./browser.mjs";
import {until, with_page} from "./with_page.mjs";

const kRuns = ["20261123-150000-cylinder", "20261123-140000-cylinder", "20261122-110000-cuboid"];
const kIce = "20261121-200000-ice-helical-gear";
const beside = runs => ({hash: `#token=right-token&compare=${runs.join(",")}`});
const captions = page => page.$$eval(".beside figcaption", all => all.map(one => one.innerText.replace(/\s+/g, " ")));
const scale = page => page.$eval(".head .scale", one => one.innerText.replace(/\s+/g, " "));
const loaded = (page, count) => until(async () => {
  const words = await captions(page);
  return words.length === count && words.every(one => !one.includes("loading"));
}, `${count} surfaces`);

/** The scale of runs whose maps come in this order. */
async function scale_of(runs, delays_ms) {
  let found;
  await with_page(async page => {
    await loaded(page, 5);
    found = await scale(page);
  }, {...beside(runs), prepare: server => { server.map_delays_ms = delays_ms; }});
  return found;
}

test("the scale is that of all chosen runs, in whatever order their maps come", async () => {
  const [a, b, c] = kRuns;
  const found = [await scale_of([a, b, c], {[a]: 300}), await scale_of([a, b, c], {[b]: 300, [c]: 150}), await scale_of([c, a, b], {[c]: 300})];
  assert.deepEqual(new Set(found).size, 1, `${found}`);
  assert.match(found[0], /^−\d+ \d+ µm$/);
});

test("runs are named by their schemes, and by their own names where two have one scheme", () => with_page(async page => {
  await loaded(page, 5);
  const names = await page.$$eval(".beside figcaption b", all => all.slice(0, 3).map(one => one.innerText));
  assert.deepEqual(names, [`mpc: ${kRuns[0]}`, "open", `mpc: ${kRuns[2]}`]);
  const curves = await page.$$eval(".u-legend .u-series .u-label", all => all.slice(1).map(one => one.innerText));
  assert.deepEqual(curves, names);
}, {...beside(kRuns), prepare: server => { server.run(kRuns[2]).scheme = "mpc"; }}));

test("the RMS is drawn over a logarithmic axis", () => with_page(async (page, server, address) => {
  await page.evaluateOnNewDocument(() => {
    window.written = [];
    const {fillText} = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
      if (this.canvas.closest(".plot")) window.written.push([Number(text), x, y]);
      fillText.apply(this, arguments);
    };
  });
  await page.goto("about:blank");
  await page.goto(`${address}#compare=${kRuns.join(",")}`);
  await loaded(page, 5);
  await picture(page, "beside-three", {fullPage: true});
  const written = await page.evaluate(() => window.written.filter(([value]) => value > 0));
  const left = Math.min(...written.map(([, x]) => x));
  const ticks = [...new Map(written.filter(([, x]) => x === left).map(([value, , y]) => [value, y]))].sort(([a], [b]) => a - b);
  assert.ok(ticks.length >= 3, JSON.stringify(ticks));
  const [[a, a_y], [b, b_y], [c, c_y]] = [ticks[0], ticks[1], ticks[ticks.length - 1]];
  assert.ok(Math.abs((b_y - a_y) / (c_y - a_y) - Math.log(b / a) / Math.log(c / a)) < 0.02, JSON.stringify(ticks));
}, beside(kRuns)));

test("runs of unequal length are compared at their ends, and the shorter one says where it ended", () => with_page(async page => {
  await loaded(page, 5);
  const [, , short, , apart] = await captions(page);
  assert.match(short, /greedy mean [−\d.]+ µm, RMS [\d.]+ µm at its end, layer 21/);
  assert.match(apart, /mpc minus greedy RMS [\d.]+ µm, scale ±[\d.]+ µm/);
}, beside(kRuns)));

test("the difference has a tile from the beginning, and one that cannot be drawn says why", () => with_page(async page => {
  await see(page, "mpc minus open");
  await loaded(page, 3);
  await page.select('[aria-labelledby="beside-title"] select', "planned");
  await until(async () => (await captions(page))[2].includes("this run has no next layer's plan of layer 53"), "the words of the difference");
  assert.equal((await captions(page)).length, 3);
}, {...beside(kRuns.slice(0, 2)), prepare: server => { server.map_delays_ms = {[kRuns[1]]: 1500}; }}));

test("runs of two labs have one unit: that of the first", () => with_page(async page => {
  await loaded(page, 3);
  const words = await captions(page);
  for (const one of words) assert.ok(one.includes("µm") && !/\bmm\b/.test(one), one);
  const ice_um = parseFloat(words[1].match(/RMS ([\d.,]+) µm/)[1].replace(",", ""));
  const [, high] = (await scale(page)).match(/([\d.,]+) µm$/);
  assert.ok(parseFloat(high.replace(",", "")) >= ice_um, `${high} holds ${ice_um}`);
}, beside([kRuns[0], kIce])));
