#!/usr/bin/env python3
"""Chessboard corners, as OpenCV finds them, to a set of kind points: chessboard_to_set.py CORNERS.npz SET

CORNERS.npz is what this leaves behind in a calibration with OpenCV (cameraMatrix may be a guess):

    np.savez("corners.npz", corners=np.array(found), pattern=(9, 6), square_m=0.025,
             image_size=(640, 480), camera_matrix=cameraMatrix)

with `found` the list of the arrays that cv2.findChessboardCorners (better: cv2.cornerSubPix) gave, one an image,
all of the same board. Images where the board was not found may stand in it as NaN: they are left out. SET gets
measurement.yaml, points.csv and camera.yaml, a model to start from.
"""
import pathlib
import sys

import numpy as np


def write_set(folder, corners, pattern, square_m, image_size, camera_matrix):
    columns, rows = (int(n) for n in pattern)
    views = np.asarray(corners, dtype=float).reshape(len(corners), -1, 2)
    if views.shape[1] != columns * rows:
        raise SystemExit(f"{views.shape[1]} corners a view, expected {columns} x {rows}")
    folder.mkdir(parents=True, exist_ok=True)
    # OpenCV goes along the rows; the board's own coordinates are the world: x along a row, y down, z away.
    board = [(c * square_m, r * square_m) for r in range(rows) for c in range(columns)]
    lines = ["frame,time_s,point,x_m,y_m,z_m,u_px,v_px"]
    for frame, view in enumerate(views):
        if not np.isfinite(view).all():
            continue
        for point, ((x, y), (u, v)) in enumerate(zip(board, view)):
            # Board and camera stood still, so the time only has to differ from view to view.
            lines.append(f"{frame},{frame}.0,{point},{x:.6f},{y:.6f},0,{u:.4f},{v:.4f}")
    (folder / "points.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    width, height = (int(n) for n in image_size)
    (folder / "measurement.yaml").write_text(
        "format: seam-measurement/1\nkind: points\ntitle: A chessboard held before the camera\n"
        f"camera: {{width_px: {width}, height_px: {height}}}\n"
        "group: frame\nfiles: {points: points.csv}\nrig: {pose: unknown}\n", encoding="utf-8")
    k = np.asarray(camera_matrix, dtype=float)
    values = {"fx_px": k[0, 0], "fy_px": k[1, 1], "cx_px": k[0, 2], "cy_px": k[1, 2]}
    free = ", ".join(f"{name}: {{value: {value:.3f}, free: true}}" for name, value in values.items())
    (folder / "camera.yaml").write_text(
        f"format: seam-model/1\nname: camera\neffects:\n  pinhole: {{{free}}}\n", encoding="utf-8")


def main():
    source, folder = sys.argv[1:]
    found = np.load(source)
    write_set(pathlib.Path(folder), found["corners"], found["pattern"], float(found["square_m"]),
              found["image_size"], found["camera_matrix"])


if __name__ == "__main__":
    main()
