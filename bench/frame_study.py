#!/usr/bin/env python3
"""Tables and contact sheets of docs/frame.md, from the program's own JSON and pictures.

  frame_study.py PROGRAM crossover [--size WxH]     forward against deferred, rig and bounded lights, both consoles
  frame_study.py PROGRAM variants                   the visibility terms in both pipelines
  frame_study.py PROGRAM shimmer [--frames K]       temporal variance with and without Toksvig, against 256 samples
  frame_study.py PROGRAM sheets -o FOLDER           beach hut at 8 times of day, material wall under all variants

Standard library only: the pictures are the program's own 8-bit PNGs.
"""

import argparse
import json
import os
import struct
import subprocess
import tempfile
import zlib

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
CONSOLES = ("xenos", "rsx")


def scene(name):
    return os.path.join(ROOT, "scenes", "samples", name + ".gltf")


class Program:
    def __init__(self, path):
        self.path = path
        self.folder = tempfile.TemporaryDirectory()

    def picture(self, source, path, *options):
        subprocess.run([self.path, "render", source, "-o", path, "--quiet", *options],
                       check=True, stdout=subprocess.DEVNULL)
        return path

    def bill(self, source, *options):
        path = os.path.join(self.folder.name, "out.png")
        run = subprocess.run([self.path, "render", source, "-o", path, "--json", "-", "--quiet", *options],
                             check=True, capture_output=True, text=True)
        return json.loads(run.stdout)

    def file(self, name):
        return os.path.join(self.folder.name, name)


def words(document):
    return sum(p["alu_words"] for p in document["cost"]["passes"])


def passes(document):
    return ", ".join(f"{p['name']} {p['ms']:.2f}" for p in document["cost"]["passes"])


def read_png(path):
    """(width, height, rows of RGB bytes) of an 8-bit RGBA or RGB PNG."""
    data = open(path, "rb").read()
    at, packed, width, height, channels = 8, b"", 0, 0, 4
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, _, color = struct.unpack(">IIBB", body[:10])
            channels = 4 if color == 6 else 3
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, stride, rows = zlib.decompress(packed), width * channels, []
    above = bytearray(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        if kind:
            for i in range(stride):
                left = row[i - channels] if i >= channels else 0
                up = above[i]
                if kind == 1:
                    guess = left
                elif kind == 2:
                    guess = up
                elif kind == 3:
                    guess = (left + up) // 2
                else:
                    corner = above[i - channels] if i >= channels else 0
                    p = left + up - corner
                    a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                    guess = left if a <= b and a <= c else up if b <= c else corner
                row[i] = (row[i] + guess) & 255
        above = row
        rows.append(bytes(row) if channels == 3 else bytes(v for i, v in enumerate(row) if i % 4 != 3))
    return width, height, rows


def write_png(path, width, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    raw = b"".join(b"\0" + row for row in rows)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(rows), 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))


LINEAR = [v / 255 / 12.92 if v <= 10 else ((v / 255 + 0.055) / 1.055) ** 2.4 for v in range(256)]


def linear_picture(path, box=1):
    """Flat list of linear channels, each the mean of box x box stored pixels."""
    width, height, rows = read_png(path)
    out = []
    for top in range(0, height, box):
        sums = [0.0] * (3 * width // box)
        for row in rows[top:top + box]:
            for x in range(width):
                to = 3 * (x // box)
                sums[to] += LINEAR[row[3 * x]]
                sums[to + 1] += LINEAR[row[3 * x + 1]]
                sums[to + 2] += LINEAR[row[3 * x + 2]]
        out += [v / (box * box) for v in sums]
    return out


def crossover(program, args):
    for source, kind in (("beach_hut", "rig"), ("beach_hut", "lamps"), ("overdraw_stress", "rig")):
        print(f"\n{source}, `--lights {kind}:N`, {args.size}\n")
        print("| N | console | forward ms | deferred ms | deferred, by pass | G words forward | deferred |")
        print("|---|---|---|---|---|---|---|")
        for console in CONSOLES:
            for count in (1, 4, 16, 64):
                common = ("--size", args.size, "--lights", f"{kind}:{count}", "--platform", console)
                f = program.bill(scene(source), *common)
                d = program.bill(scene(source), *common, "--pipeline", "deferred")
                print(f"| {count} | {console} | {f['cost']['frame_ms']:.2f} | {d['cost']['frame_ms']:.2f} | {passes(d)} | "
                      f"{words(f) / 1e9:.3f} | {words(d) / 1e9:.3f} |", flush=True)


def variants(program, args):
    print("| visibility | pipeline | console | ms | words/px | one more light: rolled slots / words | hoisted slots / words |")
    print("|---|---|---|---|---|---|---|")
    for console in CONSOLES:
        for pipeline in ("forward", "deferred"):
            for visibility in ("none", "cheap", "integrated", "schlick-smith"):
                d = program.bill(scene("material_wall"), "--size", args.size, "--lights", "rig:4", "--platform", console,
                                 "--pipeline", pipeline, "--visibility", visibility)
                rows = d["per_light"]
                marginal = " | ".join(f"{r['alu_slots']} / {r['alu_words']:.0f}" for r in rows)
                print(f"| {visibility} | {pipeline} | {console} | {d['cost']['frame_ms']:.3f} | "
                      f"{d['per_pixel']['alu_words']['mean']:.1f} | {marginal} |", flush=True)


def variance(frames):
    """Mean over channels of the variance over time."""
    total = 0.0
    for values in zip(*frames):
        mean = sum(values) / len(values)
        total += sum((v - mean) ** 2 for v in values) / len(values)
    return total / len(frames[0])


def shimmer(program, args):
    width, height = (int(v) for v in args.size.split("x"))
    modes = ("off", "texture", "dxt5", "material")
    # A step is a fraction of a texel: highlights flicker, the picture as a whole hardly moves.
    cameras = [f"{0.4 + 0.003 * k},1.1,{6.2 - 0.004 * k}:0,0.2,-8:50" for k in range(args.frames)]
    frames = {mode: [] for mode in modes}
    truth = []
    for camera in cameras:
        common = ("--camera", camera, "--lights", args.lights)
        for mode in modes:
            path = program.picture(scene(args.scene), program.file("f.png"), "--size", args.size, "--toksvig", mode, *common)
            frames[mode].append(linear_picture(path))
        path = program.picture(scene(args.scene), program.file("r.png"), "--size", f"{16 * width}x{16 * height}", *common)
        truth.append(linear_picture(path, 16))
    base = variance(truth)
    print("| `--toksvig` | temporal variance, 1e-6 | of the reference's | rms error against 256 samples |")
    print("|---|---|---|---|")
    print(f"| 256 samples a pixel | {base * 1e6:.1f} | 1.00 | 0 |")
    for mode, stack in frames.items():
        squares = sum((a - b) ** 2 for frame, good in zip(stack, truth) for a, b in zip(frame, good))
        error = (squares / (len(stack) * len(stack[0]))) ** 0.5
        print(f"| {mode} | {variance(stack) * 1e6:.1f} | {variance(stack) / base:.2f} | {error:.4f} |", flush=True)


def sheet(tiles, columns, path):
    pictures = [read_png(file) for file in tiles]
    width, height, _ = pictures[0]
    gap = b"\x18" * (3 * 4)
    rows = []
    for first in range(0, len(pictures), columns):
        line = pictures[first:first + columns]
        for y in range(height):
            rows.append(gap.join(p[2][y] for p in line).ljust(3 * (columns * width + 4 * (columns - 1)), b"\x18"))
        rows += [b"\x18" * len(rows[0])] * 4
    write_png(path, columns * width + 4 * (columns - 1), rows)
    print(path)


def sheets(program, args):
    os.makedirs(args.output, exist_ok=True)
    size = ("--size", "320x180")
    times = ("05:45", "06:30", "08:00", "10:00", "12:00", "15:00", "17:30", "18:20")
    tiles = []
    for view, camera in (("outside", "gltf:0"), ("inside", "gltf:1")):
        for time in times:
            name = program.file(f"hut_{view}_{time.replace(':', '')}.png")
            tiles.append(program.picture(scene("beach_hut"), name, *size, "--camera", camera, "--sky", "fc3", "--time", time,
                                         "--ambient", "sky", "--shadows", "on", "--pipeline", "deferred", "--tonemap", "filmic"))
    sheet(tiles, 4, os.path.join(args.output, "beach_hut_day.png"))
    tiles = []
    for fresnel in ("schlick", "sg", "sg-lagarde"):
        for visibility in ("none", "cheap", "integrated", "schlick-smith"):
            name = program.file(f"wall_{fresnel}_{visibility}.png")
            tiles.append(program.picture(scene("material_wall"), name, *size, "--fresnel", fresnel, "--visibility", visibility))
    sheet(tiles, 4, os.path.join(args.output, "material_wall_variants.png"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("study", choices=("crossover", "variants", "shimmer", "sheets"))
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--scene", default="grazing_floor")
    parser.add_argument("--lights", default="rig:4")
    parser.add_argument("-o", "--output", default=".")
    args = parser.parse_args()
    globals()[args.study](Program(args.program), args)


if __name__ == "__main__":
    main()
