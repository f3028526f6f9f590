# timeout: 120
"""Pictures of a tiny scene look as they did: structural similarity (SSIM) with the references in tests/e2e/pictures.

Words are left out: what is compared are the windows, the rose and the colour bar, each moved to where it fits best, so that
other letters (which move things by some pixels) do not matter.  Planted changes are found: another field, no contact network.
After a wanted change of the pictures: UPDATE_PICTURES=1 in the environment writes new references.  Look at them."""
import base64
import json
import re
import struct
from e2e import *
from png_pixels import read

# Parts of the reference pictures, pixels from the upper left: x0, y0, x1, y1.
PICTURES = os.path.join(SOURCE_DIR, "tests", "e2e", "pictures")
POINTS = {"body": (105, 50, 262, 208), "bar": (326, 34, 341, 224)}
RVE = {"window": (101, 20, 296, 213), "rose": (316, 36, 366, 94), "bar": (318, 122, 334, 216)}
SAME, CHANGED = 0.93, 0.75  # SSIM: at least of the same picture, at most of the part that a planted change alters

# On the serial path, whose bits stay: which grains rattle, and how far, is chaos.
SCENE = COLUMN.replace('type = "rve";', 'type = "rve"; path = "serial";') + """
images = ( { name = "points"; field = "pressure"; map = "viridis"; size = [400, 260]; view = [0.3, 0.05, 0.7, 0.35];
             range = [0.0, 12.0]; unit = "kPa"; every = 0.02; } );
"""


def channels(path):
    """Red, green and blue, each as rows of numbers."""
    width, _, rows = read(path)
    return [[[row[3 * x + c] for x in range(width)] for row in rows] for c in range(3)]


def shift_of(a, b, box, most=8):
    """How far part `box` of picture a lies from where it is in b: the shift of the least absolute difference."""
    x0, y0, x1, y1 = box
    best = None
    for dy in range(-most, most + 1):
        for dx in range(-most, most + 1):
            if y0 + dy < 0 or y1 + dy > len(b) or x0 + dx < 0 or x1 + dx > len(b[0]):
                continue
            sum_ = sum(abs(a[y][x] - b[y + dy][x + dx]) for y in range(y0, y1, 5) for x in range(x0, x1, 5))
            if best is None or sum_ < best[0]:
                best = (sum_, dx, dy)
    return best[1:]


def smooth(picture, x0, y0, x1, y1):
    """2 x 2 pixels made one: the edges' anti-aliasing is the renderer's own."""
    return [[(picture[y][x] + picture[y][x + 1] + picture[y + 1][x] + picture[y + 1][x + 1]) / 4
             for x in range(x0, x1 - 1, 2)] for y in range(y0, y1 - 1, 2)]


def likeness(a, b, box):
    """Of a part of two pictures: the SSIM of the colour in which they differ most."""
    shift = shift_of(a[1], b[1], box)
    return min(ssim(p, q, box, *shift) for p, q in zip(a, b))


def ssim(a, b, box, dx, dy):
    """Mean structural similarity (Wang et al. 2004) of 4 x 4 blocks, half overlapping."""
    x0, y0, x1, y1 = box
    p, q = smooth(a, *box), smooth(b, x0 + dx, y0 + dy, x1 + dx, y1 + dy)
    size, sums = 4, []
    for y in range(0, len(p) - size + 1, 2):
        for x in range(0, len(p[0]) - size + 1, 2):
            u = [v for row in p[y:y + size] for v in row[x:x + size]]
            w = [v for row in q[y:y + size] for v in row[x:x + size]]
            n = len(u)
            mu, mw = sum(u) / n, sum(w) / n
            vu, vw = sum((v - mu) ** 2 for v in u) / n, sum((v - mw) ** 2 for v in w) / n
            cov = sum((s - mu) * (t - mw) for s, t in zip(u, w)) / n
            c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
            sums.append((2 * mu * mw + c1) * (2 * cov + c2) / ((mu * mu + mw * mw + c1) * (vu + vw + c2)))
    return sum(sums) / len(sums)


def compare(path, name, parts, changed=(), update=False):
    """Each part as in the reference, or, of those that a planted change alters, not."""
    if update and os.environ.get("UPDATE_PICTURES"):
        shutil.copy(path, os.path.join(PICTURES, name + ".png"))
    check(os.path.join(PICTURES, name + ".png"), path, parts, changed)


def check(reference, path, parts, changed=()):
    old, new = channels(reference), channels(path)
    expect((len(old[0]), len(old[0][0])) == (len(new[0]), len(new[0][0])), "%s has another size" % path)
    for part, box in parts.items():
        found = likeness(old, new, box)
        print("%-24s %-7s %.4f" % (os.path.basename(path), part, found))
        if part in changed:
            expect(found < CHANGED, "%s: the change of the %s is not seen: SSIM %.4f" % (path, part, found))
        elif not changed:
            expect(found > SAME, "%s: the %s looks otherwise: SSIM %.4f (UPDATE_PICTURES=1 if that is wanted)" % (path, part, found))


def points_picture(f, name, *options):
    tmdempm("run", f("s.cfg"), "--out", f(name), "--until", 0.02, *options)
    return shutil.copy(f(name, "images", "points_00000200.png"), f(name + ".png"))


def rve_picture(f, name, *options, source=None):
    tmdempm("rve", "show", source or f("points"), *options, "--size", "480x260", "--image", f(name + ".png"))
    return f(name + ".png")


def array_of(vtp, name):
    """An array of doubles of a .vtp that was written here."""
    found = re.search(r'<DataArray[^>]*Name="%s"[^>]*>([^<]*)<' % name, vtp)
    data = base64.b64decode(found.group(1).strip())
    return struct.unpack("<%dd" % ((len(data) - 8) // 8), data[8:])


def without_contacts(f):
    """The discs of point A as they lie, each a little smaller: a packing in which nothing touches."""
    tmdempm("rve", "show", f("points"), "--name", "A", "--vtp", f("A"))
    tmdempm("rve", "extract", f("points"), "--name", "A", "--out", f("A.h5"))
    with open(f("A_discs.vtp"), encoding="utf-8") as stream:
        vtp = stream.read()
    x, r = array_of(vtp, "Points"), array_of(vtp, "radius")
    cell = re.search(r"H = \[(.*) (.*); (.*) (.*)\] m", tmdempm("rve", "info", f("A.h5")).stdout).groups()
    rows = ["%d,%.17g,%.17g,%.17g" % (k, x[3 * k], x[3 * k + 1], 0.97 * r[k]) for k in range(len(r))]
    return f.write("apart.csv", "# H %s\nid,x,y,r\n%s\n" % (" ".join(cell), "\n".join(rows)))


with Folder() as f:
    f.write("s.cfg", SCENE)
    sinks = {sink["name"]: sink for sink in json.loads(tmdempm("info", "--json").stdout)["sinks"]}
    if not sinks["images"]["available"]:
        skip("no viewer: " + sinks["images"]["install"])
    compare(points_picture(f, "points"), "points", POINTS, update=True)
    compare(rve_picture(f, "rve", "--name", "A"), "rve", RVE, update=True)
    # other letters: VTK's own
    os.environ["TMDEMPM_FONT"] = "none"
    compare(points_picture(f, "points_letters"), "points", POINTS)
    compare(rve_picture(f, "rve_letters", "--name", "A"), "rve", RVE)
    del os.environ["TMDEMPM_FONT"]
    # planted changes
    compare(points_picture(f, "points_field", "--set", "images.[0].field=stress_deviatoric"), "points", POINTS, ["body"])
    compare(rve_picture(f, "rve_field", "--name", "A", "--field", "rotation"), "rve", RVE, ["window"])
    # the contact network alone: the same discs, a little smaller
    whole = rve_picture(f, "rve_radius", "--name", "A", "--field", "radius")
    apart = rve_picture(f, "rve_apart", "--field", "radius", source=without_contacts(f))
    check(whole, apart, RVE, ["window", "rose"])
