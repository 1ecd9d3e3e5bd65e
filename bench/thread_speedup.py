#!/usr/bin/env python3
"""What two threads gain over one, beside what the machine itself has to give.

    bench/thread_speedup.py [--build build/release] [--rounds 40] [--frames 20] SCENE...

SCENE as for flat_frames. A round runs, back to back, the program on one thread, the program on two, and two programs of one
thread each at the same time. The last shows what two cores give to work that shares nothing: on a rented machine whose cores
are half of a physical one, or whose neighbours are busy, that is less than twice. Of each run the median frame counts, of those the
median over the rounds, then the ratio of medians; the last column is the first ratio over the second.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--rounds", type=int, default=40)
    parser.add_argument("--frames", type=int, default=20)
    arguments = parser.parse_args()
    program = os.path.join(arguments.build, "bench", "flat_frames")

    def start(scene, threads):
        return subprocess.Popen([program, "--scene", scene, "--frames", str(arguments.frames), "--threads", str(threads)],
                                stdout=subprocess.PIPE, text=True)

    def finish(process):
        text, _ = process.communicate()
        if process.returncode != 0:
            sys.exit(process.returncode)
        return json.loads(text)["ms_median"]

    print(f"{'scene':28} {'1 thread, ms':>12} {'2 threads':>10} {'gain':>6} {'of two programs':>16} {'share':>6}")
    for scene in arguments.scenes:
        one, two, apart = [], [], []
        for _ in range(arguments.rounds):
            one.append(finish(start(scene, 1)))
            two.append(finish(start(scene, 2)))
            apart += [finish(p) for p in [start(scene, 1), start(scene, 1)]]
        alone = statistics.median(one)
        gain, capacity = alone / statistics.median(two), 2 * alone / statistics.median(apart)
        print(f"{os.path.basename(scene):28} {alone:12.2f} {statistics.median(two):10.2f} {gain:6.2f} {capacity:16.2f} {gain / capacity:6.2f}", flush=True)


if __name__ == "__main__":
    main()
