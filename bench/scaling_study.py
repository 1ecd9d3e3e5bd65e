#!/usr/bin/env python3
"""Replays the measured times of a frame's tasks on 1 to 128 virtual cores and names what keeps it from scaling.

    bench/scaling_study.py [--build build] [--frames 20] [--size 1280x720] SCENE...

SCENE as for flat_frames. Each task is timed alone on one thread (least of --frames frames). Virtual cores then take tasks in
the order the program hands them out, each the next one when it is free; a phase begins when the one before has ended. What
runs between the phases (sorting runs by tile, tile order) runs on one core. Not modelled: memory bandwidth, caches shared by
several cores, clock speeds, and the cost of waking a thread.
"""
import argparse
import heapq
import json
import os
import subprocess
import sys

CORES = (1, 2, 4, 8, 16, 32, 64, 128)


def makespan(tasks, cores):
    free = [0.0] * min(cores, max(1, len(tasks)))
    for task in tasks:
        heapq.heapreplace(free, free[0] + task)
    return max(free)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--build", default="build")
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--size", default="1280x720")
    arguments = parser.parse_args()
    width, height = arguments.size.split("x")
    print(f"{'scene':28} {'1 core, ms':>10} {'serial':>7} " + "".join(f"{f'x{n}':>7}" for n in CORES[1:]) + "   at 64 cores bound by")
    for scene in arguments.scenes:
        done = subprocess.run([os.path.join(arguments.build, "bench", "flat_frames"), "--scene", scene, "--width", width, "--height", height,
                               "--frames", str(arguments.frames), "--tasks"], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(done.stderr)
        measured = json.loads(done.stdout)
        serial = measured.pop("serial_us")

        def frame(cores):
            return serial + sum(makespan(tasks, cores) for tasks in measured.values())

        alone = frame(1)
        # At 64 cores: the serial part, or the phase that takes longest there, and within it its longest task or its sum.
        parts = {name: makespan(tasks, 64) for name, tasks in measured.items()}
        parts["between phases"] = serial
        worst = max(parts, key=parts.get)
        reason = f"{worst}, {100 * parts[worst] / frame(64):.0f} %"
        if worst in measured and max(measured[worst]) > 0.9 * parts[worst]:
            reason += f": its longest task, {max(measured[worst]):.0f} us of {sum(measured[worst]):.0f}"
        print(f"{os.path.basename(scene):28} {alone / 1000:10.2f} {100 * serial / alone:6.2f}% "
              + "".join(f"{alone / frame(n):7.2f}" for n in CORES[1:]) + f"   {reason}")


if __name__ == "__main__":
    main()
