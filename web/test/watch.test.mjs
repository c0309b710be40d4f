// A whole print in a real browser: watched, paused, resumed, stopped; recorded runs, put beside each other; axe.

import assert from "node:assert/strict";
import {test} from "node:test";
import {axe, button, gone, picture, see} from "./browser.mjs";
import {text_of, until, wait, with_page, with_proxied_page} from "./with_page.mjs";

/** Holds what the page does after `held_ms` (a hold's time is less by what an event took) until `window.go()`; `window.held` has what waits. */
const hold_timers = (page, held_ms) => page.evaluate(held_ms => {
  const {setTimeout, clearTimeout} = window;
  window.held = new Map();
  const waits = ms => ms > held_ms - 100 && ms <= held_ms;
  window.setTimeout = (work, ms, ...more) => {
    const id = setTimeout(waits(ms) ? () => {} : work, ms, ...more);
    if (waits(ms)) window.held.set(id, work);
    return id;
  };
  window.clearTimeout = id => {
    window.held.delete(id);
    clearTimeout(id);
  };
  window.go = () => {
    Object.assign(window, {setTimeout, clearTimeout});
    for (const work of window.held.values()) work();
  };
}, held_ms);
const held = page => page.evaluate(() => window.held.size);

/** Points at the middle of a cell of the map. */
async function point_at(page, run, x, y) {
  const box = await (await page.$("canvas.map")).boundingBox();
  const [left, right, top, bottom] = [44, 10, 10, 30];
  const pixel = Math.min((box.width - left - right) / run.nx, (box.height - top - bottom) / run.ny);
  const x0 = box.x + left + (box.width - left - right - pixel * run.nx) / 2;
  const y0 = box.y + top + (box.height - top - bottom - pixel * run.ny) / 2;
  return [x0 + (x + 0.5) * pixel, y0 + (run.ny - 0.5 - y) * pixel];
}

/** Moves the pointer over a cell, once the page's layout rests: rows that appear push the map down. */
async function point_to(page, run, x, y) {
  for (let tries = 0; tries < 50; ++tries) {
    const place = await point_at(page, run, x, y);
    await page.mouse.move(...place);
    await see(page, "cell ");
    await new Promise(done => setTimeout(done, 200));
    const again = await point_at(page, run, x, y);
    if (place[0] === again[0] && place[1] === again[1] && (await text_of(page, ".readout")).includes(`cell ${x}, ${y} at`)) return;
  }
  throw new Error(`the map never rested under cell ${x}, ${y}`);
}

test("a live print is watched: state, layers as they come, and the true value of the cell that is pointed at", () => with_page(async (page, server, address) => {
  await see(page, "Printing layer 8");
  assert.equal(page.url(), address, "the token has left the address");
  await see(page, "layer 8 of about 53");
  assert.match(await text_of(page, ".now"), /RMS error\s+[\d.]+ µm/);
  for (let k = 0; k < 2; ++k) server.next_layer();
  await see(page, "layer 9 of 9");
  await see(page, "All of layer 9:");
  for (const [x, y] of [[20, 20], [11, 25], [30, 14]]) {
    await point_to(page, server.live, x, y);
    const value = server.live.frame("error", 9).readFloatLE(32 + 4 * (40 * y + x));
    const words = Number.isNaN(value) ? "not seen" : `${(Math.abs(value) < 1 ? value.toFixed(3) : value.toFixed(2)).replace("-", "−")} µm`;
    assert.ok((await text_of(page, ".readout")).includes(words), `${words} in ${await text_of(page, ".readout")}`);
  }
  assert.equal(server.asked.filter(path => path.endsWith("/error")).length, 1, "maps of a live print come by the WebSocket; the plan's error once");
}));

test("below a proxy's prefix a print is watched, commanded and put beside other runs", () => with_proxied_page(async (page, server) => {
  await see(page, "layer 8 of about 53");
  server.next_layer();
  await see(page, "All of layer 8:");
  await (await button(page, "Pause")).click();
  await until(() => server.received.some(one => one.command === "pause" && one.line), "the pause, by the line for commands");
  await page.evaluate(() => { location.hash = "runs"; });
  await see(page, "report");
  const report = await page.$eval("a.soft", link => link.href);
  assert.match(report, /\/lab\/firn\/api\/report\?run=/);
}));

test("a proxy that passes no WebSocket is named", () => with_proxied_page(async page => {
  await see(page, "a proxy in between must pass WebSockets");
}, {upgrades: false}));

test("a followed map that is late is waited for, and asked for once it is very late", () => with_page(async (page, server) => {
  await see(page, "All of layer 7");
  await hold_timers(page, 2000);
  server.send_map = () => {};
  server.next_layer();
  await see(page, "Answer to the error of layer 8");
  await until(() => server.asked.some(path => path.endsWith("/8/planned")), "the plan after layer 8");
  const asked = () => server.asked.filter(path => path.endsWith("/8/error")).length;
  assert.equal(asked(), 0);
  await page.evaluate(() => window.go());
  await until(() => asked() === 1, "the error of layer 8");
}));

test("dragging cuts a section through cells, with the target beside a height; Enter does it from the keyboard", () => with_page(async (page, server) => {
  await see(page, "All of layer 7");
  await page.select(".surface select", "measured");
  await point_to(page, server.live, 4, 20);
  await page.mouse.down();
  await page.mouse.move(...(await point_at(page, server.live, 20, 20)), {steps: 3});
  await page.mouse.move(...(await point_at(page, server.live, 35, 20)), {steps: 3});
  await page.mouse.up();
  await see(page, "Section from A (4, 20) to B (35, 20), 7.75 mm");
  await see(page, "target–");
  await page.focus("canvas.map");
  await page.keyboard.press("Escape");
  await gone(page, ".section");
  await page.keyboard.down("Shift");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.up("Shift");
  await see(page, "cell 34, 20 at");
  await page.keyboard.press("Enter");
  await page.keyboard.down("Shift");
  for (let k = 0; k < 4; ++k) await page.keyboard.press("ArrowDown");
  await page.keyboard.up("Shift");
  await page.keyboard.press("Enter");
  await see(page, "Section from A (34, 20) to B (34, 16)");
}));

test("one cursor moves everything, back to the bare substrate; the scale is held", () => with_page(async (page, server) => {
  await see(page, "All of layer 7");
  const scale = await page.$eval(".scale input", input => input.value);
  await page.keyboard.press("ArrowLeft");
  await see(page, "layer 6 of 7");
  await see(page, "Answer to the error of layer 6");
  await see(page, "Layer 6");
  for (let k = 0; k < 6; ++k) await page.keyboard.press("ArrowLeft");
  await see(page, "bare substrate");
  await see(page, "All of layer 0:");
  assert.equal(await page.$eval(".scale input", input => input.value), scale);
  server.next_layer();
  await see(page, "bare substrate");  // a new layer does not pull the reader away
  await (await button(page, "● Live")).click();
  await see(page, "layer 8 of 8");
  assert.ok(server.asked.includes(`${server.live.id}/0/error`));
}));

test("paused, resumed, a setting changed, a doubt accepted: by keyboard alone, and the server's words are shown", () => with_page(async (page, server) => {
  await see(page, "Printing layer 8");
  const press = async words => {
    await (await button(page, words)).focus();
    await page.keyboard.press("Enter");
  };
  await press("Pause");
  await see(page, "Paused after layer 7");
  await see(page, "Pause: waits after this layer");
  await press("Continue");
  await see(page, "Continue: goes on");
  await page.focus(".in-flight summary");
  await page.keyboard.press("Enter");
  const field = "#set-control\\.target_offset_mm";
  await page.focus(field);
  await page.keyboard.down("Control");
  await page.keyboard.press("a");
  await page.keyboard.up("Control");
  await page.keyboard.type("99");
  assert.equal(await page.$eval(`${field} ~ button`, b => b.disabled), true, "beyond its limits");
  await page.keyboard.press("Backspace");
  await page.keyboard.press("Backspace");
  await page.keyboard.type("-1.5");
  await page.keyboard.press("Enter");
  await see(page, "The setting: from the next decision on");
  server.state.doubt = {words: "Droplets 4 to 9 are in doubt", question: "Go on from the scanned surface?", choices: ["accept", "stop"]};
  server.tell_state();
  await see(page, "Go on from the scanned surface?");
  await press("accept");
  await gone(page, ".commands .warning");
  assert.deepEqual(server.received.map(({command, key, value, choice}) => [command, key, value, choice].filter(one => one !== undefined)),
                   [["pause"], ["continue"], ["set", "control.target_offset_mm", "-1.5"], ["accept_doubt", "accept"]]);
  server.refuse = "nothing is printed now";
  await press("Stop after this layer");
  await see(page, "Stop after this layer: nothing is printed now");
}));

/** The stop button's middle, once the line for commands is open. */
async function place_of_stop(page, server) {
  await see(page, "Printing layer 8");
  await until(() => server.lines > 0, "the line for commands");
  const box = await (await button(page, "Safe stop: hold")).boundingBox();
  await page.mouse.move(box.x + 20, box.y + 10);
  return box;
}

/** Notes how long the button was held by the events' own times, `window.held_ms`. */
const note_hold = page => page.evaluate(() => {
  let down_ms = 0;
  addEventListener("pointerdown", event => { down_ms = event.timeStamp; }, true);
  for (const kind of ["pointerup", "pointermove"]) addEventListener(kind, event => { window.held_ms = event.timeStamp - down_ms; }, true);
});

/** Keeps the page's own thread busy: from `from_ms` after the next press on, for `busy_ms`. */
const be_busy = (page, from_ms, busy_ms) => page.evaluate((from_ms, busy_ms) => {
  addEventListener("pointerdown", () => setTimeout(() => {
    const until = performance.now() + busy_ms;
    while (performance.now() < until);
    window.busy_until_ms = Date.now();
  }, from_ms), {once: true});
}, from_ms, busy_ms);

/** The button was let go too late to be a short hold, by the events' own times: this machine is busy. */
const held_too_long = page => page.evaluate(() => window.held_ms > 400);

/** Runs `look` with the line in a worker and, as in a browser without workers, in the page's own thread. It returns false
 *  where the machine was too busy, and is tried again. */
async function both_ways(look) {
  for (const alone of [false, true]) {
    let done = false;
    for (let tries = 0; !done && tries < 4; ++tries)
      await with_page(async (page, server, address) => {
        await page.evaluateOnNewDocument(alone => { if (alone) delete window.Worker; }, alone);
        await page.goto("about:blank");
        await page.goto(`${address}#token=${server.token}`);
        done = (await look(page, server)) !== false;
      }, {hash: "#runs"});
    if (!done) console.log(`too busy to let go in time, ${alone ? "without" : "with"} a worker`);
  }
}

test("the safe stop wants a hold of 0.5 s, is sent at its end, and the page says why it stopped and what to do", () => both_ways(async (page, server) => {
  const box = await place_of_stop(page, server);
  await note_hold(page);
  for (const y of [10, 200]) {  // let go on the button, and beside it
    await page.mouse.move(box.x + 20, box.y + 10);
    await page.mouse.down();
    await page.mouse.move(box.x + 20, box.y + y);
    await page.mouse.up();
    if (await held_too_long(page)) return false;
  }
  await wait(700);
  assert.deepEqual(server.received, []);
  await page.mouse.move(box.x + 20, box.y + 10);
  const begin_ms = performance.now();
  await page.mouse.down();
  await until(() => server.received.length, "the stop");
  const held_ms = server.received[0].at_ms - begin_ms;
  assert.ok(held_ms >= 490, `${held_ms} ms`);
  console.log(`hold to arrival: ${held_ms.toFixed(1)} ms`);
  await page.mouse.up();
  await see(page, "The print was stopped safely.");
  await see(page, "Cause: The operator stopped the print.");
  await see(page, `firn print --resume ${server.live.id}`);
  assert.equal((await page.$$(".commands")).length, 0);
  assert.deepEqual(server.received.map(one => one.line), [true]);
  assert.match(await page.$eval(".stopped a", a => a.href), /\/manual\/safety\.html#the-stop$/);
}));

test("a busy tab does not delay the stop: its worker times the hold and sends it", () => with_page(async (page, server) => {
  await place_of_stop(page, server);
  await be_busy(page, 430, 3000);
  await page.mouse.down();
  await until(() => server.received.length, "the stop");
  const arrived_ms = performance.timeOrigin + server.received[0].at_ms;
  const busy_until_ms = await (await page.waitForFunction(() => window.busy_until_ms, {polling: 50})).jsonValue();
  assert.ok(arrived_ms < busy_until_ms, `it arrived ${(arrived_ms - busy_until_ms).toFixed(0)} ms after the tab's work`);
  await page.mouse.up();
}));

test("a release that a busy tab hears late stops nothing", () => both_ways(async (page, server) => {
  await place_of_stop(page, server);
  await note_hold(page);
  await be_busy(page, 100, 2000);
  await page.mouse.down();
  await wait(200);
  await page.mouse.up();  // is answered when the tab has time again
  if (await held_too_long(page)) return false;
  await wait(700);
  assert.deepEqual(server.received, []);
}));

test("Ctrl-Shift-Space stops at once, from anywhere; so does a hold of the space key on the button", async () => {
  await with_page(async (page, server) => {
    await see(page, "Printing layer 8");
    await page.focus(".surface select");
    await page.keyboard.down("Control");
    await page.keyboard.down("Shift");
    await page.keyboard.press("Space");
    await see(page, "The print was stopped safely.");
    assert.deepEqual(server.received.map(one => one.command), ["safe_stop"]);
  });
  await with_page(async (page, server) => {
    await (await button(page, "Safe stop: hold")).focus();
    await page.keyboard.down("Space");
    await until(() => server.received.length, "the stop");
    await page.keyboard.up("Space");
    assert.deepEqual(server.received.map(one => one.command), ["safe_stop"]);
  });
});

test("words older than 1 s are grey and lock the commands, but never the safe stop; a lost connection is said and mended", () => with_page(async (page, server) => {
  await see(page, "Printing layer 8");
  await button(page, "Pause");
  server.silent = true;
  await see(page, "commands are locked, the safe stop is not");
  const disabled = () => page.$$eval(".commands > .row button", list => list.map(b => b.disabled));
  assert.deepEqual(await disabled(), [true, true, true, false]);
  await page.waitForSelector(".now.stale");
  await page.waitForSelector(".status.old");
  server.silent = false;
  await gone(page, ".now.stale");
  await until(async () => (await disabled()).join() === "false,true,false,false", "commands that are open again");
  await hold_timers(page, 500);
  for (const tab of server.tabs) tab.socket.terminate();
  await see(page, "No connection to the print");
  await until(async () => (await disabled()).every(Boolean), "commands that are locked");
  await page.evaluate(() => window.go());
  await gone(page, ".locked");
  server.next_layer();
  await see(page, "layer 8 of 8");
}));

test("watching needs no token; a command asks for it once, and again when it was wrong", () => with_page(async (page, server) => {
  await see(page, "Printing layer 8");
  const give = async token => {
    await (await button(page, "Pause")).click();
    await page.waitForSelector("dialog[open]");
    assert.deepEqual(await axe(page), []);
    await page.keyboard.type(token);
    await page.keyboard.press("Enter");
  };
  await give("wrong");
  await see(page, "Pause: a wrong token.");
  await give("right-token");
  await see(page, "Paused after layer 7");
  await (await button(page, "Continue")).click();
  await see(page, "Continue: goes on");
  await page.reload();
  await (await button(page, "Pause")).click();
  await see(page, "Paused after layer 7");
  assert.equal(server.received.filter(one => one.token === "right-token").length, 3);
}, {hash: ""}));

test("a run that was stopped opens with its cause, and foreign text and links stay text", () => with_page(async page => {
  await see(page, "The print was stopped safely: jet A fires nothing.");
  await see(page, "drops without rise (code 12), share of the rise, value 0.11, limit 0.3");
  await see(page, "Clean the nozzle of jet A");
  await see(page, "<img src=x onerror=alert(1)>");
  assert.equal(await page.$("main img"), null);
  assert.equal(await page.$('a[href^="javascript"]'), null);
}, {hash: "#run=20261122-110000-cuboid", prepare: server => {
  const run = server.run("20261122-110000-cuboid");
  run.events.unshift({...run.events[0], n: 0, words: "<img src=x onerror=alert(1)>", manual: "javascript:alert(1)"});
}}));

test("500 layers of 256 x 256 cells open and load only the maps that are asked for", () => with_page(async (page, server, address) => {
  await see(page, "5 of 5");
  await page.click('a[href="#run=20261121-200000-ice-helical-gear"]');
  const begin_ms = performance.now();
  await see(page, "layer 500 of 500");
  await see(page, "All of layer 500:");
  console.log(`first paint with a map: ${(performance.now() - begin_ms).toFixed(0)} ms`);
  await wait(300);
  assert.deepEqual(new Set(server.asked), new Set(["20261121-200000-ice-helical-gear/500/error", "20261121-200000-ice-helical-gear/500/planned"]));
  assert.equal(address.length > 0 && page.troubles.length, 0);
}, {hash: "#runs"}));

test("the last exchange of the instruments of a run that is over comes behind its surface", () => with_page(async (page, server) => {
  await see(page, "All of layer 53");
  await see(page, "sent CMDPOS X | received 12.5");
  assert.deepEqual(server.asked_exchanges.map(one => one.id), ["20261123-140000-cylinder"]);
  assert.ok(server.asked_exchanges[0].maps >= 2);
}, {hash: "#run=20261123-140000-cylinder"}));

test("each lab has the words of the process, and a lab of lines no droplets", () => with_page(async (page, server, address) => {
  await see(page, "the printer of lines with a shuttered aerosol, open, simulated");
  await page.keyboard.press("ArrowLeft");
  await see(page, "Each line's speed answers its cross-section");
  assert.deepEqual(server.asked.filter(path => path.endsWith("/planned")), []);
  await page.goto(`${address}#run=20261121-200000-ice-helical-gear`);
  await see(page, "the robot arm that prints ice, smf");
  await page.goto(`${address}#run=20261123-150000-cylinder`);
  await see(page, "droplets on a stage, mpc");
}, {hash: "#run=20261123-140000-cylinder", prepare: server => {
  Object.assign(server.run("20261123-140000-cylinder"), {lab: "aerosol", printed: 40});
}}));

test("the surface turns in three dimensions, and its cell has the map's value", () => with_page(async (page, server) => {
  await see(page, "All of layer 7");
  await page.select(".surface select", "measured");
  await (await button(page, "3-D")).click();
  await page.waitForSelector("canvas.solid[data-painted]");
  const canvas = await page.$("canvas.solid");
  const before_turn = await canvas.screenshot();
  assert.ok(before_turn.length > 8000, `a picture of ${before_turn.length} bytes`);
  const box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await see(page, " at ");
  const [, x, y] = (await text_of(page, ".readout")).match(/cell (\d+), (\d+)/).map(Number);
  const value = server.live.frame("measured", 7).readFloatLE(32 + 4 * (40 * y + x));
  assert.ok(Math.abs(parseFloat((await text_of(page, ".readout")).replace("−", "-")) - value) <= 0.051, `${value} in ${await text_of(page, ".readout")}`);
  await (await button(page, "Turn left")).click();
  await wait(200);
  assert.notDeepEqual(await canvas.screenshot(), before_turn);
}));

test("a canvas that has no size for a while, as when a window is folded, is no error", () => with_page(async (page, server) => {
  await see(page, "droplets for layer 8");
  await page.$eval("canvas.plan", canvas => { canvas.style.display = "none"; });
  server.next_layer();
  await see(page, "droplets for layer 9");
  await wait(100);
}));

test("the difference to another layer and to another run is the difference of the cells", () => with_page(async (page, server) => {
  await see(page, "All of layer 7");
  await page.select(".surface select", "difference");
  await point_to(page, server.live, 20, 20);
  const expect = async (other, layer) => {
    const at = (run, n) => run.frame("measured", n).readFloatLE(32 + 4 * (40 * 20 + 20));
    const value = Math.fround(at(server.live, 7) - at(other, layer));
    await until(async () => Math.abs(parseFloat((await text_of(page, ".readout")).replace("−", "-")) - value) < 0.006, `${value} in ${await text_of(page, ".readout")}`);
  };
  await expect(server.live, 6);
  await page.waitForFunction(() => document.querySelectorAll(".surface .head select option").length > 5);
  await page.select(".surface .head label:nth-of-type(2) select", "20261123-140000-cylinder");
  await expect(server.run("20261123-140000-cylinder"), 7);
}));

test("runs are searched, sorted, noted in the run, and two are put beside each other with only the settings that differ", () => with_page(async (page, server) => {
  await see(page, "5 of 5");
  await page.type('input[type="search"]', "meta.ink = TPGDA");
  await see(page, "1 of 5");
  await page.click('input[type="search"]', {clickCount: 3});
  await page.type('input[type="search"]', "rms <");
  await see(page, "column 7: a value is wanted behind '<'");
  await page.click('input[type="search"]', {clickCount: 3});
  await page.type('input[type="search"]', "cylinder");
  await see(page, "3 of 5");
  await (await button(page, "RMS")).click();
  const order = () => page.$$eval(".runs tbody tr", rows => rows.map(row => {
    const [value, unit] = row.children[7].innerText.split(": ").pop().split(" ");
    return Number(value) * (unit === "mm" ? 1000 : 1);
  }));
  await until(async () => (await order()).every((rms, i, all) => i === 0 || rms <= all[i - 1]), "descending RMS");
  await see(page, "ink TPGDA, sample PCB-7");
  await (await button(page, "Add tags and a note to 20261123-140000-cylinder")).click();
  await page.type("td.notes textarea", "rim falls");
  await page.type('td.notes input[name="tags"]', ", dull");
  await page.type('td.notes input[name="author"]', "Ada");
  await (await button(page, "Keep")).click();
  await page.waitForSelector("dialog[open]");
  await page.keyboard.type(server.token);
  await page.keyboard.press("Enter");
  await gone(page, "td.notes textarea");
  assert.deepEqual(server.run("20261123-140000-cylinder").notes.map(note => [note.author, note.text]), [["Ada", "rim falls"]]);
  assert.deepEqual(server.run("20261123-140000-cylinder").tags, ["baseline", "dull"]);
  await see(page, "rim falls Ada");
  for (const id of ["20261123-150000-cylinder", "20261123-140000-cylinder"]) await page.click(`input[aria-label="Choose ${id}"]`);
  const chosen = ["20261123-150000-cylinder", "20261123-140000-cylinder"].map(id => `run=${id}`).join("&");
  const reports = () => page.$$eval("a", list => list.filter(one => one.innerText === "Open in report").map(one => one.getAttribute("href")));
  await until(async () => (await reports()).join() === `api/report?${chosen}`, "one report of both");
  await (await button(page, "Put 2 beside each other")).click();
  await see(page, "Settings that differ");
  await until(async () => (await reports()).join() === `api/report?${chosen}`, "the same beside each other");
  await see(page, "control.ki");
  const keys = await page.$$eval('[aria-label="Table of differing settings"] code', list => list.map(one => one.innerText));
  assert.deepEqual(keys, ["control.ki", "control.scheme"]);
  await until(async () => (await page.$$(".beside canvas")).length === 3, "two surfaces and their difference");
  await page.keyboard.press("ArrowLeft");
  await see(page, "Surfaces, layer 52");
  await page.goBack();
  await see(page, "of 5");
}, {hash: "#runs"}));

test("of a thousand runs those in view are drawn, and the others when they come into view", () => with_page(async (page, server) => {
  await see(page, "5 of 5");
  const one = server.runs.find(run => !run.live).summary();
  for (let n = 0; n < 1000; ++n) server.runs.push({id: `many-${n}`, live: false, summary: () => ({...one, id: `many-${n}`, started_utc: "2020-01-01T00:00:00Z"})});
  await page.reload({waitUntil: "load"});
  await see(page, "1005 of 1005");
  const rows = () => page.$$eval(".runs tbody tr", list => list.length);
  assert.ok(await rows() < 200, `${await rows()} rows are drawn before anybody scrolls`);
  await until(async () => {
    await page.evaluate(() => document.querySelector(".runs tbody tr:last-child").scrollIntoView());
    return await rows() === 1005;
  }, "all rows, once they were scrolled to", 60_000);
  await page.type('input[type="search"]', "cylinder");
  await until(async () => await rows() < 200, "the first rows of a search");
}, {hash: "#runs"}));

test("three runs are put beside each other: a surface and a curve each, differences from the first, and the settings that differ among them", () => with_page(async (page, server) => {
  await see(page, "Settings that differ");
  await until(async () => (await page.$$(".beside canvas")).length === 5, "three surfaces, and what two of them differ by from the first");
  await see(page, "control.ki");
  const table = '[aria-label="Table of differing settings"]';
  assert.equal((await page.$$(`${table} thead th`)).length, 4, "a column for each run beside the keys");
  const rows = await page.$$eval(`${table} tbody tr`, all => all.map(row => [...row.children].map(one => one.innerText)));
  for (const [key, ...values] of rows) assert.ok(new Set(values).size > 1, `${key} is the same in all: ${values}`);
  assert.equal((await page.$$('[aria-labelledby="curves-title"] .u-legend .u-series')).length, 4, "the layers' axis and a curve for each run");
  assert.ok(!(await page.evaluate(() => document.body.innerText)).includes("first minus second"), "a difference is of two");
  assert.deepEqual(await axe(page), []);
  await picture(page, "three-beside");
}, {hash: "#compare=20261123-150000-cylinder,20261123-140000-cylinder,20261122-110000-cuboid"}));

test("the lamp's card has the hours of the runs before, of a live print and of one that is over", () => with_page(async (page, server, address) => {
  await see(page, "open in 3 earlier runs in this folder, same port");
  await page.goto(`${address}#run=20261123-140000-cylinder`);
  await see(page, "All of layer 53");
  await see(page, "open in 3 earlier runs in this folder, same port");
}));

test("a run that is not there, and a process that does not answer, are said in words", async () => {
  await with_page(page => see(page, "no run 20200101-nothing"), {
    hash: "#run=20200101-nothing", troubles: ["error: Failed to load resource: the server responded with a status of 404 (Not Found)"]});
  await with_page(async page => {
    await see(page, "Runs");
    await see(page, "4 of 4");
  }, {hash: "", prepare: server => {
    server.live.live = false;
    server.runs = server.runs.filter(run => run !== server.live);
  }});
});

for (const [width, dark] of [[1280, false], [1280, true], [400, false], [400, true]])
  test(`axe finds nothing serious at ${width} px, ${dark ? "dark" : "light"}, and nothing is wider than the window`, () => with_page(async (page, server, address) => {
    const check = async name => {
      await picture(page, `${name}-${width}${dark ? "-dark" : ""}`);
      assert.deepEqual(await axe(page), [], name);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.equal(wide, 0, `${name} is ${wide} px too wide`);
    };
    await see(page, "All of layer 7");
    await page.click(".in-flight summary");
    await page.click("details summary h2");
    server.event("warning", "jet_a", "A warning with a detail", {cause: "c", value: 2, limit: 1, unit: "um", do: "Look.", manual: "/manual/safety.html"});
    await see(page, "A warning with a detail");
    await check("print");
    await (await button(page, "3-D")).click();
    await page.waitForSelector("canvas.solid[data-painted]");
    await check("solid");
    server.silent = true;
    await see(page, "commands are locked");
    await check("stale");
    await page.goto(`${address}#run=20261122-110000-cuboid`);
    await see(page, "Clean the nozzle");
    await check("stopped");
    await page.goto(`${address}#runs`);
    await see(page, "5 of 5");
    await check("runs");
    await page.goto(`${address}#compare=20261123-150000-cylinder,20261123-140000-cylinder`);
    await see(page, "control.ki");
    await check("compare");
  }, {width, dark}));

test("with reduced motion nothing moves by itself", () => with_page(async page => {
  await see(page, "Printing layer 8");
  await page.emulateMediaFeatures([{name: "prefers-reduced-motion", value: "reduce"}]);
  const moving = await page.evaluate(() => [...document.querySelectorAll("*")].flatMap(e => [getComputedStyle(e), getComputedStyle(e, "::before")])
    .filter(s => s.transitionDuration !== "0s" || s.animationName !== "none").length);
  assert.equal(moving, 0);
}));
