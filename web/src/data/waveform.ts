// Drive voltage of a jet over time, from its settings: idle, rise, dwell, fall, echo, back to idle.

export interface Waveform {
  t_us: number[];
  volts: number[];
}

const kTimes = ["rise_us", "dwell_us", "fall_us", "echo_us", "final_us"];
const kVolts = ["idle_v", "dwell_v", "echo_v"];
export const kWaveformKeys = [...kTimes, ...kVolts];

/** Null where the instrument has no such settings. */
export function waveform_of(details: [string, unknown, string][]): Waveform | null {
  const values = new Map(details.map(([name, value]) => [name, Number(value)]));
  if (!kWaveformKeys.every(key => Number.isFinite(values.get(key)))) return null;
  const [idle, dwell, echo] = kVolts.map(key => values.get(key)!);
  const t_us = [0];
  for (const key of kTimes) t_us.push(t_us[t_us.length - 1] + values.get(key)!);
  return {t_us, volts: [idle, dwell, dwell, echo, echo, idle]};
}
