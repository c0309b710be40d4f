// Written by page/protocol.py from page/protocol.table.

/** version of the messages */
export const kProtocol = 1;

/** version of the map frame */
export const kMapVersion = 1;

/** before the values */
export const kMapHeaderBytes = 32;

/** flag: values are droplets */
export const kMapDroplets = 1;

/** flag: the map is being measured */
export const kMapPartial = 2;

/** flag: values are relative to the nominal */
export const kMapFactor = 4;

/** flag: some rows alone, each behind its number as u32 */
export const kMapRows = 8;

/** flag: behind the values x and then y of the droplets of each cell, shares of the pitch from its middle */
export const kMapPlaces = 16;

export const kSurfaces = ["measured", "target", "error", "planned", "predicted", "truth"] as const;
export type Surface = (typeof kSurfaces)[number];

export const kWeights = ["info", "notice", "warning", "fault", "stop"] as const;
export type Weight = (typeof kWeights)[number];

export const kPhases = ["starting", "depositing", "curing", "measuring", "deciding", "paused", "stopping", "stopped", "finished", "interrupted"] as const;
export type Phase = (typeof kPhases)[number];

/** From too low to too high, as in the report. */
export const kErrorColours = [[0, 114, 178], [250, 250, 250], [213, 94, 0]] as const;
