"""A case folder, a table, arrays, and a model of one's own. Every step asserts what it shows."""

import tempfile

import numpy as np
import truing
from truing import Effect, Model, Parameter

# 1. A case folder, as the command line has it.
with tempfile.TemporaryDirectory() as folder:
    truing.init("frame-fit", f"{folder}/case")
    solved = truing.solve(f"{folder}/case")
    print(solved)
assert solved.kind == "frame-fit" and solved.residual.unit == "mm"

# 2. The same questions asked of arrays. The second frame is stretched by 200 ppm along x.
draws = np.random.default_rng(2024)
from_mm = draws.uniform(-400.0, 400.0, (60, 3))
to_mm = from_mm * [1.0002, 1.0, 1.0] + [10.0, -5.0, 2.0] + draws.normal(0.0, 0.005, (60, 3))
fit = truing.frame_fit.fit(from_mm, to_mm, std_mm=0.005)
print(f"a rigid frame misses by {fit.rms_mm:.3f} mm: variance factor {fit.variance_factor:.0f}")
assert fit.variance_factor > 10.0

# 3. What is missing? A table becomes a case; a data frame of pandas, polars or pyarrow does as well.
pairs = {"point": [f"p{i}" for i in range(60)]}
for k, axis in enumerate("xyz"):
    pairs[f"from_{axis}_mm"], pairs[f"to_{axis}_mm"] = from_mm[:, k], to_mm[:, k]
closed = truing.loop(truing.Case("frame-fit", {"pairs": pairs}, {"noise": {"point_mm": 0.005}}))
print(closed)
assert closed.verdict == "explained" and closed.after.held_out_rms < 0.2 * closed.before.held_out_rms


# 4. A model of one's own: a dial gauge whose scale may be too long, or whose spindle is tilted.
class DialGauge(Model):
    unit = "mm"
    base = [Parameter("zero", "mm")]
    effects = [
        Effect("scale", "the scale is too long", [Parameter("scale", "%", 100.0)]),
        Effect("hysteresis", "it reads less on the way back", [Parameter("width", "mm")]),
    ]

    def __init__(self, set_mm, read_mm, is_return):
        self.set_mm, self.read_mm, self.is_return = set_mm, read_mm, is_return
        self.observations = [f"{value:.1f} mm" for value in set_mm]
        self.std = 0.001

    def residuals(self, base, amplitudes):
        [zero], [[scale], [width]] = base, amplitudes
        return self.read_mm - (zero + self.set_mm * (1.0 + scale) - self.is_return * width)


there = np.linspace(0.0, 10.0, 21)
set_mm, is_return = np.concatenate([there, there[::-1]]), np.repeat([0.0, 1.0], 21)
read_mm = 0.02 + set_mm - 0.006 * is_return + draws.normal(0.0, 0.001, 42)
closure = truing.close_loop(DialGauge(set_mm, read_mm, is_return))
size = closure.steps[0].parameters[0]
print(f"{closure.steps[0].effect}: {size.value:.4f} mm ± {2.0 * size.std:.4f} mm")
assert closure.verdict == "explained" and closure.steps[0].effect == "hysteresis"
assert abs(size.value - 0.006) < 4.0 * size.std

# 5. What cannot be known is said, with the direction that is free.
try:
    truing.frame_fit.fit(from_mm[:2], to_mm[:2], std_mm=0.005)
except truing.NotDeterminedError as error:
    print(f"not determined: {error.free_direction} is free")
else:
    raise AssertionError("two points leave a rotation free")
