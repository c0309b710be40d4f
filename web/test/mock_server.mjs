// Stands in for the process `page`: same addresses, same frames, same headers; prints when it is told to.

import {createServer} from "node:http";
import {readFileSync} from "node:fs";
import {dirname, join} from "node:path";
import {fileURLToPath} from "node:url";
import {WebSocketServer} from "ws";
import {mock_runs} from "./mock_runs.mjs";

const kDist = join(dirname(fileURLToPath(import.meta.url)), "../dist");
const kFiles = {"/": ["index.html", "text/html; charset=utf-8"], "/app.js": ["app.js", "text/javascript; charset=utf-8"], "/line.js": ["line.js", "text/javascript; charset=utf-8"], "/app.css": ["app.css", "text/css; charset=utf-8"]};
const kHeaders = {"Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'", "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer"};

export class MockServer {
  constructor() {
    this.token = "right-token";
    this.runs = mock_runs();
    this.live = this.runs.find(run => run.live);
    this.state = {state: "depositing", words: "Printing layer 8", paused: false, stopping: false, doubt: null};
    this.ages = {link_s: 0, surface_s: 12.3, instruments_s: 0.1, controller_s: 0.4};
    this.received = [];  // commands, with the time of their arrival
    this.asked = [];     // paths of maps
    this.asked_exchanges = [];
    this.asked_thumbnails = [];
    this.resumed = [];   // runs
    this.resume_trouble = null;
    this.acknowledged = [];  // bodies of requests
    this.you = null;     // who the reader is
    this.audits = new Map();  // verdicts of runs, else "clean"
    this.map_delays_ms = {};  // of runs
    this.silent = false;
    this.lines = 0;      // that were opened for commands
    this.tabs = new Set();
  }

  async start(port = 0) {
    this.http = createServer((request, response) => void this.serve(request, response));
    this.sockets = new WebSocketServer({noServer: true});
    this.http.on("upgrade", (request, socket, head) => this.upgrade(request, socket, head));
    await new Promise(resolve => this.http.listen(port, "127.0.0.1", resolve));
    this.timer = setInterval(() => this.tell_state(), 250);
    return `http://127.0.0.1:${this.http.address().port}/`;
  }

  async end() {
    clearInterval(this.timer);
    for (const socket of this.sockets.clients) socket.terminate();
    this.http.closeAllConnections();
    await new Promise(resolve => this.http.close(resolve));
  }

  run(id) {
    return this.runs.find(run => run.id === id || (id === "live" && run.live));
  }

  full_state(run = this.live) {
    if (!run.live) return {t_s: run.time_s(run.printed), state: run.outcome, words: run.outcome === "finished" ? "Finished" : "Stopped", layer: run.printed, layers: run.planned, eta_s: null, ages: {}, paused: false, stopping: false, doubt: null};
    return {t_s: run.time_s(run.printed) + 9, layer: Math.min(run.printed + 1, run.planned), layers: run.planned, eta_s: (run.planned - run.printed) * 23.4, ages: this.ages, ...this.state};
  }

  async serve(request, response) {
    const url = new URL(request.url, "http://x");
    const send = (status, type, body) => {
      response.writeHead(status, {...kHeaders, "Content-Type": type});
      response.end(body);
    };
    const json = (status, body) => send(status, "application/json", JSON.stringify(body));
    if (kFiles[url.pathname]) return send(200, kFiles[url.pathname][1], readFileSync(join(kDist, kFiles[url.pathname][0])));
    const where = url.pathname === "/api/runs" && url.searchParams.get("where");
    if (where) {  // one condition is enough for the page's side
      const [, key, value] = where.match(/^meta\.(\w+) = (\w+)$/) ?? [];
      return key ? json(200, {runs: this.runs.filter(run => run.meta[key] === value).map(run => run.summary())})
        : json(200, {runs: [], error: "column 7: a value is wanted behind '<'"});
    }
    if (url.pathname === "/api/runs") return json(200, {runs: this.runs.map(run => run.summary())});
    const parts = url.pathname.split("/").filter(Boolean).map(decodeURIComponent);
    if (parts[0] !== "api" || parts[1] !== "runs") return json(404, {error: "no such address"});
    const run = this.run(parts[2]);
    if (!run && parts[2] === "live") return send(204, "text/plain", "");
    if (!run) return json(404, {error: `no run ${parts[2]}`});
    if (parts.length === 3) return json(200, this.hello(run));
    if (parts[3] === "acknowledge" && request.method === "POST") {
      let text = "";
      for await (const part of request) text += part;
      const body = JSON.parse(text);
      if (body.token !== this.token) return json(403, {type: "error", error: "a wrong token"});
      this.acknowledged.push(body);
      const alarms = this.acknowledged.map(one => ({alarm: one.alarm, author: one.author, time_utc: "2026-12-01T12:00:00Z"}));
      this.tell({type: "acknowledged", alarms});
      return json(200, {type: "acknowledged", alarms});
    }
    if (parts[3] === "thumbnail") {
      this.asked_thumbnails.push(run.id);
      return run.without_map || run.live || !run.thumbnail ? send(204, "text/plain", "") : send(200, "image/bmp", run.thumbnail());
    }
    if (parts[3] === "audit") return json(...(run.live ? [409, {type: "error", error: "the run is being printed"}]
                                                       : [200, this.audits.get(run.id) ?? {clean: true, text: "clean: 53 layers, 106 passes\nsealed: 2 seals, 31 files, 0123\n"}]));
    if (parts[3] === "resume" && request.method === "POST") {
      let text = "";
      for await (const part of request) text += part;
      if (JSON.parse(text).token !== this.token) return json(403, {type: "error", error: "a wrong token"});
      if (this.resume_trouble) return json(409, {type: "error", error: this.resume_trouble});
      this.resumed.push(run.id);
      this.live.live = false;
      this.live = Object.assign(run, {live: true, end: null});
      return json(200, {ok: true, pid: 4711});
    }
    if (parts[3] === "notes" && request.method === "POST") {
      let text = "";
      for await (const part of request) text += part;
      const body = JSON.parse(text);
      if (body.token !== this.token) return json(403, {ok: false, error: "a wrong token"});
      const note = body.note && {time_utc: "2026-11-30T12:00:00Z", author: body.author || "server", text: body.note};
      Object.assign(run, {tags: [...run.tags.filter(tag => !body.remove_tags.includes(tag)), ...body.add_tags], notes: [...run.notes, ...(note ? [note] : [])]});
      return json(200, {tags: run.tags, notes: run.notes});
    }
    if (parts[3] === "exchanges") {
      this.asked_exchanges.push({id: run.id, maps: this.asked.length});
      return json(200, {exchanges: [{name: "stage", text: "sent CMDPOS X | received 12.5"}]});
    }
    if (parts[3] === "lamp") return json(200, {lamp: "simulated", earlier_h: 1.25, earlier_runs: 3});
    if (parts[3] === "layers") {
      this.asked.push(`${run.id}/${parts[4]}/${parts[5]}`);
      await new Promise(resolve => setTimeout(resolve, this.map_delays_ms[run.id] ?? 0));
      if (!run.has(parts[5], Number(parts[4]))) return send(204, "text/plain", "");
      return send(200, "application/octet-stream", run.frame(parts[5], Number(parts[4])));
    }
    return json(404, {error: "no such address"});
  }

  /** Watching on /ws; commands alone on /command, with the token as a protocol. */
  upgrade(request, socket, head) {
    const url = new URL(request.url, "http://x");
    const line = url.pathname === "/command";
    if (line && request.headers["sec-websocket-protocol"] !== `firn, ${this.token}`) return socket.end("HTTP/1.1 403 Forbidden\r\n\r\n");
    this.sockets.handleUpgrade(request, socket, head, open => {
      if (!line) return this.connect(open, url.searchParams.get("run"));
      ++this.lines;
      open.on("message", text => this.take({socket: open, line}, JSON.parse(text)));
    });
  }

  connect(socket, id) {
    const run = this.run(id);
    if (!run) {
      socket.send(JSON.stringify({type: "error", error: `no run ${id}`}));
      return socket.close();
    }
    const tab = {socket, run, surface: null};
    this.tabs.add(tab);
    socket.on("close", () => this.tabs.delete(tab));
    socket.on("message", text => this.take(tab, JSON.parse(text)));
    socket.send(JSON.stringify(this.hello(run)));
  }

  hello(run) {
    const greeting = run.hello(this.full_state(run));
    if (this.you) greeting.you = this.you;
    if (this.you && !this.you.commands && !this.you.needs_token) greeting.commands.allowed = [];
    return greeting;
  }

  take(tab, message) {
    if (message.type === "follow") {
      tab.surface = message.surface;
      this.send_map(tab);
    } else if (message.type === "command") {
      this.received.push({...message, line: !!tab.line, at_ms: performance.now()});
      const answer = (ok, error, words = null) => tab.socket.send(JSON.stringify({type: "answer", id: message.id, ok, error, words}));
      if (message.token !== this.token) return answer(false, "a wrong token");
      if (this.refuse) return answer(false, this.refuse);
      answer(true, null, this.obey(message));
    }
  }

  obey(message) {
    const say = {pause: "waits after this layer", continue: "goes on", stop_after_layer: "stops after this layer", safe_stop: "the lab is safe", set: "from the next decision on", accept_doubt: "accepted"};
    const words = {pause: "Paused after layer " + this.live.printed, continue: "Printing layer " + (this.live.printed + 1), stop_after_layer: "Prints the last layer, then stops", safe_stop: "Stopped"};
    if (message.command === "pause") Object.assign(this.state, {state: "paused", paused: true});
    if (message.command === "continue") Object.assign(this.state, {state: "depositing", paused: false});
    if (message.command === "stop_after_layer") this.state.stopping = true;
    if (message.command === "set") this.tell({type: "setting", key: message.key, value: message.value});
    if (message.command === "accept_doubt") this.state.doubt = null;
    this.state.words = words[message.command] ?? this.state.words;
    this.event("notice", "operator", `The operator said: ${message.command.replace(/_/g, " ")}${message.key ? ` ${message.key} = ${message.value}` : ""}.`);
    if (message.command === "safe_stop") this.stop("The operator stopped the print.");
    this.tell_state();
    return say[message.command];
  }

  event(severity, source, words, more = {}) {
    const event = {n: this.live.events.length + 1, t_s: this.live.time_s(this.live.printed) + 9, severity, source, words, cause: null, value: null, limit: null, unit: null, do: null, manual: null, ...more};
    if (["warning", "fault", "stop"].includes(severity)) event.alarm = `${event.t_s.toFixed(3)} s, ${source}: ${words}`;
    this.live.events.push(event);
    this.tell({type: "event", ...event});
  }

  stop(cause) {
    const resume = `Look at the machine, then: firn print --resume ${this.live.id}`;
    this.event("stop", "safety", "The print was stopped safely.", {cause, do: resume, manual: "/manual/safety.html#the-stop"});
    this.tell({type: "end", outcome: "stopped safely", words: "The print was stopped safely.", cause, do: resume, manual: "/manual/safety.html#the-stop"});
    Object.assign(this.live, {live: false, outcome: "stopped safely"});
  }

  /** The next layer: a part of its map while it is measured, then all of it. */
  next_layer() {
    const n = this.live.printed + 1;
    for (const tab of this.tabs) if (tab.surface && tab.run === this.live && tab.surface !== "planned") tab.socket.send(this.live.frame(tab.surface, n, this.live.ny >> 1));
    const layer = this.live.print_layer();
    this.tell({type: "layer", ...layer});
    for (const tab of this.tabs) this.send_map(tab);
    for (const estimate of this.live.estimates().filter(one => one.t_s === layer.t_s)) this.tell({type: "estimate", ...estimate});
    this.event("info", "scheduler", `Layer ${layer.n} was printed and measured.`);
    this.state.words = `Printing layer ${layer.n + 1}`;
    this.tell_state();
  }

  send_map(tab) {
    if (tab.surface && tab.run.has(tab.surface, tab.run.printed)) tab.socket.send(tab.run.frame(tab.surface, tab.run.printed));
  }

  tell(message) {
    const text = JSON.stringify(message);
    for (const tab of this.tabs) if (tab.run === this.live) tab.socket.send(text);
  }

  tell_state() {
    if (this.live.live && !this.silent) this.tell({type: "state", ...this.full_state()});
  }
}
