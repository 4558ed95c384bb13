"""What the readers of formats share: comparisons that are counted, and PLY files as the documentation describes them."""

import numpy as np

TYPES = {"double": "<f8", "float": "<f4", "int": "<i4", "uchar": "u1"}
checks = 0


def same(what, a, b):
    """Equal in shape and in every bit of the values."""
    global checks
    checks += 1
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape, f"{what}: {a.shape} is not {b.shape}"
    assert np.array_equal(a, b), f"{what}: values differ by up to {np.abs(a.astype(float) - b).max()}"


def edges_of(lines):
    """The edges of polylines, each with its smaller vertex first, sorted."""
    return sorted(tuple(sorted((int(a), int(b)))) for line in lines for a, b in zip(line[:-1], line[1:]))


class Ply:
    """A PLY file as the documentation describes it."""

    def __init__(self, path):
        data = path.read_bytes()
        head, self.body = data.split(b"end_header\n", 1)
        lines = head.decode().splitlines()
        self.time = next(float(line.split()[2]) for line in lines if line.startswith("comment time "))
        at = next(i for i, line in enumerate(lines) if line.startswith("element vertex"))
        count = int(lines[at].split()[2])
        properties = []
        while lines[at + 1].startswith("property"):
            at += 1
            _, kind, name = lines[at].split()
            properties.append((name, TYPES[kind]))
        faces = int(lines[at + 1].split()[2])
        assert lines[at + 1].startswith("element face") and len(lines) == at + 3, lines
        table = np.frombuffer(self.body, np.dtype(properties), count)
        self.points = np.stack([table[axis] for axis in "xyz"], axis=1)
        self.attributes = {name: table[name] for name, _ in properties[3:]}
        columns = [table[name] for name, _ in properties if name.split("_")[0] == "next"]
        edges = [(a, b) for column in columns for a, b in enumerate(column) if b >= 0]
        self.edges = np.array(sorted(edges), int).reshape(-1, 2)
        cells = np.frombuffer(self.body[table.nbytes :], [("n", "u1"), ("v", "<i4", 3)], faces)
        assert (cells["n"] == 3).all() and len(self.body) == table.nbytes + cells.nbytes
        self.triangles = cells["v"]
        self.is_points = not len(self.edges) and not faces

    def data(self):
        """Attributes without those that tell the edges and the normals."""
        others = ("next", "nx", "ny", "nz")
        return {name: values for name, values in self.attributes.items() if name.split("_")[0] not in others}

    def vectors(self, names):
        return np.stack([self.attributes[name] for name in names], axis=1)
