// Synthetic runs as the process `page` tells of them: seeded, computed as they are asked for.

const kLabs = {inkjet: ["droplets on a stage", "droplets"], ice: ["the robot arm that prints ice", "paths"], aerosol: ["the printer of lines with a shuttered aerosol", "lines"]};
const kSurfaces = ["measured", "target", "error", "planned", "predicted", "truth"];

/** Noise in -1..1 of integers: the same on every machine. */
function noise(...words) {
  let h = 2166136261;
  for (const word of words) {
    h = Math.imul(h ^ (word + 0x9e3779b9), 16777619);
    h ^= h >>> 13;
    h = Math.imul(h, 0x5bd1e995);
  }
  return ((h ^ (h >>> 15)) >>> 0) / 2147483648 - 1;
}

/** Sum of a normal kind: noise of three draws. */
const scatter = (...words) => (noise(1, ...words) + noise(2, ...words) + noise(3, ...words)) / 1.7;

function inside_disc(u, v) {
  return Math.hypot(u, v) < 0.8;
}

function inside_gear(u, v) {
  const r = Math.hypot(u, v);
  return r > 0.25 && r < 0.72 + 0.13 * Math.tanh(6 * Math.sin(14 * Math.atan2(v, u)));
}

export class MockRun {
  constructor(of) {
    Object.assign(this, {seed: 1, planned: of.printed, layer_um: 1.9, gain: 0.8, noise_um: 0.9, tags: [], notes: [], meta: {}, live: false,
                         outcome: "finished", events: [], simulated: true, settings: {}}, of);
    this.inside = this.lab === "ice" ? inside_gear : inside_disc;
    this.layers = [];
    const printed = this.printed;
    this.printed = 0;
    while (this.printed < printed) this.print_layer();
  }

  /** Error [um] of a cell: a rim that the scheme corrects, a ripple, noise, a dead spot. */
  error_um(x, y, layer) {
    const {nx, ny} = this;
    const [u, v] = [(2 * x) / (nx - 1) - 1, (2 * y) / (ny - 1) - 1];
    if (!this.inside(u, v)) return 0.15 * this.noise_um * scatter(this.seed, 7, x, y, layer);
    const settled = Math.exp(-this.gain * layer * 0.12);
    const rim = -5 * this.noise_um * (0.25 + 0.75 * settled) * Math.max(0, Math.hypot(u, v) - 0.6) * 4 * Math.min(1, layer / 4);
    const ripple = 1.6 * this.noise_um * settled * Math.sin(9 * u + 2 * v) * Math.min(1, layer / 3);
    return rim + ripple + this.noise_um * scatter(this.seed, x, y, layer);
  }

  target_um(x, y, layer) {
    const [u, v] = [(2 * x) / (this.nx - 1) - 1, (2 * y) / (this.ny - 1) - 1];
    return this.inside(u, v) ? layer * this.layer_um : 0;
  }

  value(kind, x, y, layer) {
    const target = this.target_um(x, y, layer);
    switch (kind) {
      case "target":
        return target;
      case "error":
        return layer === 0 ? this.error_um(x, y, 0) : this.error_um(x, y, layer);
      case "planned": {
        if (this.target_um(x, y, 1) === 0) return 0;
        const wanted = 1 - this.error_um(x, y, layer) / (4 * this.noise_um);
        return this.lab === "ice" ? Math.max(0.7, Math.min(1.3, 1 + 0.2 * (wanted - 1))) : wanted > 2 ? 2 : wanted > 0.6 ? 1 : 0;
      }
      case "predicted":
        return target + 0.8 * this.error_um(x, y, layer);
      case "truth":
        return target + this.error_um(x, y, layer) - 0.1 * this.noise_um * scatter(this.seed, 5, x, y, layer);
      default:
        return target + this.error_um(x, y, layer);
    }
  }

  /** Bytes of a map frame; `rows` of a map that is being measured. */
  frame(kind, layer, rows = this.ny) {
    const bytes = Buffer.alloc(32 + 4 * this.nx * this.ny);
    bytes.write("FMAP", 0, "latin1");
    bytes.writeUInt16LE(1, 4);
    bytes.writeUInt16LE(kSurfaces.indexOf(kind), 6);
    bytes.writeUInt32LE(layer, 8);
    bytes.writeUInt32LE(this.nx, 12);
    bytes.writeUInt32LE(this.ny, 16);
    const planned = kind === "planned" ? (this.lab === "ice" ? 4 : 1) : 0;
    bytes.writeUInt32LE(planned | (rows < this.ny ? 2 : 0), 20);
    bytes.writeDoubleLE(this.time_s(layer), 24);
    for (let y = 0, at = 32; y < this.ny; ++y)
      for (let x = 0; x < this.nx; ++x, at += 4) {
        const lost = kind !== "target" && noise(this.seed, 11, x >> 1, y >> 1) > 0.985;
        bytes.writeFloatLE(y >= rows || lost ? NaN : this.value(kind, x, y, layer), at);
      }
    return bytes;
  }

  /** A bitmap of the last errors: blue too low, orange too high. */
  thumbnail(size = 32) {
    const bytes = Buffer.alloc(54 + 3 * size * size);
    bytes.write("BM", 0, "latin1");
    bytes.writeUInt32LE(bytes.length, 2);
    bytes.writeUInt32LE(54, 10);
    bytes.writeUInt32LE(40, 14);
    bytes.writeInt32LE(size, 18);
    bytes.writeInt32LE(size, 22);
    bytes.writeUInt16LE(1, 26);
    bytes.writeUInt16LE(24, 28);
    for (let y = 0, at = 54; y < size; ++y)
      for (let x = 0; x < size; ++x, at += 3) {
        const [i, j] = [x, y].map((n, k) => Math.floor(n * (k ? this.ny : this.nx) / size));
        const share = Math.max(-1, Math.min(1, this.error_um(i, j, this.printed) / (4 * this.noise_um)));
        const end = share < 0 ? [178, 114, 0] : [0, 94, 213];  // B, G, R
        const inside = this.target_um(i, j, 1) > 0;
        for (let c = 0; c < 3; ++c) bytes[at + c] = inside ? 250 + Math.abs(share) * (end[c] - 250) : 255;
      }
    return bytes;
  }

  has(kind, layer) {
    if (!kSurfaces.includes(kind) || layer < 0 || layer > this.printed) return false;
    if (kind === "predicted") return this.lab !== "ice" && this.scheme === "mpc" && layer > 0;
    return kind !== "planned" || layer < this.printed || this.live;
  }

  time_s(layer) {
    return layer * (this.lab === "ice" ? 41.7 : 23.4);
  }

  /** A layer is printed and measured; its numbers come from every 16th cell of large grids. */
  print_layer() {
    const n = ++this.printed;
    const step = this.nx > 100 ? 16 : 1;
    let [sum, squares, most, cells] = [0, 0, 0, 0];
    for (let y = 0; y < this.ny; y += step)
      for (let x = 0; x < this.nx; x += step) {
        if (this.target_um(x, y, 1) === 0) continue;
        const error = this.error_um(x, y, n);
        sum += error;
        squares += error * error;
        most = Math.max(most, Math.abs(error));
        ++cells;
      }
    const rms_um = Math.sqrt(squares / cells);
    const layer = {n, t_s: this.time_s(n), rms_um, mean_um: sum / cells, max_um: most, overspill_percent: this.lab === "ice" ? null : 2.1 + 0.4 * noise(this.seed, n),
                   droplets: this.lab === "ice" ? null : cells, predicted_rms_um: this.scheme === "mpc" ? rms_um * (1 + 0.06 * noise(this.seed, 3, n)) : null,
                   measured_rms_um: rms_um, decision_ms: 3 + noise(this.seed, 4, n)};
    this.layers.push(layer);
    return layer;
  }

  /** What the process says of a run that is over, in words and values. */
  result() {
    const last = this.layers[this.layers.length - 1];
    const whole = !this.live && last && this.outcome === "finished";
    const [unit, size, goal] = this.lab === "ice" ? ["mm", 0.001, 0.24] : ["um", 1, 7.6];
    return {height_unit: unit, part: this.part ?? "disc, 10 x 10 x 0.4 mm", overspill_percent: last?.overspill_percent ?? null, audit: this.live ? null : "clean",
            verdict: whole ? `within tolerance: RMS ${+(last.rms_um * size).toPrecision(3)} ${unit} of the last map, at most ${goal} ${unit}` : null, within: whole ? true : null};
  }

  ended() {
    const {verdict, within, part} = this.result();
    return verdict && {outcome: this.outcome, words: `${this.outcome}: the last layer is printed`, cause: null, do: null, manual: null, by_operator: false, verdict, within,
                       facts: [`part: ${part}`, "RMS inside 1.2, on the rim 2.3", "overspill of the measured surface: 9.25 % of the part's volume lies beside it", "audit: clean"]};
  }

  summary() {
    const last = this.layers[this.layers.length - 1];
    return {...this.result(), id: this.id, lab: this.lab, experiment: this.experiment, scheme: this.scheme, seed: this.seed, layers: this.printed, outcome: this.live ? null : this.outcome,
            rms_um: last?.rms_um ?? null, mean_um: last?.mean_um ?? null, started_utc: this.started_utc, tags: this.tags, notes: this.notes, meta: this.meta, live: this.live};
  }

  estimates() {
    return this.layers.flatMap(({n, t_s}) => {
      const sd = 0.4 / Math.sqrt(n);
      return this.lab === "ice" ? [{t_s, name: "flow_a", value: 1.04 + 0.3 * sd * noise(this.seed, 21, n), sd: 0.1 * sd, unit: "1"}]
        : [["h1", 0.93], ["h2", 0.29], ["h3", 0.11]].map(([name, value], k) => ({t_s, name, value: value + sd * noise(this.seed, 20 + k, n) / 3, sd: sd / 4, unit: "um"}));
    });
  }

  instruments() {
    const t_s = this.time_s(this.printed);
    const one = (name, kind, words, text, details, more = {}) => ({name, kind, state: "armed", words, real: !this.simulated, link: this.simulated ? `sim:${name}` : "/dev/ttyUSB0, 115200 baud",
                                                                   last: {t_s, text}, faults: 0, details, ...more});
    if (this.lab === "ice")
      return [one("robot", "Adept Cobra 600", "follows path 3 of 5", "STAT -> MOVING, path 3, monitor speed 100 %", [["joint 1", 12.4, "deg"], ["paths done", 2211, ""]]),
              one("valve_a", "water valve", "pulses at 210 Hz", "LIST? -> 4112 pulses left", [["pulses", 812345, ""], ["boots", 1, ""]]),
              one("laser_point", "Keyence LK-G", "measures", "M0 -> +0.1234", [["rate", 1000, "Hz"]]),
              one("heater", "two channels", "holds −21.8 degC", "RD1 -> -21.8", [["plate", -21.8, "degC"], ["nozzle", 4.1, "degC"]])];
    return [one("stage", "Aerotech A3200", "at rest at the cure pose", "PFBK X -> 120.0004", [["x", 120.0004, "mm"], ["y", 40, "mm"]]),
            one("jet_a", "MicroFab JetDrive III", "armed, waits for triggers", "A5 01 06 -> ack", [["fired", "13482", ""], ["rise_us", "3", "us"], ["dwell_us", "20", "us"], ["fall_us", "3", "us"],
                ["echo_us", "40", "us"], ["final_us", "3", "us"], ["idle_v", "0", "V"], ["dwell_v", "20", "V"], ["echo_v", "-20", "V"], ["max_rate_hz", "2000", "Hz"]]),
            one("lamp", "OmniCure S2000", "shutter closed", "GLH -> 1234", [["lamp hours", 1234, "h"], ["intensity", 86, "percent"]]),
            one("laser_profiler", "Keyence LJ-V7080", "measures rows", "0x93 -> 800 points", [["rows lost", 0, ""]], this.faulty ? {state: "suspect", words: "rows come late", faults: 3} : {})];
  }

  hello(state) {
    const {nx, ny} = this;
    const pitch_mm = this.lab === "ice" ? 0.3 : 0.25;
    const layers_planned = this.planned;
    return {type: "hello", protocol: 1, firn: "mock", run: {
      id: this.id, lab: this.lab, lab_words: kLabs[this.lab][0], deposition: kLabs[this.lab][1], experiment: this.experiment, scheme: this.scheme, seed: this.seed, live: this.live, finished: !this.live, simulated: this.simulated,
      grid: {nx, ny, pitch_mm, x0_mm: -pitch_mm * (nx - 1) / 2, y0_mm: -pitch_mm * (ny - 1) / 2}, layers_planned, layers_expected: layers_planned,
      goal: this.lab === "ice" ? {kind: "rms", value: 0.24, unit: "mm"} : {kind: "rms", value: 7.6, unit: "um"}, amount: this.lab === "ice" ? "pulses" : "droplets", height_unit: this.result().height_unit, outcome: this.live ? null : this.outcome, started_utc: this.started_utc,
      tags: this.tags, notes: this.notes, meta: this.meta, host: "lab3", settings: this.setting_list()},
      commands: {resume: true, allowed: this.live ? ["pause", "continue", "stop_after_layer", "safe_stop", "accept_doubt", "set"] : [], in_flight: this.live ? [
        {key: "control.target_offset_mm", value: "0", min: -10, max: 10, unit: "mm", words: "Offset of the target"},
        {key: "control.mpc.horizon_layers", value: "3", min: 1, max: 8, unit: "layers", words: "Horizon of the scheme"}] : []},
      end: this.end ?? this.ended(), layers: this.layers, events: this.events, instruments: this.instruments(), estimates: this.estimates(), state};
  }

  setting_list() {
    const all = {"control.scheme": this.scheme, "run.seed": this.seed, "process.scan_speed_mm_s": 10, "part.height_mm": 0.1, "control.ki": this.gain,
                 "grid.pitch_mm": 0.25, "laser_profiler.noise_um": this.noise_um, ...this.settings};
    const defaults = {"control.scheme": "open", "run.seed": 1, "process.scan_speed_mm_s": 10, "part.height_mm": 0.1, "control.ki": 0.33, "grid.pitch_mm": 0.25, "laser_profiler.noise_um": 0.4};
    return Object.entries(all).map(([key, value]) => ({key, value: String(value), unit: /_(mm|um|s)$/.exec(key)?.[1] ?? "", default: String(defaults[key] ?? "")}));
  }
}

const event = (n, t_s, severity, source, words, more = {}) =>
  ({n, t_s, severity, source, words, cause: null, value: null, limit: null, unit: null, do: null, manual: null, ...more});

/** The runs that the tests and the pictures look at. */
export function mock_runs() {
  const inkjet = {lab: "inkjet", experiment: "cylinder.toml", nx: 40, ny: 40};
  return [
    new MockRun({...inkjet, id: "20261124-090000-cylinder", scheme: "mpc", started_utc: "2026-11-24T09:00:00Z", printed: 7, planned: 53, live: true, gain: 1, faulty: true, events: [
      event(1, 0.4, "info", "launcher", "All nine processes are ready."),
      event(2, 1.2, "info", "surface_mapper", "The bare substrate was measured."),
      event(3, 61.5, "warning", "laser_profiler", "Rows came late, and were measured again.", {cause: "rows lost", value: 0.031, limit: 0.02, unit: "1", do: "Nothing: the scan was repeated slower.", manual: "/manual/safety.html#interlocks"}),
      event(4, 102.2, "notice", "jet_a", "Droplets 311 to 325 of layer 5 were in doubt; the surface was scanned and the loop went on.", {cause: "the jet was reset"})]}),
    new MockRun({...inkjet, id: "20261123-150000-cylinder", scheme: "mpc", started_utc: "2026-11-23T15:00:00Z", printed: 53, gain: 1, tags: ["good"], notes: [{time_utc: "2026-11-23T17:00:00Z", author: "Kim", text: "the reference"}], meta: {ink: "TPGDA", sample: "PCB-7"}, seed: 3}),
    new MockRun({...inkjet, id: "20261123-140000-cylinder", scheme: "open", started_utc: "2026-11-23T14:00:00Z", printed: 53, gain: 0, tags: ["baseline"], seed: 3}),
    new MockRun({...inkjet, id: "20261122-110000-cuboid", experiment: "cuboid.toml", scheme: "greedy", started_utc: "2026-11-22T11:00:00Z", printed: 21, planned: 53, gain: 0.5, outcome: "stopped safely", simulated: false, end: {
      outcome: "stopped safely", words: "The print was stopped safely: jet A fires nothing.", cause: "drops without rise (code 12), share of the rise, value 0.11, limit 0.3", do: "Clean the nozzle of jet A, look at a droplet with the strobe, then: firn print --resume 20261122-110000-cuboid", manual: "/manual/safety.html#interlocks", by_operator: false, can_go_on: true, verdict: null, within: null, facts: []}, events: [
      event(1, 0.5, "info", "launcher", "All nine processes are ready."),
      event(2, 491.0, "fault", "scheduler", "Drops were fired and the surface did not rise.", {cause: "rise of layer 21", value: 0.11, limit: 0.3, unit: "1", manual: "/manual/safety.html#interlocks"}),
      event(3, 491.1, "stop", "safety", "The print was stopped safely: jet A fires nothing.", {cause: "drops without rise (code 12), share of the rise", value: 0.11, limit: 0.3, unit: "1", do: "Clean the nozzle of jet A, look at a droplet with the strobe, then: firn print --resume 20261122-110000-cuboid", manual: "/manual/safety.html#interlocks"})]}),
    new MockRun({id: "20261121-200000-ice-helical-gear", lab: "ice", experiment: "ice-helical-gear.toml", scheme: "smf", started_utc: "2026-11-21T20:00:00Z", nx: 256, ny: 256, printed: 500, layer_um: 100, noise_um: 22, gain: 0.6, settings: {"ice.flow": 1.04}}),
  ];
}
