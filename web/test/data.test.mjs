// The page's reckoning, without a browser: frames, differences, sections, scales, lists, words.

import assert from "node:assert/strict";
import {mkdtemp, rm} from "node:fs/promises";
import {tmpdir} from "node:os";
import {dirname, join} from "node:path";
import {after, before, test} from "node:test";
import {fileURLToPath} from "node:url";
import {build} from "esbuild";
import {MockRun} from "./mock_runs.mjs";

const src = join(dirname(fileURLToPath(import.meta.url)), "../src");
let folder;
let page;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "firn-web-"));
  const contents = ["data/hold", "data/maps", "data/run_list", "data/settings", "data/waveform", "data/words", "data/protocol", "draw/solid_geometry", "draw/colours", "draw/droplets"].map(name => `export * from "./${name}";`).join("\n");
  await build({stdin: {contents, resolveDir: src, loader: "ts"}, bundle: true, format: "esm", outfile: join(folder, "page.mjs"), logLevel: "warning"});
  page = await import(join(folder, "page.mjs"));
});
after(() => rm(folder, {recursive: true}));

/** A seeded generator of numbers in 0..1. */
function seeded(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
}

const bytes_of = buffer => buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.length);
const map_of = (nx, ny, value) => ({surface: "measured", layer: 1, nx, ny, flags: 0, t_s: 0, values: Float32Array.from({length: nx * ny}, (_, i) => value(i % nx, Math.floor(i / nx)))});

test("a map frame is read as it was written, unseen cells as NaN", () => {
  const run = new MockRun({id: "a", lab: "inkjet", scheme: "mpc", nx: 7, ny: 5, printed: 3});
  const map = page.read_map(bytes_of(run.frame("measured", 2, 3)));
  assert.deepEqual([map.surface, map.layer, map.nx, map.ny, map.flags, map.t_s], ["measured", 2, 7, 5, 2, run.time_s(2)]);
  for (let y = 0; y < 5; ++y)
    for (let x = 0; x < 7; ++x) {
      const value = map.values[7 * y + x];
      if (y >= 3) assert.ok(Number.isNaN(value));
      else if (!Number.isNaN(value)) assert.equal(value, Math.fround(run.value("measured", x, y, 2)));
    }
});

test("rows go over the map that they belong to, and over no other", () => {
  const run = new MockRun({id: "a", lab: "inkjet", scheme: "mpc", nx: 3, ny: 4, printed: 1});
  const base = page.read_map(bytes_of(run.frame("measured", 1)));
  const head = Buffer.from(run.frame("measured", 1).subarray(0, 32));
  head.writeUInt32LE(2 | 8, 20);
  const row = Buffer.alloc(16);
  row.writeUInt32LE(2, 0);
  for (let i = 0; i < 3; ++i) row.writeFloatLE(70 + i, 4 + 4 * i);
  const frame = bytes_of(Buffer.concat([head, row]));
  const map = page.read_map(frame, base);
  assert.equal(map.flags, 2);
  assert.deepEqual([...map.values.slice(6, 9)], [70, 71, 72]);
  assert.deepEqual([...map.values.slice(0, 6)], [...base.values.slice(0, 6)]);
  assert.throws(() => page.read_map(frame), /rows of a map that is not here/);
  assert.throws(() => page.read_map(frame, {...base, layer: 2}), /not here/);
  assert.throws(() => page.read_map(frame.slice(0, 44), base), /no rows of 3 cells/);
  row.writeUInt32LE(4, 0);
  assert.throws(() => page.read_map(bytes_of(Buffer.concat([head, row])), base), /row 4 of 4/);
});

test("a frame that is cut, too long or foreign is refused with the byte and the limit", () => {
  const run = new MockRun({id: "a", lab: "inkjet", scheme: "mpc", nx: 6, ny: 6, printed: 1});
  const good = run.frame("error", 1);
  for (let size = 0; size < good.length; ++size) assert.throws(() => page.read_map(bytes_of(good.subarray(0, size))), /bytes/);
  assert.throws(() => page.read_map(bytes_of(Buffer.concat([good, Buffer.alloc(1)]))), /expected 176/);
  const wrong = (at, value, words) => {
    const bytes = Buffer.from(good);
    bytes.writeUInt32LE(value, at);
    assert.throws(() => page.read_map(bytes_of(bytes)), words);
  };
  wrong(0, 1, /byte 0/);
  wrong(4, 2, /version 2/);
  wrong(4, 1 | (6 << 16), /byte 6: surface 6/);
  wrong(12, 0xffffffff, /byte 12/);
  wrong(16, 0, /byte 12/);
});

test("random bytes never make a map that is larger than they are", () => {
  const next = seeded(5);
  for (let k = 0; k < 3000; ++k) {
    const bytes = Buffer.from(Array.from({length: Math.floor(next() * 80)}, () => Math.floor(next() * 256)));
    if (k % 2 && bytes.length >= 8) bytes.write("FMAP\x01\0\0\0", "latin1");
    try {
      assert.ok(4 * page.read_map(bytes_of(bytes)).values.length <= bytes.length);
    } catch (error) {
      assert.match(error.message, /byte|bytes/);
    }
  }
});

test("the difference of a plane on two grids is the plane's, and nothing where one of them has no cell", () => {
  const plane = (grid, nx, ny) => map_of(nx, ny, (x, y) => 3 + 2 * (grid.x0_mm + x * grid.pitch_mm) - (grid.y0_mm + y * grid.pitch_mm));
  const fine = {pitch_mm: 0.1, x0_mm: 0, y0_mm: 0};
  const coarse = {pitch_mm: 0.25, x0_mm: 0.25, y0_mm: -0.5};
  const a = plane(fine, 20, 20);
  const d = page.difference(a, fine, plane(coarse, 6, 8), coarse);
  for (let y = 0; y < 20; ++y)
    for (let x = 0; x < 20; ++x) {
      const inside = 0.1 * x >= 0.25 - 1e-9 && 0.1 * x <= 1.5 + 1e-9 && 0.1 * y <= 1.25 + 1e-9;
      const value = d.values[20 * y + x];
      if (Number.isNaN(value)) assert.ok(!inside || Math.abs(0.1 * x - 1.5) < 1e-6 || Math.abs(0.1 * y - 1.25) < 1e-6, `cell ${x}, ${y}`);
      else assert.ok(inside && Math.abs(value) < 1e-5, `cell ${x}, ${y}: ${value}`);
    }
  assert.deepEqual([...page.difference(a, fine, a, fine).values], Array(400).fill(0));
});

test("an unseen cell of either map is unseen in the difference, its neighbours are not", () => {
  const grid = {pitch_mm: 1, x0_mm: 0, y0_mm: 0};
  const a = map_of(4, 4, (x, y) => (x === 1 && y === 1 ? NaN : 5));
  const b = map_of(4, 4, (x, y) => (x === 2 && y === 2 ? NaN : 2));
  const lost = [...page.difference(a, grid, b, grid).values].map((v, i) => (Number.isNaN(v) ? i : -1)).filter(i => i >= 0);
  assert.deepEqual(lost, [5, 10]);
});

test("a section holds values of cells, from its first to its last, in mm", () => {
  const map = map_of(30, 30, (x, y) => 100 * x + y);
  const {along_mm, values} = page.section(map, [2, 3], [26, 21], {pitch_mm: 0.5, x0_mm: 0, y0_mm: 0});
  assert.equal(values[0], 203);
  assert.equal(values[values.length - 1], 2621);
  assert.ok(Math.abs(along_mm[along_mm.length - 1] - 15) < 1e-9);
  assert.ok(Math.abs(page.section(map, [0, 0], [3, 4], {pitch_mm: 1, pitch_y_mm: 2}).along_mm.pop() - Math.hypot(3, 8)) < 1e-9);
  const cells = new Set(map.values);
  assert.ok(values.every(value => cells.has(value)));
  assert.deepEqual(page.section(map, [4, 4], [4, 4], {pitch_mm: 1}).values, [404, 404]);
  assert.equal(page.section(map_of(3, 3, () => NaN), [0, 0], [2, 2], {pitch_mm: 1}).values.every(v => v === null), true);
});

test("scales are symmetric for errors, hold the map for heights, and one splash does not widen them", () => {
  const next = seeded(9);
  for (let k = 0; k < 200; ++k) {
    const size = 10 ** (6 * next() - 3);
    const map = map_of(20, 20, () => size * (2 * next() - 1));
    const error = page.fitted_scale(map, true);
    assert.equal(error.low, -error.high);
    assert.ok(error.high <= 2.5 * size + 1e-9, `${error.high} for ${size}`);
    const height = page.fitted_scale(map, false);
    assert.equal(page.clipped_share(map, height), 0);
    assert.ok(height.high - height.low <= 2.3 * size);
    map.values[7] = 1e6 * size;
    assert.ok(page.fitted_scale(map, true).high <= page.rounded_up(size));
  }
  assert.deepEqual(page.fitted_scale(map_of(3, 3, () => NaN), true), {low: -1, high: 1, diverging: true});
  const flat = page.fitted_scale(map_of(3, 3, () => 4), false);
  assert.ok(flat.low <= 4 && flat.high > flat.low);
});

test("mean and RMS are of the seen cells", () => {
  const {mean, rms, seen} = page.moments(map_of(2, 2, (x, y) => (x && y ? NaN : 3 - 2 * x)));
  assert.deepEqual([mean, seen], [7 / 3, 3]);
  assert.ok(Math.abs(rms - Math.sqrt(19 / 3)) < 1e-12);
});

test("a ray meets the cell that it looks at: from above the picture's middle is the map's middle", () => {
  const map = map_of(41, 41, () => 0);
  const scale = {low: 0, high: 1, diverging: false};
  const above = {around: -Math.PI / 2, up: 1.5, distance: 2.5, lift: 0.2};
  const cell = page.height_under(map, scale, above, 0, 0, 1);
  assert.ok(Math.abs(cell[0] - 20) <= 1 && Math.abs(cell[1] - 20) <= 2, String(cell));
  assert.ok(page.height_under(map, scale, above, 0.3, 0, 1)[0] > 25);
  assert.ok(page.height_under(map, scale, above, 0, 0.3, 1)[1] > 25);
  assert.equal(page.height_under(map, scale, above, 0.99, 0.99, 1), null);
  // A tower hides what is behind it.
  const tower = map_of(41, 41, (x, y) => (Math.abs(x - 20) < 3 && Math.abs(y - 20) < 3 ? 1.5 : 0));
  const front = page.height_under(tower, {...scale}, {...above, up: 0.3, lift: 0.4}, 0, 0.05, 1);
  assert.ok(Math.abs(front[1] - 18) <= 1, String(front));
});

test("colour maps are monotone in lightness from low to high, and the diverging one is lightest in its middle", () => {
  const light = (bytes, i) => 0.2126 * (bytes[4 * i] / 255) ** 2.2 + 0.7152 * (bytes[4 * i + 1] / 255) ** 2.2 + 0.0722 * (bytes[4 * i + 2] / 255) ** 2.2;
  for (let i = 1; i < 256; ++i) assert.ok(light(page.kCividis, i) >= light(page.kCividis, i - 1) - 0.004, `cividis ${i}`);
  for (let i = 1; i < 128; ++i) {
    assert.ok(light(page.kDiverging, i) >= light(page.kDiverging, i - 1) - 0.004, `diverging ${i}`);
    assert.ok(light(page.kDiverging, 255 - i) >= light(page.kDiverging, 256 - i) - 0.004, `diverging ${255 - i}`);
  }
  assert.ok(light(page.kDiverging, 127) > 0.85);
});

test("runs are found by words, tags and keys, and sorted with the unknown last either way", () => {
  const run = (id, more) => ({id, lab: "inkjet", experiment: "a.toml", scheme: "mpc", seed: 1, layers: 3, outcome: "finished", rms_um: 1, mean_um: 0, started_utc: "2026", tags: [], notes: [], meta: {}, live: false, ...more});
  const runs = [run("a", {tags: ["Good"], rms_um: 3}), run("b", {lab: "ice", rms_um: null}), run("c", {notes: [{time_utc: "", author: "Kim", text: "Rim falls"}], meta: {ink: "TPGDA 7"}, scheme: "open", rms_um: 0.5})];
  const ids = list => list.map(one => one.id).join("");
  assert.equal(ids(page.found(runs, "")), "abc");
  assert.equal(ids(page.found(runs, "tag:good")), "a");
  assert.equal(ids(page.found(runs, "RIM open")), "c");
  assert.equal(ids(page.found(runs, "scheme:mpc lab:ice")), "b");
  assert.equal(ids(page.found(runs, "ink:tpgda")), "c");
  assert.equal(ids(page.found(runs, "tpgda")), "c");
  assert.equal(ids(page.found(runs, "nothing")), "");
  assert.equal(ids(page.sorted(runs, "rms_um", false)), "cab");
  assert.equal(ids(page.sorted(runs, "rms_um", true)), "acb");
  assert.equal(ids(runs), "abc");
});

test("a condition is told from words that are looked for", () => {
  for (const text of ["rms_um < 2", "meta.ink ~ x", "has tag", "not has rms_um", "a=b"]) assert.ok(page.is_condition(text), text);
  for (const text of ["mpc", "tag:good scheme:mpc", "has", "hash x", ""]) assert.ok(!page.is_condition(text), text);
});

test("only settings that differ are shown, by value and not by the object that holds it", () => {
  const rows = page.differing([[{key: "a", value: [1, 2]}, {key: "b", value: 1, unit: "mm"}, {key: "only", value: 0}], [{key: "b", value: 2, unit: "mm"}, {key: "a", value: [1, 2]}]]);
  assert.deepEqual(rows, [{key: "b", unit: "mm", values: [1, 2]}, {key: "only", unit: "", values: [0, undefined]}]);
  assert.deepEqual(page.differing([[{key: "a", value: 1}], [{key: "a", value: 1}], [{key: "a", value: 1}]]), []);
  assert.deepEqual(page.changed([{key: "a", value: 1, default: 1}, {key: "b", value: 2, default: 1}, {key: "c", value: 3}]).map(one => one.key), ["b", "c"]);
});

test("a jet's waveform goes from idle over dwell and echo back to idle, in the times of its settings", () => {
  const details = [["rise_us", "3", "us"], ["dwell_us", "20", "us"], ["fall_us", "3.5", "us"], ["echo_us", "40", "us"], ["final_us", "3", "us"], ["idle_v", "0", "V"], ["dwell_v", "20", "V"], ["echo_v", "-20", "V"]];
  assert.deepEqual(page.waveform_of(details), {t_us: [0, 3, 23, 26.5, 66.5, 69.5], volts: [0, 20, 20, -20, -20, 0]});
  assert.equal(page.waveform_of(details.slice(1)), null);
});

test("numbers keep three digits and their sign, times are read as people say them", () => {
  assert.deepEqual([0, 12, -0.48512, 1234.5, 0.00049, 1e7, 60.000126, 9.996, 999.6, -0.001, 3e-7, NaN, null, "x"].map(value => page.number(value)),
                   ["0", "12", "−0.485", "1,235", "0.00049", "10,000,000", "60", "10", "1,000", "−0.001", "0.0000003", "–", "–", "x"]);
  assert.deepEqual([0.04, 9.96, 59.6, 200, 7500, NaN, null].map(page.duration), ["0.0 s", "10.0 s", "1 min 0 s", "3 min 20 s", "2 h 5 min", "–", "–"]);
  assert.deepEqual([0, 59.96, 3661.5].map(page.clock), ["0:00.0", "1:00.0", "1:01:01.5"]);
  assert.equal(page.with_unit(2.5, "um"), "2.5 µm");
});

test("heights are shown in the unit of the run's lab, maps too, but no droplets or factors", () => {
  assert.equal(page.height_words(117.4, "mm"), "0.117 mm");
  assert.equal(page.height_words(117.4, undefined), "117 µm");
  assert.equal(page.height_words(null, "mm"), "–");
  const map = {...map_of(2, 1, x => 500 * (x + 1)), flags: 0};
  assert.deepEqual([...page.in_unit(map, "mm").values], [0.5, 1]);
  assert.deepEqual([...page.in_unit(map, "um").values], [500, 1000]);
  for (const flags of [page.kMapDroplets, page.kMapFactor]) assert.deepEqual([...page.in_unit({...map, flags}, "mm").values], [500, 1000]);
});

/** The frame of a plan on 2 x 1 cells. */
function plan_frame(flags, values) {
  const bytes = new ArrayBuffer(32 + 4 * values.length);
  const view = new DataView(bytes);
  view.setUint32(0, 0x50414d46, true);
  view.setUint16(4, page.kMapVersion, true);
  view.setUint16(6, page.kSurfaces.indexOf("planned"), true);
  view.setUint32(12, 2, true);
  view.setUint32(16, 1, true);
  view.setUint32(20, flags, true);
  values.forEach((value, i) => view.setFloat32(32 + 4 * i, value, true));
  return bytes;
}

test("droplets of a plan are drawn where they land in their cells, y upwards", () => {
  const places = page.kMapDroplets | page.kMapPlaces;
  const plan = page.read_map(plan_frame(places, [1, 2, 0.25, 0, -0.375, 0]));
  assert.deepEqual([...plan.values], [1, 2]);
  assert.deepEqual(page.dot_at(plan, 0, 0), [0.75, 0.875]);
  assert.deepEqual(page.dot_at(plan, 1, 0), [1.5, 0.5]);
  const middle = page.read_map(plan_frame(page.kMapDroplets, [1, 2]));
  assert.equal(middle.places, undefined);
  assert.deepEqual(page.dot_at(middle, 1, 0), [1.5, 0.5]);
  assert.throws(() => page.read_map(plan_frame(places, [1, 2])), /expected 56/);
});

test("errors have the report's colours: blue too low, orange too high", () => {
  const at = i => [...page.kDiverging.slice(4 * i, 4 * i + 3)];
  assert.deepEqual([at(0), at(255)], [[0, 114, 178], [213, 94, 0]]);
  assert.ok(at(128).every(part => part > 245));
});

test("a server's text that is no message is no message", () => {
  for (const text of ["", "{", "null", "3", "[]", "{}", '{"type":5}']) assert.equal(page.parse_message(text), null);
  assert.equal(page.parse_message('{"type":"state","t_s":1}').type, "state");
});

/** A hold on a clock of its own: [time, event, lasted] in order; the times at which it ended. */
function hold_ends(events) {
  const {setTimeout, clearTimeout} = globalThis;
  let now = 0;
  let due = null;
  globalThis.setTimeout = (work, ms) => (due = {at: now + ms, work});
  globalThis.clearTimeout = timer => { if (timer === due) due = null; };
  const ends = [];
  try {
    const hold = new page.HoldClock(() => ends.push(now));
    const run_until = time => {
      if (due && due.at <= time) {
        now = due.at;
        const {work} = due;
        due = null;
        work();
      }
      now = time;
    };
    for (const [time, event, lasted] of [...events, [5000, "end"]]) {
      run_until(time);
      if (event !== "end") hold[event](lasted);
    }
  } finally {
    Object.assign(globalThis, {setTimeout, clearTimeout});
  }
  return ends;
}

test("a hold ends 0.5 s after its press, by a clock that was told late too", () => {
  const told = Array.from({length: 30}, (_, i) => [20 * (i + 1), "held", 20 * (i + 1)]);
  assert.deepEqual(hold_ends([[0, "press", 0], ...told]), [500]);
  assert.deepEqual(hold_ends([[0, "press", 30], ...told.map(([time, event, lasted]) => [time, event, lasted + 30])]), [470]);
  assert.deepEqual(hold_ends([[700, "press", 700], [720, "held", 720]]), [720], "a press that was heard after its end waits for a word");
});

test("no release before the hold's end stops, however late it is heard", () => {
  for (let let_go = 0; let_go <= 500; let_go += 20) {
    const told = Array.from({length: Math.floor(let_go / 20)}, (_, i) => [20 * (i + 1), "held", 20 * (i + 1)]);
    assert.deepEqual(hold_ends([[0, "press", 0], ...told, [let_go, "release", let_go]]), let_go < 500 ? [] : [500], `${let_go} ms, heard at once`);
    const late = hold_ends([[0, "press", 0], ...told, [900, "release", let_go]]);
    if (let_go < page.kHold_ms - page.kUnheard_ms) assert.deepEqual(late, [], `${let_go} ms, heard after 900`);
    else assert.deepEqual(late, [500], `${let_go} ms: within the last ${page.kUnheard_ms} ms it must be heard in time`);
  }
});

test("a thread that was busy through the hold's end decides by its next word", () => {
  assert.deepEqual(hold_ends([[0, "press", 0], [20, "held", 20], [900, "held", 900]]), [900]);
  assert.deepEqual(hold_ends([[0, "press", 0], [20, "held", 20], [900, "release", 650]]), [900]);
  assert.deepEqual(hold_ends([[450, "press", 450], [451, "release", 100]]), [], "press and release were heard together");
  assert.deepEqual(hold_ends([[0, "press", 0], [20, "release", 20], [700, "held", 700]]), [], "it is over");
});

test("a second hold begins anew", () => {
  assert.deepEqual(hold_ends([[0, "press", 0], [300, "held", 300], [310, "release", 310], [400, "press", 0], [420, "held", 20], [880, "held", 480]]), [900]);
});
