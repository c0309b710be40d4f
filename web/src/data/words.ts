// Numbers, times and links as people read them.

/** Three significant digits without exponent, whole numbers whole, thousands apart: as for_people() in core/options/for_people.h. */
export function number(value: unknown, digits = 3): string {
  if (typeof value === "string" && value !== "") return value;
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  const whole = Number.isInteger(value) || Math.abs(value) >= 10 ** digits - 0.5;
  const text = whole ? BigInt(Math.round(value)).toString().replace(/\B(?=(\d{3})+$)/g, ",")
                     : Number(value.toPrecision(digits)).toFixed(12).replace(/\.?0+$/, "");
  return text.replace(/^-0$/, "0").replace("-", "−");
}

export function with_unit(value: unknown, unit: string | null | undefined): string {
  const text = number(value);
  return text === "–" || !unit || unit === "1" ? text : `${text} ${unit_words(unit)}`;
}

/** A height that the process tells in um, in the unit of the run's lab. */
export function in_height_unit(um: number | null | undefined, unit: string | undefined): number | null {
  return um == null ? null : unit === "mm" ? um / 1000 : um;
}

export function height_words(um: number | null | undefined, unit: string | undefined): string {
  return with_unit(in_height_unit(um, unit), unit ?? "um");
}

export function unit_words(unit: string): string {
  return unit.replace(/^um\b/, "µm").replace(/^us\b/, "µs").replace(/^degC\b/, "°C").replace(/^deg\b/, "°").replace(/\^3/, "³").replace(/\^2/, "²").replace(/^percent$/, "%");
}

/** A sentence of the process, with the sign of micro that its terminal does without. */
export function with_micro(words: string): string {
  return words.replace(/ um\b/g, " µm");
}

/** "0.4 s", "12 s", "3 min 20 s", "2 h 5 min". */
export function duration(seconds: number | null | undefined): string {
  if (seconds == null || !Number.isFinite(seconds)) return "–";
  const s = Math.max(0, seconds);
  if (s < 10) return `${s.toFixed(1)} s`;
  const whole = Math.round(s);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}

/** Time since the print began: "1:02:03.4". */
export function clock(seconds: number): string {
  if (!Number.isFinite(seconds)) return "–";
  const tenths = Math.round(Math.max(0, seconds) * 10);
  const h = Math.floor(tenths / 36000);
  const m = Math.floor(tenths / 600) % 60;
  const s = ((tenths % 600) / 10).toFixed(1).padStart(4, "0");
  return h ? `${h}:${String(m).padStart(2, "0")}:${s}` : `${m}:${s}`;
}

export function date(utc: string | null | undefined): string {
  const at = utc ? new Date(utc) : null;
  return at && !Number.isNaN(+at) ? at.toISOString().slice(0, 16).replace("T", " ") : "–";
}

/** A link to the manual if it stays on this page's own origin or is plain https; words of a log must not become a script. */
export function safe_link(link: string | null | undefined): string | null {
  if (!link) return null;
  try {
    const url = new URL(link.replace(/^\/(?!\/)/, ""), document.baseURI);  // the process knows no proxy's prefix
    return url.origin === location.origin || url.protocol === "https:" ? url.href : null;
  } catch {
    return null;
  }
}

/** The name under which a run is shown. */
export function label(run: {id: string; label?: string}): string {
  return run.label ?? run.id;
}
