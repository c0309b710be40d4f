// Alarms: listed, acknowledged by name and recorded; told by the tab's title and by the browser.

import assert from "node:assert/strict";
import {test} from "node:test";
import {axe, button, picture, see} from "./browser.mjs";
import {until, with_page} from "./with_page.mjs";

const title = (page, words) => page.waitForFunction(text => document.title.includes(text), {timeout: 15_000, polling: 50}, words);

test("the title says what goes on and counts the alarms that nobody has acknowledged", () => with_page(async (page, server) => {
  await title(page, "printing, layer 8 of 53 · ");
  server.event("warning", "jet", "Fewer droplets than commanded.");
  server.event("fault", "lamp", "The lamp is disconnected.");
  await title(page, "(2!) printing, layer 8 of 53");
  server.stop("the lamp is disconnected");
  await title(page, "(3!) ");
  assert.doesNotMatch(await page.title(), /printing/);
}));

test("an alarm is acknowledged by name, and all tabs see who and when", () => with_page(async (page, server) => {
  server.event("warning", "jet", "Fewer droplets than commanded.");
  await see(page, "1 not acknowledged");
  const press = await page.waitForFunction(() => [...document.querySelectorAll(".alarms button")].find(b => b.innerText === "Acknowledge"));
  assert.equal(await page.evaluate(b => b.disabled, press), true);  // by name
  await page.type('.alarms input[name="alarm-author"]', "Ada Lovelace");
  await (await button(page, "Acknowledge")).click();
  await see(page, "acknowledged by Ada Lovelace");
  await see(page, "all acknowledged");
  assert.deepEqual(server.acknowledged, [{token: server.token, author: "Ada Lovelace", alarm: server.live.events.at(-1).alarm}]);
  await title(page, "printing, layer 8");
  assert.deepEqual(await axe(page), []);
  await picture(page, "alarms");
}));

test("who is known by his token acknowledges by his own name, and is asked for none", () => with_page(async (page, server) => {
  await see(page, "Ada Lovelace");
  server.event("fault", "jet", "The jet is gone.");
  await (await button(page, "Acknowledge")).click();
  await until(() => server.acknowledged.length, "the acknowledgement");
  assert.equal(await page.$('.alarms input[name="alarm-author"]'), null);
  assert.equal(server.acknowledged[0].author, "Ada Lovelace");
}, {prepare: server => { server.you = {name: "Ada Lovelace", commands: true, needs_token: true}; }}));

test("an observer sees alarms and who he is, and can press nothing", () => with_page(async (page, server) => {
  await see(page, "Olga, observer");
  server.event("fault", "jet", "The jet is gone.");
  await see(page, "1 not acknowledged");
  assert.equal(await page.$(".alarms button"), null);
  const open = await page.$$eval(".commands button:not([disabled])", all => all.map(one => one.innerText.trim()));
  assert.deepEqual(open.filter(words => !/Safe stop/.test(words)), []);
}, {prepare: server => { server.you = {name: "Olga", commands: false, needs_token: false}; }}));

test("the browser notifies of a new alarm where the reader wants it, and of none that was there before", () => with_page(async (page, server) => {
  await see(page, "notify me");
  await page.evaluate(() => {
    window.told = [];
    window.Notification = class { static permission = "granted"; static requestPermission = async () => "granted"; constructor(t, o) { window.told.push([t, o.body]); } };
    localStorage.setItem("firn-notify", "yes");
  });
  server.event("warning", "jet", "Fewer droplets than commanded.");
  await page.waitForFunction(() => window.told.length === 1, {timeout: 15_000});
  const [[head, body]] = await page.evaluate(() => window.told);
  assert.match(head, /: warning$/);
  assert.equal(body, "jet: Fewer droplets than commanded.");
}));
