#!/usr/bin/env python3
"""Tables and contact sheets of docs/frame.md, from the program's own JSON and pictures.

  frame_study.py PROGRAM crossover [--size WxH]     forward against deferred, rig and bounded lights, both consoles
  frame_study.py PROGRAM variants                   the visibility terms in both pipelines
  frame_study.py PROGRAM shimmer [--frames K]       temporal variance with and without Toksvig, against 256 samples
  frame_study.py PROGRAM sheets -o FOLDER           beach hut at 8 times of day, material wall under all variants

Standard library only: the pictures are the program's own 8-bit PNGs.
"""

import argparse
import itertools
import json
import math
import os
import random
import shutil
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
    print("| console | pipeline | visibility | ms | words/px | one more light, slots (over none) | words | "
          "hoisted or shared, slots (over none) | words |")
    print("|---|---|---|---|---|---|---|---|---|")
    for console in CONSOLES:
        for pipeline in ("forward", "deferred"):
            none = None
            for visibility in ("none", "cheap", "integrated", "schlick-smith"):
                d = program.bill(scene("material_wall"), "--size", args.size, "--lights", args.lights, "--platform", console,
                                 "--pipeline", pipeline, "--visibility", visibility)
                rows = d["per_light"]
                none = none or rows
                marginal = " | ".join(f"{r['alu_slots']} ({r['alu_slots'] - n['alu_slots']:+d}) | {r['alu_words']:.0f}"
                                      for r, n in zip(rows, none))
                print(f"| {console} | {pipeline} | {visibility} | {d['cost']['frame_ms']:.3f} | "
                      f"{d['per_pixel']['alu_words']['mean']:.1f} | {marginal} |", flush=True)


def read_exr(path, box=1):
    """Flat list of linear R, G, B of one of the program's own EXR pictures (float, ZIP), each the mean of box x box pixels."""
    data = open(path, "rb").read()
    at, width, height = 8, 0, 0
    while data[at] != 0:
        name_end = data.index(b"\0", at)
        kind_end = data.index(b"\0", name_end + 1)
        size = struct.unpack_from("<i", data, kind_end + 1)[0]
        if data[at:name_end] == b"dataWindow":
            left, top, right, bottom = struct.unpack_from("<4i", data, kind_end + 5)
            width, height = right - left + 1, bottom - top + 1
        at = kind_end + 5 + size
    blocks = struct.unpack_from(f"<{(height + 15) // 16}q", data, at + 1)
    sums = [[0.0] * (3 * width // box) for _ in range(height // box)]
    for block in blocks:
        first, size = struct.unpack_from("<2i", data, block)
        lines = min(16, height - first)
        length = lines * width * 16
        raw = data[block + 8:block + 8 + size]
        if size < length:
            steps = itertools.accumulate(zlib.decompress(raw))  # each byte is the change from the one before, plus 128
            raw = bytes((total - 128 * i) & 255 for i, total in enumerate(steps))
            half = (length + 1) // 2
            both = bytearray(length)
            both[0::2], both[1::2] = raw[:half], raw[half:]
            raw = both
        for line in range(lines):
            row = sums[(first + line) // box]
            for c in range(3):  # stored A, B, G, R
                values = struct.unpack_from(f"<{width}f", raw, (4 * line + 3 - c) * 4 * width)
                for x in range(width // box):
                    row[3 * x + c] += sum(values[x * box:x * box + box])
    return [v / (box * box) for row in sums for v in row]


def variance(frames):
    """Mean over channels of the variance over time."""
    total = 0.0
    for values in zip(*frames):
        mean = sum(values) / len(values)
        total += sum((v - mean) ** 2 for v in values) / len(values)
    return total / len(frames[0])


def bumpy_floor(folder):
    """A metal floor with a normal map of random waves, nothing else: all that can flicker is its highlight."""
    size, waves = 256, random.Random(1)
    terms = [(waves.randint(-40, 40), waves.randint(-40, 40), waves.random() * 2 * math.pi) for _ in range(48)]
    rows = []
    sines = [math.sin(2 * math.pi * i / size) for i in range(size)]
    for y in range(size):
        row = bytearray()
        for x in range(size):
            dx = dy = 0.0
            for i, j, phase in terms:
                s = sines[int(i * x + j * y + phase * size / (2 * math.pi)) % size]
                length = math.hypot(i, j) or 1.0
                dx += s * i / length
                dy += s * j / length
            dx, dy = 0.05 * dx, 0.05 * dy
            scale = 127.5 / math.sqrt(dx * dx + dy * dy + 1)
            row += bytes((int(127.5 - dx * scale + 0.5), int(127.5 - dy * scale + 0.5), int(127.5 + scale + 0.5)))
        rows.append(bytes(row))
    write_png(os.path.join(folder, "waves.png"), size, rows)
    corners = [(-10, 10), (10, 10), (10, -10), (-10, -10)]
    body = b"".join(struct.pack("<3f", x, 0, z) for x, z in corners) + struct.pack("<3f", 0, 1, 0) * 4 + \
        struct.pack("<4f", 1, 0, 0, 1) * 4 + b"".join(struct.pack("<2f", x / 1.28, z / 1.28) for x, z in corners) + \
        struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    open(os.path.join(folder, "floor.bin"), "wb").write(body)
    views = [(0, 48), (48, 48), (96, 64), (160, 32), (192, 12)]
    kinds = [("VEC3", 5126, 4), ("VEC3", 5126, 4), ("VEC4", 5126, 4), ("VEC2", 5126, 4), ("SCALAR", 5123, 6)]
    accessors = [{"bufferView": i, "componentType": kind[1], "count": kind[2], "type": kind[0]} for i, kind in enumerate(kinds)]
    accessors[0].update(min=[-10, 0, -10], max=[10, 0, 10])
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3},
                                    "indices": 4, "material": 0}]}],
        "materials": [{"name": "waves", "normalTexture": {"index": 0}, "pbrMetallicRoughness": {
            "baseColorFactor": [0.05, 0.05, 0.05, 1], "metallicFactor": 1, "roughnessFactor": 0.3}}],
        "textures": [{"source": 0}], "images": [{"uri": "waves.png"}],
        "buffers": [{"uri": "floor.bin", "byteLength": len(body)}],
        "bufferViews": [{"buffer": 0, "byteOffset": o, "byteLength": n} for o, n in views], "accessors": accessors}
    path = os.path.join(folder, "bumpy_floor.gltf")
    json.dump(document, open(path, "w"))
    return path


def shimmer(program, args):
    width, height = (int(v) for v in args.size.split("x"))
    modes = ("off", "texture", "dxt5", "material")
    floor = bumpy_floor(program.folder.name)
    # Into the mirror direction of the light; the floor fills the view. A step is about a tenth of a pixel.
    cameras = [f"{0.003 * k},2,{0.002 * k}:{1 + 0.003 * k},0,{0.6 + 0.002 * k}:50" for k in range(args.frames)]
    frames = {mode: [] for mode in modes}
    truth = []
    for camera in cameras:
        common = ("--camera", camera, "--lights", "rig:1", "--ambient", "none")
        for mode in modes:
            path = program.picture(floor, program.file("f.exr"), "--size", args.size, "--toksvig", mode, *common)
            frames[mode].append(read_exr(path))
        path = program.picture(floor, program.file("r.exr"), "--size", f"{16 * width}x{16 * height}", *common)
        truth.append(read_exr(path, 16))
    for unit, map_ in (("linear light", lambda v: v), ("light as displayed, clamped to 1", lambda v: min(v, 1.0))):
        good = [[map_(v) for v in frame] for frame in truth]
        base = variance(good)
        mean = sum(map(sum, good)) / sum(map(len, good))
        print(f"\n{unit}; mean of the reference {mean:.3f}\n")
        print("| `--toksvig` | temporal variance, 1e-3 | of the reference's | rms error against 256 samples | mean |")
        print("|---|---|---|---|---|")
        print(f"| 256 samples a pixel | {base * 1e3:.3f} | 1.00 | 0 | {mean:.3f} |")
        for mode, raw in frames.items():
            stack = [[map_(v) for v in frame] for frame in raw]
            count = len(stack) * len(stack[0])
            squares = sum((a - b) ** 2 for frame, best in zip(stack, good) for a, b in zip(frame, best))
            print(f"| {mode} | {variance(stack) * 1e3:.3f} | {variance(stack) / base:.2f} | {(squares / count) ** 0.5:.4f} | "
                  f"{sum(map(sum, stack)) / count:.3f} |", flush=True)


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


# What is left of a photograph's own exposure and white balance in each material when nobody calibrated it.
UNCALIBRATED = {"planks": (0.45, 0.5, 0.6), "thatch": (1.0, 0.8, 0.55), "sand": (0.55, 0.55, 0.62), "bark": (1.6, 1.5, 1.4),
                "palm leaf": (0.5, 0.6, 0.5), "rock": (3.0, 3.0, 3.2), "ceramic": (2.0, 2.0, 1.8), "lacquer": (0.8, 0.6, 0.6)}


def uncalibrated(source, folder):
    """The scene with its albedo as UNCALIBRATED says, beside copies of what it refers to."""
    document = json.load(open(source))
    for material in document["materials"]:
        gain = UNCALIBRATED.get(material["name"])
        if gain:
            base = material.setdefault("pbrMetallicRoughness", {})
            factor = base.get("baseColorFactor", [1, 1, 1, 1])
            base["baseColorFactor"] = [min(1.0, f * g) for f, g in zip(factor, gain)] + factor[3:]
    for item in document.get("images", []) + document["buffers"]:
        shutil.copyfile(os.path.join(os.path.dirname(source), item["uri"]), os.path.join(folder, item["uri"]))
    path = os.path.join(folder, "uncalibrated.gltf")
    json.dump(document, open(path, "w"))
    return path


def sheets(program, args):
    os.makedirs(args.output, exist_ok=True)
    size = ("--size", "320x180")
    times = ("05:45", "06:30", "08:00", "10:00", "12:00", "15:00", "17:30", "18:20")
    for name, source in (("beach_hut_day", scene("beach_hut")),
                         ("beach_hut_day_uncalibrated", uncalibrated(scene("beach_hut"), program.folder.name))):
        tiles = []
        for view, camera in (("outside", "gltf:0"), ("inside", "gltf:1")):
            for time in times:
                tile = program.file(f"{name}_{view}_{time.replace(':', '')}.png")
                tiles.append(program.picture(source, tile, *size, "--camera", camera, "--sky", "fc3", "--time", time,
                                             "--ambient", "sky", "--shadows", "on", "--pipeline", "deferred", "--tonemap",
                                             "filmic"))
        sheet(tiles, 4, os.path.join(args.output, name + ".png"))
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
    parser.add_argument("--lights", default="rig:4")
    parser.add_argument("-o", "--output", default=".")
    args = parser.parse_args()
    globals()[args.study](Program(args.program), args)


if __name__ == "__main__":
    main()
