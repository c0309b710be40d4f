// The pictures of docs/page.md from real runs: node test/pictures.mjs URL FOLDER GOOD OTHER STOPPED, the URL with its token. They are
// recorded runs with these names.

import {button, launch, open_tab, picture, see} from "./browser.mjs";

const [address, folder, good, other, stopped] = process.argv.slice(2);
process.env.FIRN_WEB_PICTURES = folder;
const browser = await launch();
const rest = () => new Promise(resolve => setTimeout(resolve, 800));
/** The 3-D drawing is of the layer that the time cursor names. */
const painted = page => page.waitForFunction(() => {
  const layer = /layer (\d+)/.exec(document.querySelector(".timeline output").innerText)?.[1];
  return document.querySelector("canvas.solid")?.dataset.painted === `measured ${layer}`;
}, {timeout: 60_000, polling: 100});
const run_of = id => `${address}&run=${encodeURIComponent(id)}`;

const page = await open_tab(browser, run_of(good), {width: 1060, height: 690});
await see(page, "cells seen", 60_000);
await page.select(".surface select", "measured");
await (await button(page, "3-D")).click();
for (let n = 0; n < 6; ++n) await page.keyboard.press("ArrowLeft");
await painted(page);
await rest();
await picture(page, "page-surface");

await page.goto("about:blank");
await page.setViewport({width: 1060, height: 760});
await page.goto(run_of(stopped));
await see(page, "What to do:", 60_000);
await see(page, "cells seen", 60_000);
await rest();
await picture(page, "page-stop");

await page.goto("about:blank");
await page.setViewport({width: 1060, height: 1010});
await page.goto(`${address}&compare=${[good, other].map(encodeURIComponent).join(",")}`);
await see(page, " minus ", 60_000);
for (let n = 0; n < 30; ++n) await page.keyboard.press("ArrowLeft");
await rest();
await picture(page, "page-beside");
if (page.troubles.length) console.log(page.troubles.join("\n"));
await browser.close();
process.exit(page.troubles.length ? 1 : 0);
