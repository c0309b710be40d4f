// A live print with its page, and what a browser that holds the stop button sees.

import {spawn, spawnSync} from "node:child_process";
import {readdirSync, readFileSync} from "node:fs";
import {join} from "node:path";
import {createInterface} from "node:readline";
import {button} from "./browser.mjs";

const kHold_ms = 500;  // src/data/hold.ts

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

/** Holds the button of the safe stop until it is answered. @returns times of CLOCK_MONOTONIC [ms]: the hold's end, the
 *  command that leaves the tab, the answer that comes back */
export async function hold_stop(page) {
  const box = await (await button(page, "Safe stop: hold")).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.waitForFunction(() => window.times.answered_ms !== null, {polling: 50, timeout: 20_000});
  await page.mouse.up();
  const {down_ms, sent_ms, answered_ms} = await page.evaluate(() => window.times);
  const {NavigationStart} = await page.metrics_of_clock();
  const at_ms = ms => 1000 * NavigationStart + ms;
  return {ended_ms: at_ms(down_ms + kHold_ms), sent_ms: at_ms(sent_ms), answered_ms: at_ms(answered_ms)};
}

/** Notes, in the tab, when the pointer went down, when the stop was sent and when it was answered: by the line's worker, or by
 *  a WebSocket of the page's own thread. */
export async function note_times(page) {
  const client = await page.createCDPSession();
  await client.send("Performance.enable");
  page.metrics_of_clock = async () => Object.fromEntries((await client.send("Performance.getMetrics")).metrics.map(({name, value}) => [name, value]));
  await page.evaluateOnNewDocument(() => {
    window.times = {down_ms: null, sent_ms: null, answered_ms: null};
    addEventListener("pointerdown", event => { window.times.down_ms = event.timeStamp; }, true);
    const answered = text => {
      if (typeof text === "string" && text.startsWith('{"type":"answer"')) window.times.answered_ms = performance.now();
    };
    const {WebSocket, Worker} = window;
    window.WebSocket = class extends WebSocket {
      send(text) {
        if (typeof text === "string" && text.includes('"safe_stop"')) window.times.sent_ms = performance.now();
        super.send(text);
      }

      constructor(...words) {
        super(...words);
        this.addEventListener("message", event => answered(event.data));
      }
    };
    window.Worker = class extends Worker {
      constructor(...words) {
        super(...words);
        this.addEventListener("message", ({data}) => {
          if (data.kind === "ended" && data.sent) window.times.sent_ms = data.at_ms - performance.timeOrigin;
          if (data.kind === "heard") answered(data.text);
        });
      }
    };
  });
}

/** When an order and the stop were first heard on the bus, by the nodes' write-ahead files: CLOCK_MONOTONIC [ms]. */
export function bus_times(firn, run) {
  const [, epoch_ns, offset_us, scale] = readFileSync(join(run, "clocks"), "utf8").trim().split("\n").pop().split(" ").map(Number);
  const first_ms = (files, channel) => Math.min(...files.map(file => {
    const said = spawnSync(firn, ["log", "cat", file, "-c", channel], {encoding: "utf8"}).stdout;
    const heard = said.split("\n").filter(line => line.includes('"event":"message"')).map(line => JSON.parse(line).now_us);
    return heard.length ? epoch_ns / 1e6 + (Math.min(...heard) - offset_us) / scale / 1e3 : Infinity;
  }));
  const nodes = readdirSync(join(run, "nodes")).filter(name => name.endsWith(".wal")).map(name => join(run, "nodes", name));
  return {ordered_ms: first_ms(nodes.filter(file => file.endsWith("/safety.wal")), "OPERATOR_COMMAND"),
          stopped_ms: first_ms(nodes.filter(file => !/\/(safety|recorder)\.wal$/.test(file)), "SAFE_STOP")};
}
