#!/usr/bin/env python3
"""Runs the plug-in in a GIMP without a display: a chart made here, corners given, found and by a path of four clicks; the
layer it adds is what the program writes; a picture without a chart is refused with the program's reason.

usage: gimp_plug_in_test.py ALUMINATE [PLUG_IN]. Exit 77: no GIMP or no plug-in, nothing tested."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from chart_picture import LEFT, PITCH, TOP, background, chart, write_png

SKIPPED = 77
CORNERS = [(LEFT, TOP), (LEFT + 5 * PITCH, TOP), (LEFT + 5 * PITCH, TOP + 3 * PITCH), (LEFT, TOP + 3 * PITCH)]


def scheme_load(path):
    return f'(image (car (gimp-file-load RUN-NONINTERACTIVE "{path}" "photo")))'


def run_gimp(home, script):
    environment = dict(os.environ, GIMP2_DIRECTORY=str(home), HOME=str(home), TMPDIR=str(home.parent / "scratch"), NO_AT_BRIDGE="1")
    done = subprocess.run(["gimp-console-2.10", "--no-interface", "--no-fonts", "--no-data", "-b", script, "-b", "(gimp-quit 1)"],
                          capture_output=True, text=True, timeout=240, env=environment)
    return done.stdout + done.stderr


def main():
    if len(sys.argv) < 3:
        print("skipped: the plug-in was not built (Debian: libgimp2.0-dev)")
        return SKIPPED
    program, plug_in = sys.argv[1:3]
    if shutil.which("gimp-console-2.10") is None:
        print("skipped: there is no gimp-console-2.10 (Debian: gimp)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder_name:
        folder = pathlib.Path(folder_name)
        home = folder / "gimp"
        target = home / "plug-ins" / "aluminate_calibrate"
        target.mkdir(parents=True)
        (folder / "scratch").mkdir()
        shutil.copy(plug_in, target / "aluminate_calibrate")
        write_png(folder / "photo.png", chart)
        write_png(folder / "empty.png", background)
        corners = ";".join(f"{x},{y}" for x, y in CORNERS)

        def script(photo, before, given, out):
            return (f'(let* ({scheme_load(folder / photo)} (drawable (car (gimp-image-get-active-drawable image)))) {before} '
                    f'(let* ((layer (car (plug-in-aluminate-calibrate RUN-NONINTERACTIVE image drawable "{program}" "{given}" "linear")))) '
                    f'(gimp-message (string-append "layers " (number->string (car (gimp-image-get-layers image))) " " (car (gimp-item-get-name layer)))) '
                    f'(file-png-save RUN-NONINTERACTIVE image layer "{folder / out}" "x" 0 9 0 0 0 0 0)))')

        # Anchors lie at pixel centres, half a unit on in GIMP's coordinates; each with its two handles.
        numbers = " ".join(f"{x + .5} {y + .5}" for x, y in CORNERS for _ in range(3))
        path = ('(let* ((path (car (gimp-vectors-new image "clicks")))) (gimp-image-insert-vectors image path 0 0) '
                f'(gimp-vectors-stroke-new-from-points path VECTORS-STROKE-TYPE-BEZIER 24 #({numbers}) FALSE) '
                '(gimp-image-set-active-vectors image path))')
        subprocess.run([program, "-q", "calibrate", folder / "photo.png", "-o", folder / "expected.png", "--bits", "8", "--fit", "linear",
                        "--corners", corners], check=True, stdout=subprocess.DEVNULL)
        for name, before, given in (("given.png", "", corners), ("clicked.png", path, "")):
            talk = run_gimp(home, script("photo.png", before, given, name))
            assert (folder / name).exists(), f"{name}: no picture was saved:\n{talk}"
            assert "layers 2 albedo (aluminate)" in talk, f"{name}: expected a second layer:\n{talk}"
            difference = subprocess.run([program, "diff", folder / name, folder / "expected.png"], capture_output=True, text=True)
            # GIMP's image has 8 bits: its rounding of the 16-bit layer may differ from the program's by one code.
            assert largest_step(difference.stdout) <= 1, f"{name}: {difference.stdout}{difference.stderr}"
        talk = run_gimp(home, script("photo.png", "", "", "found.png"))
        assert (folder / "found.png").exists(), f"without corners: no picture was saved:\n{talk}"

        talk = run_gimp(home, script("empty.png", "", "", "refused.png"))
        assert not (folder / "refused.png").exists(), "a picture without a chart was accepted"
        assert "no ColorChecker was found" in talk, f"the refusal must give the reason:\n{talk}"
        three = path.replace(" 24 #(", " 18 #(").replace(numbers, " ".join(numbers.split()[:18]))
        talk = run_gimp(home, script("photo.png", three, "", "three.png"))
        assert "the path has 3 points, expected 4" in talk, f"a path of three points must be refused:\n{talk}"
        leftovers = list((folder / "scratch").glob("aluminate-*"))
        assert not leftovers, f"temporary folders are left: {leftovers}"
    print("the plug-in adds the program's picture as a layer, by corners, by clicks and found; refusals give reasons")
    return 0


def largest_step(text):
    """Of what `aluminate diff` says."""
    if text.startswith("equal"):
        return 0
    return int(re.search(r"^largest (\d+) steps", text, re.MULTILINE).group(1))


if __name__ == "__main__":
    sys.exit(main())
