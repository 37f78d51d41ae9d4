#!/usr/bin/env python3
"""`seam import` of real files of other programs, which are not part of the source; exit code 77 where they are not there.
`import_samples_test.py path/to/seam [folder of samples]`"""
import pathlib
import sys

from importing import HERE, imported, rows_of, run_tests

SAMPLES = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE.parent / "shared" / "samples"
if not SAMPLES.is_dir():
    print(f"skipped: {SAMPLES} is not there (real files that are not part of the source)")
    sys.exit(77)


def test_samples(folder):
    imported("servo", *sorted((SAMPLES / "bam").glob("*.json")), out=folder / "bam")
    assert len(rows_of(folder / "bam" / "joints.csv")) == 2240
    imported("ranges", SAMPLES / "plaza" / "Plaza1_.mat", out=folder / "plaza")
    assert len(rows_of(folder / "plaza" / "observations.csv")) == 3529
    vnl = SAMPLES / "mrcal" / "synthetic-board-observations.vnl"
    imported("mrcal", vnl, SAMPLES / "mrcal" / "cam0.opencv8.cameramodel", "--board", "10x10", "--spacing", "0.1",
             out=folder / "vnl")
    imported("opencv", SAMPLES / "ros" / "camera_info.yaml", out=folder / "info")
    imported("euroc", SAMPLES / "euroc" / "V102_groundtruth_part.csv", out=folder / "euroc")
    imported("tum", SAMPLES / "euroc" / "tum_freiburg1_xyz_part.txt", out=folder / "tum")
    imported("ros", SAMPLES / "ros" / "nav2_turtlebot.mcap", out=folder / "ros")
    imported("emva1288", SAMPLES / "emva1288" / "ccd_12bit" / "EMVA1288_Data.txt", out=folder / "emva")


run_tests(globals())
