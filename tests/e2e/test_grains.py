"""Three grains crushed on coarse cells: they split along the column into ever more pieces, faster with a larger force."""
from e2e import Folder, expect
from grains import Crushed

with Folder() as folder:
    slow = Crushed(folder, "three_grains_quick")
    slow.check()
    slow.check_first_cracks()
    slow.check_heat()
    fast = Crushed(folder, "three_grains_quick", "walls.plate.velocity=[0.0, -80.0]", "time.end=5e-6", "output.snapshot_every=1e-6")
    expect(fast.peak > 1.3 * slow.peak, "the faster plate is pressed by %g N, the slower by %g N" % (fast.peak, slow.peak))
