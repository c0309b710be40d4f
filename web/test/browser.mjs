// Debian's chromium, driven over puppeteer-core, and helpers of the tests that look through it.

import {existsSync, mkdirSync} from "node:fs";
import {createRequire} from "node:module";
import {join} from "node:path";
import puppeteer from "puppeteer-core";

export const kChromium = process.env.FIRN_CHROMIUM ?? "/usr/bin/chromium";
const kAxe = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

export function launch() {
  if (!existsSync(kChromium)) throw new Error(`${kChromium} does not exist`);
  return puppeteer.launch({executablePath: kChromium, headless: true, protocolTimeout: 120_000,
    args: ["--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-extensions", "--disable-background-networking", "--mute-audio"]});
}

/** A tab that remembers what went wrong in it and which addresses it asked. */
export async function open_tab(browser, address, {width = 1280, height = 900, dark = false} = {}) {
  const page = await browser.newPage();
  page.troubles = [];
  page.asked = [];
  page.on("pageerror", error => page.troubles.push(`error: ${error.message}`));
  page.on("console", message => {
    // The browser notes an answer that refuses: the token is wrong, the order cannot be obeyed.
    if (["error", "warn"].includes(message.type()) && !/403 \(Forbidden\)|409 \(Conflict\)/.test(message.text())) page.troubles.push(`${message.type()}: ${message.text()}`);
  });
  page.on("request", request => page.asked.push(request.url()));
  await page.setViewport({width, height});
  await page.emulateMediaFeatures([{name: "prefers-color-scheme", value: dark ? "dark" : "light"}]);
  await page.goto(address, {waitUntil: "load"});
  return page;
}

/** Waits until the page's text holds `words`. */
export function see(page, words, timeout = 15_000) {
  return page.waitForFunction(text => document.body.innerText.includes(text), {timeout, polling: 50}, words)
    .catch(() => page.evaluate(() => document.body.innerText).then(text => { throw new Error(`never saw "${words}" in:\n${text.slice(0, 1500)}`); }));
}

export function gone(page, selector, timeout = 15_000) {
  return page.waitForFunction(s => !document.querySelector(s), {timeout, polling: 50}, selector);
}

/** The button with these words, once it can be pressed. */
export async function button(page, words) {
  const handle = await page.waitForFunction(
    text => [...document.querySelectorAll("button")].find(b => (b.innerText.trim() === text || b.getAttribute("aria-label") === text) && !b.disabled), {timeout: 15_000, polling: 50}, words)
    .catch(() => { throw new Error(`no button "${words}" that can be pressed`); });
  return handle.asElement();
}

/** Serious and critical findings of axe, a line each. */
export async function axe(page) {
  // Injected as a debugger would, beside the page's content security policy.
  const {readFileSync} = await import("node:fs");
  await page.evaluate(readFileSync(kAxe, "utf8"));
  return page.evaluate(async () => {
    const {violations} = await window.axe.run(document, {resultTypes: ["violations"]});
    return violations.filter(one => ["serious", "critical"].includes(one.impact)).map(one => `${one.id}: ${one.help}: ${one.nodes.map(n => n.html + " " + (n.any[0]?.message ?? "")).slice(0, 4).join(" | ")}`);
  });
}

/** Saves a picture where FIRN_WEB_PICTURES names a folder. */
export async function picture(page, name, options = {}) {
  const folder = process.env.FIRN_WEB_PICTURES;
  if (!folder) return;
  mkdirSync(folder, {recursive: true});
  await page.screenshot({path: join(folder, `${name}.png`), ...options});
}
