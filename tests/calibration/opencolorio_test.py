#!/usr/bin/env python3
"""OpenColorIO reads the .cube and makes of a photograph what the program makes of it.

usage: opencolorio_test.py ALUMINATE. Exit 77: no oiiotool, nothing tested."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import chart_picture

SKIPPED = 77

# The smallest configuration with the table in it: a space for photographs, one for albedos.
CONFIGURATION = """ocio_profile_version: 1
search_path: {folder}
roles:
  default: photograph
displays:
  screen:
    - !<View> {{name: plain, colorspace: photograph}}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: photograph
    bitdepth: 32f
  - !<ColorSpace>
    name: albedo
    bitdepth: 32f
    from_reference: !<FileTransform> {{src: chart.cube, interpolation: tetrahedral}}
"""


def run(*command):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


def main():
    if shutil.which("oiiotool") is None:
        print("skipped: there is no oiiotool (Debian: openimageio-tools)")
        return SKIPPED
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder_name:
        folder = pathlib.Path(folder_name)
        photo, direct, table = folder / "photo.png", folder / "direct.png", folder / "table.png"
        chart_picture.write_png(photo, chart_picture.chart)
        (folder / "config.ocio").write_text(CONFIGURATION.format(folder=folder))
        for fit in ("linear", "tone-linear", "affine-poly-affine"):
            run(program, "-q", "calibrate", photo, "-o", direct, "--fit", fit, "--cube", folder / "chart.cube", "--cube-size", 65)
            run("oiiotool", "--colorconfig", folder / "config.ocio", photo, "--ch", "R,G,B", "--colorconvert", "photograph", "albedo", "-d", "uint16",
                "-o", table)
            text = subprocess.run(["oiiotool", table, direct, "--diff"], capture_output=True, text=True).stdout
            errors = {name: float(re.search(rf"{name} error\s*=\s*(\S+)", text).group(1)) for name in ("Mean", "Max")}
            # Tetrahedra between points 1/64 apart against the transform itself: the curvature of the sRGB curve in a cell.
            assert errors["Mean"] < 0.0005 and errors["Max"] < 0.01, f"{fit}: {text}"
            print(f"{fit}: mean {errors['Mean']:.6f}, max {errors['Max']:.6f} of 1")
    return 0


if __name__ == "__main__":
    sys.exit(main())
