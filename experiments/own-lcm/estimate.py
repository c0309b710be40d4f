"""An estimator of the lab's own: what a droplet adds, from the volume that each layer added.

In an experiment:  [nodes.estimate]  command = "python3 experiments/own-lcm/estimate.py"
                   [control]         adapt_model = "own:estimate"
The rise of a layer over what the configured droplet (h1, h2, h3) would give is a factor on all three, averaged over the
layers so far. Firn's own estimator (estimator.droplets) tells the three apart; this one shows how to join a print.
"""
import json
import select
import sys
import tomllib

from own_bus import Bus, message_types

admission = json.loads(sys.stdin.readline())
types = message_types()
metrics_t, model_t = types("layer_metrics_t"), types("own_height_model_t")
with open(admission["experiment"], "rb") as file:
    configured = tomllib.load(file)
drop, grid = configured["model"], configured["grid"]
mm3 = (drop["h1_mm"] + 4 * drop["h2_mm"] + 4 * drop["h3_mm"]) * grid["pitch_x_mm"] * grid["pitch_y_mm"]

bus = Bus(admission)
before, factors = None, []
while True:
    if select.select([sys.stdin], [], [], 0)[0]:  # START, STOP with the cause, or the end of the file
        line = sys.stdin.readline()
        if not line or line.startswith("STOP"):
            break
    heard = bus.hear(0.2)
    if not heard or heard[0] != "LAYER_METRICS":
        continue
    layer = metrics_t.decode(heard[1])
    if before and layer.drops_total > before.drops_total:
        expected = (layer.drops_total - before.drops_total) * mm3
        factors.append((layer.volume_mm3 - before.volume_mm3) / expected)
        factor = max(0.2, min(5.0, sum(factors) / len(factors)))
        told = model_t()
        told.layer, told.droplet_scatter = layer.layer, 0.06
        told.h1_mm, told.h2_mm, told.h3_mm = (factor * drop[h] for h in ("h1_mm", "h2_mm", "h3_mm"))
        bus.publish("OWN_HEIGHT_MODEL", told.encode())
        print(f"layer {layer.layer}: a droplet adds {factor:.3f} of what is configured", flush=True)
    before = layer
