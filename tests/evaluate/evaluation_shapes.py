"""Objects with closed forms, by hand: two strips of a plane, a sphere cut into a cap and the rest; rods."""

import numpy as np

from graft.objects import Part, PartObject


def strips(cut: float, graspable: tuple[int, ...] = (0,)) -> PartObject:
    """The unit square in z = 0, cut at x = `cut`; part 0 is left of it."""

    def rectangle(name: str, low: float, high: float) -> Part:
        corners = np.array([[low, 0, 0], [high, 0, 0], [high, 1, 0], [low, 1, 0]], float)
        return Part(name, corners, np.array([[0, 1, 2], [0, 2, 3]]))

    return PartObject(
        "strips",
        (rectangle("left", 0, cut), rectangle("right", cut, 1)),
        graspable=graspable,
        category="plane",
    )


def capped_sphere(angle: float, rings: int = 40, name: str = "sphere") -> PartObject:
    """The unit sphere; part 0, graspable, is the cap of polar angle `angle` about +z."""

    def band(part: str, low: float, high: float) -> Part:
        polar = np.linspace(low, high, rings)
        turn = np.linspace(0, 2 * np.pi, 2 * rings + 1)
        t, f = np.meshgrid(polar, turn, indexing="ij")
        points = np.stack([np.sin(t) * np.cos(f), np.sin(t) * np.sin(f), np.cos(t)], axis=-1).reshape(-1, 3)
        row, width = np.arange(rings - 1)[:, None], 2 * rings + 1
        corner = (row * width + np.arange(2 * rings)).ravel()
        faces = np.concatenate(
            [
                np.column_stack([corner, corner + width, corner + 1]),
                np.column_stack([corner + 1, corner + width, corner + width + 1]),
            ]
        )
        return Part(part, points, faces)

    return PartObject(
        name,
        (band("cap", 0, angle), band("rest", angle, np.pi)),
        graspable=(0,),
        category="sphere",
        up=[0, 0, 1],
    )


def turned(seed: int, scale: float = 1.0) -> np.ndarray:
    """A random similarity (4, 4)."""
    rng = np.random.default_rng(seed)
    basis, upper = np.linalg.qr(rng.normal(size=(3, 3)))
    basis = basis * np.sign(np.diag(upper))
    if np.linalg.det(basis) < 0:
        basis[:, 0] *= -1
    transform = np.eye(4)
    transform[:3, :3] = scale * basis
    transform[:3, 3] = rng.normal(size=3)
    return transform


def box(name: str, low, high) -> Part:
    """An axis-aligned box, outward faces, each side cut into 6 x 6 squares."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    steps = np.linspace(0, 1, 7)
    points, faces = [], []
    for axis in range(3):
        for end in (0.0, 1.0):
            u, v = np.meshgrid(steps, steps, indexing="ij")
            grid = np.empty((7, 7, 3))
            grid[..., axis], grid[..., (axis + 1) % 3], grid[..., (axis + 2) % 3] = end, u, v
            start = sum(len(p) for p in points)
            corner = start + (np.arange(6)[:, None] * 7 + np.arange(6)).ravel()
            square = np.concatenate(
                [
                    np.column_stack([corner, corner + 7, corner + 8]),
                    np.column_stack([corner, corner + 8, corner + 1]),
                ]
            )
            faces.append(square if end else square[:, ::-1])
            points.append(grid.reshape(-1, 3))
    return Part(name, low + np.concatenate(points) * (high - low), np.concatenate(faces))


def hammer(name: str, length: float = 3.0, category: str = "hammer", head: float = 1.0) -> PartObject:
    """A long thin handle, graspable, along x, and a compact head at its end."""
    return PartObject(
        name,
        (
            box("head", [length, -head, -0.5 * head], [length + 0.8, head, 0.5 * head]),
            box("handle", [0, -0.2, -0.15], [length, 0.2, 0.15]),
        ),
        graspable=(1,),
        category=category,
        up=[0, 0, 1],
        scale_to_metres=0.1,
    )


def paddle(name: str, width: float = 1.0, category: str = "paddle") -> PartObject:
    """A thin shaft, graspable, and a wide flat blade."""
    return PartObject(
        name,
        (
            box("shaft", [0, -0.15, -0.15], [2.5, 0.15, 0.15]),
            box("blade", [2.5, -width, -0.1], [4.5, width, 0.1]),
        ),
        graspable=(0,),
        category=category,
        up=[0, 0, 1],
        scale_to_metres=0.1,
    )


def tools() -> list[PartObject]:
    """Four small objects of two categories."""
    return [
        hammer("hammer_a"),
        hammer("hammer_b", 4.0, head=0.8),
        paddle("paddle_a"),
        paddle("paddle_b", 0.8),
    ]
