// Pictures of every page, for people to look at: node test/look.mjs FOLDER

import {launch, open_tab, picture, see, button} from "./browser.mjs";
import {MockServer} from "./mock_server.mjs";

process.env.FIRN_WEB_PICTURES = process.argv[2];
const server = new MockServer();
const address = await server.start();
const browser = await launch();
for (let k = 0; k < 11; ++k) server.next_layer();
for (const [width, dark] of [[1280, false], [1280, true], [400, false]]) {
  const name = `${width}${dark ? "-dark" : ""}`;
  const page = await open_tab(browser, `${address}#token=${server.token}`, {width, dark});
  await see(page, "cells seen");
  const box = await (await page.$("canvas.map")).boundingBox();
  await page.mouse.move(box.x + box.width * 0.3, box.y + box.height * 0.4);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.7, box.y + box.height * 0.6, {steps: 4});
  await page.mouse.up();
  await see(page, "Section from A");
  await new Promise(r => setTimeout(r, 400));
  await picture(page, `live-${name}`, {fullPage: true});
  await (await button(page, "3-D")).click();
  await page.select(".surface select", "measured");
  await new Promise(r => setTimeout(r, 800));
  await picture(page, `solid-${name}`);
  await page.goto(`${address}#run=20261122-110000-cuboid`);
  await see(page, "Clean the nozzle");
  await new Promise(r => setTimeout(r, 400));
  await picture(page, `stopped-${name}`);
  await page.goto(`${address}#runs`);
  await see(page, "the reference");
  await picture(page, `runs-${name}`);
  await page.goto(`${address}#compare=20261123-150000-cylinder,20261123-140000-cylinder`);
  await see(page, "control.ki");
  await new Promise(r => setTimeout(r, 600));
  await picture(page, `compare-${name}`, {fullPage: true});
  await page.goto(`${address}#run=20261121-200000-ice-helical-gear`);
  await see(page, "cells seen", 30000);
  await new Promise(r => setTimeout(r, 600));
  await picture(page, `ice-${name}`, {fullPage: true});
  console.log(name, page.troubles);
  await page.close();
}
await browser.close();
await server.end();
