# labels: long
# timeout: 1800
"""The paper's three grains at full size and all speeds."""
from e2e import Folder, expect
from grains import Crushed

with Folder() as folder:
    runs = {speed: Crushed(folder, "three_grains_%d" % speed) for speed in (8, 16, 80)}
    for run in runs.values():
        run.check()
        run.check_heat()
    runs[16].check_first_cracks()
    expect(runs[8].peak < runs[16].peak < runs[80].peak, "the peak force does not grow with the speed")
    expect(runs[8].series["count"][-1] < runs[80].series["count"][-1], "faster loading does not make more pieces")
    Crushed(folder, "three_grains_16_isothermal").check()
