#!/usr/bin/env python3
"""On a small board of known numbers SEAM, OpenCV and mrcal agree within their errors, and with the truth
(scripts/camera_peers.py). camera_peers_test.py path/to/seam; exit code 77 where a peer is not installed."""
import pathlib
import sys
import tempfile

try:
    import cv2  # noqa: F401
    import mrcal  # noqa: F401
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "scripts"))
import camera_peers  # noqa: E402

import by_hand

by_hand.arguments("seam")


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "board"
        camera_peers.make(folder, warp_mm=(1, -0.5), views=10, seed=7)
        corners = camera_peers.Corners(folder)
        answers = camera_peers.compare(corners, "opencv5", sys.argv[1], warp=True)
        assert answers.keys() == {"SEAM", "OpenCV", "mrcal"}, answers.keys()
        camera_peers.print_table(corners, "opencv5", answers)
        ours, theirs = answers["SEAM"], answers["mrcal"]
        titles = camera_peers.CAMERA + camera_peers.LENSES["opencv5"] + camera_peers.WARP
        for title in titles:
            value, sigma = ours["values"][title], ours["sigmas"][title]
            apart = abs(value - theirs["values"][title]) / sigma
            assert apart < 2, (title, "of SEAM and mrcal are apart by sigmas:", apart)
            # Ours is of the views that are not held out.
            assert 1 < sigma / theirs["sigmas"][title] < 1.6, (title, sigma, theirs["sigmas"][title])
            for who in (ours, theirs):
                off = abs(who["values"][title] - corners.truth[title]) / who["sigmas"][title]
                assert off < 4, (title, "is off the truth by sigmas:", off)
        assert abs(ours["rms_px"] / theirs["rms_px"] - 1) < 0.02, (ours["rms_px"], theirs["rms_px"])
        # A peer that takes the board for flat is off, beyond its error: what the bend is for.
        flat = answers["OpenCV"]
        assert flat["rms_px"] > 1.3 * ours["rms_px"], flat["rms_px"]
        # The same lens without the bend: OpenCV and we.
        straight = camera_peers.by_seam(corners, camera_peers.LENSES["opencv5"], False, sys.argv[1])
        for title in camera_peers.CAMERA:
            apart = abs(straight[0][title] - flat["values"][title]) / straight[1][title]
            assert apart < 3, (title, "of SEAM and OpenCV are apart by sigmas:", apart)


main()
