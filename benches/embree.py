"""Rays per second of Embree (open3d's RaycastingScene) for the views that benches/sensors.rs casts.

Takes the room as GLB and the views as JSON (a list of {"world_from_camera": 16 numbers by columns, "width",
"height", "focal_px"}); prints one JSON object a line of threads: {"threads": n, "rays_per_s": r, "hits": h,
"mean_depth_m": d}. The mean depth tells whether both saw the same. Needs numpy and open3d.

    python embree.py room.glb views.json 1 2
"""

import json
import sys
import time

import numpy as np
import open3d as o3d


def rays_of(view):
    """(height, width, 6) origins and directions; multiples of a direction are depths along the axis."""
    world_from_camera = np.array(view["world_from_camera"], dtype=np.float64).reshape(4, 4).T
    x = (np.arange(view["width"]) + 0.5 - 0.5 * view["width"]) / view["focal_px"]
    y = (np.arange(view["height"]) + 0.5 - 0.5 * view["height"]) / view["focal_px"]
    x, y = np.meshgrid(x, y)
    directions = np.stack([x, y, np.ones_like(x)], axis=-1) @ world_from_camera[:3, :3].T
    origins = np.broadcast_to(world_from_camera[:3, 3], directions.shape)
    return np.concatenate([origins, directions], axis=-1).astype(np.float32)


def main():
    room, views, threads = sys.argv[1], sys.argv[2], [int(n) for n in sys.argv[3:]] or [1]
    mesh = o3d.t.geometry.TriangleMesh.from_legacy(o3d.io.read_triangle_mesh(room))
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(mesh)
    with open(views, encoding="utf-8") as file:
        batches = [o3d.core.Tensor(rays_of(view)) for view in json.load(file)]
    count = sum(int(np.prod(batch.shape[:-1])) for batch in batches)
    for n in threads:
        best, depths = float("inf"), None
        for _ in range(6):  # the first run also builds the tree; the best one counts
            start = time.perf_counter()
            answers = [scene.cast_rays(batch, nthreads=n) for batch in batches]
            best = min(best, time.perf_counter() - start)
            depths = np.concatenate([a["t_hit"].numpy().ravel() for a in answers])
        hit = np.isfinite(depths)
        print(json.dumps({"threads": n, "rays_per_s": count / best, "hits": int(hit.sum()),
                          "mean_depth_m": float(depths[hit].mean())}))


if __name__ == "__main__":
    main()
