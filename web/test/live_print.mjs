// A live print with its page, and what a browser that holds the stop button sees.

import {spawn} from "node:child_process";
import {createInterface} from "node:readline";
import {button} from "./browser.mjs";

const kHold_ms = 500;  // src/panels/hold_button.ts

/** Starts a program; `line` resolves with the first value that `found` makes of a line. */
export function start(program, words, found) {
  const child = spawn(program, words, {stdio: ["ignore", "pipe", "pipe"]});
  const said = [];
  const line = new Promise((resolve, reject) => {
    for (const stream of [child.stdout, child.stderr])
      createInterface({input: stream}).on("line", text => {
        said.push(text);
        const value = found(text);
        if (value) resolve(value);
      });
    child.on("exit", code => reject(new Error(`${program} ${words.join(" ")} ended with ${code}:\n${said.join("\n")}`)));
  });
  line.catch(() => {});
  return {child, line, said};
}

/** The exit code, once it has ended; after `patience_ms` it is interrupted. */
export async function ended(child, patience_ms = 0) {
  if (child.exitCode !== null) return child.exitCode;
  const timer = setTimeout(() => child.kill("SIGINT"), patience_ms);
  const code = await new Promise(resolve => child.on("exit", resolve));
  clearTimeout(timer);
  return code;
}

/** Starts a live print on a terminal of its own, which alone is told the token; resolves with the page's address. */
export async function print_with_page(firn, experiment, runs, more = []) {
  const words = [firn, "print", experiment, "--runs", runs, "--page", ...more].map(word => `'${word}'`).join(" ");
  const print = start("script", ["-qefc", words, "/dev/null"], text => text.match(/http:\/\/\S+#token=[0-9a-f]{32}/)?.[0]);
  return {...print, address: await print.line};
}

/** Holds the button of the safe stop until it is answered. @returns times [ms] from the hold's end to the command that
 *  leaves the tab, and from there to the answer */
export async function hold_stop(page) {
  const box = await (await button(page, "Safe stop: hold")).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.waitForFunction(() => window.times.answered_ms !== null, {polling: 20, timeout: 20_000});
  await page.mouse.up();
  const {down_ms, sent_ms, answered_ms} = await page.evaluate(() => window.times);
  return [sent_ms - down_ms - kHold_ms, answered_ms - sent_ms];
}

/** Notes, in the tab, when the pointer went down and when an answer came. */
export function note_times(page) {
  return page.evaluateOnNewDocument(() => {
    window.times = {down_ms: null, sent_ms: null, answered_ms: null};
    addEventListener("pointerdown", event => { window.times.down_ms = event.timeStamp; }, true);
    const {WebSocket} = window;
    window.WebSocket = class extends WebSocket {
      send(text) {
        if (typeof text === "string" && text.includes('"safe_stop"')) window.times.sent_ms = performance.now();
        super.send(text);
      }

      constructor(...words) {
        super(...words);
        this.addEventListener("message", event => {
          if (typeof event.data === "string" && event.data.startsWith('{"type":"answer"')) window.times.answered_ms = performance.now();
        });
      }
    };
  });
}
