// Runs a test's look at the page with a server and a tab of its own; the browser is one for each file of tests.

import assert from "node:assert/strict";
import {after, before} from "node:test";
import {launch, open_tab} from "./browser.mjs";
import {MockServer} from "./mock_server.mjs";
import {PrefixProxy} from "./prefix_proxy.mjs";

let browser;
before(async () => { browser = await launch(); });
after(() => browser?.close());

/** Runs `look` with a server of its own and a tab on it. `troubles`: what the browser must write into its console. */
export async function with_page(look, {hash, prepare, troubles = [], ...options} = {}) {
  const server = new MockServer();
  prepare?.(server);
  const address = await server.start();
  const page = await open_tab(browser, address + (hash ?? `#token=${server.token}`), options);
  try {
    await look(page, server, address);
    assert.deepEqual(page.troubles, troubles);
    assert.deepEqual(page.asked.filter(url => !url.startsWith(address)), [], "foreign addresses");
  } finally {
    await page.close();
    await server.end();
  }
}

/** The same below a prefix of a proxy. */
export async function with_proxied_page(look, options) {
  const server = new MockServer();
  const proxy = new PrefixProxy(await server.start(), "/lab/firn/", options);
  const address = await proxy.start();
  const page = await open_tab(browser, `${address}#token=${server.token}`);
  try {
    await look(page, server);
    assert.deepEqual(proxy.foreign.filter(path => path !== "/favicon.ico"), [], "addresses beside the prefix");
  } finally {
    await page.close();
    await proxy.end();
    await server.end();
  }
}

export const wait = ms => new Promise(resolve => setTimeout(resolve, ms));
export const text_of = (page, selector) => page.$eval(selector, element => element.innerText);

export async function until(condition, words, timeout_ms = 10_000) {
  for (const begin = performance.now(); !(await condition()); await wait(20))
    if (performance.now() - begin > timeout_ms) assert.fail(`waited in vain for ${words}`);
}
