#!/usr/bin/env python3
"""Times flat_frames (and aluminate) beside another renderer, alternately in one run, and prints times and ratios.

    bench/peer_ratios.py --peer "COMMAND" [--build build] [--models A.glb B.glb] [--rows grid,fill,...] [--repeat 3]

COMMAND is the other renderer with its leading arguments. It must understand
    --scene synth:grid:N | synth:fill:K | FILE  --size WxH  --shade flat|tex|full  --lights N  --cam outside|gltf
    --threads 0 (all on the calling thread) | N  --frames K
and print one line of JSON with ms_median, ms_min and cpu_ms_median per frame. Both sides transform the same vertices, set up
and rasterize the same triangles with depth, and leave a picture of 8-bit RGBA in memory. Rows named "shaded" go through
`aluminate render`, whose frame also makes the console's bill.
"""
import argparse
import json
import os
import shlex
import statistics
import struct
import subprocess
import sys
import tempfile
import zlib


def run(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode != 0 or not lines:
        sys.exit(f"{shlex.join(command)} failed ({done.returncode}):\n{done.stdout}{done.stderr}")
    return json.loads(lines[-1])


def noise_png(size):
    """A grey-free RGB picture of pseudo-random texels, as the bytes of a PNG file."""
    state, rows = 1, bytearray()
    for _ in range(size):
        rows.append(0)
        for _ in range(3 * size):
            state = (state * 1664525 + 1013904223) & 0xffffffff
            rows.append(state >> 24)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(bytes(rows))) + chunk(b"IEND", b""))


def textured_file(path):
    """A .gltf of one quad that reaches beyond the picture, with normals, tangents and a 256x256 base colour texture."""
    corners = [(-4, -4, -1), (4, -4, -1), (4, 4, -1), (-4, 4, -1)]
    parts = [b"".join(struct.pack("<3f", *c) for c in corners), struct.pack("<3f", 0, 0, 1) * 4, struct.pack("<4f", 1, 0, 0, 1) * 4,
             b"".join(struct.pack("<2f", 2.0 * c[0], 2.0 * c[1]) for c in corners), struct.pack("<6H", 0, 1, 2, 0, 2, 3)]
    views, offset = [], 0
    for part in parts:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(part)})
        offset += len(part)
    name = os.path.basename(path).replace(".gltf", "")
    with open(path.replace(".gltf", ".bin"), "wb") as out:
        out.write(b"".join(parts))
    with open(path.replace(".gltf", ".png"), "wb") as out:
        out.write(noise_png(256))
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.5, "zfar": 100.0}}],
        "images": [{"uri": name + ".png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 0.4}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3}, "indices": 4, "material": 0}]}],
        "buffers": [{"uri": name + ".bin", "byteLength": offset}], "bufferViews": views,
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-4, -4, -1], "max": [4, 4, -1]},
                      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC4"},
                      {"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC2"},
                      {"bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    }
    with open(path, "w", encoding="utf-8") as out:
        json.dump(document, out)


def layers_file(path, count):
    """A .gltf of full-screen quads before a perspective camera, the nearest first."""
    positions, indices = [], []
    for i in range(count):
        z, size = -(1.0 + i), 2.0 * (1.0 + i)
        base = len(positions)
        positions += [(-size, -size, z), (size, -size, z), (size, size, z), (-size, size, z)]
        indices += [base, base + 1, base + 2, base, base + 2, base + 3]
    data = b"".join(struct.pack("<3f", *p) for p in positions)
    split = len(data)
    data += struct.pack(f"<{len(indices)}H", *indices)
    with open(path.replace(".gltf", ".bin"), "wb") as out:
        out.write(data)
    low = [min(p[k] for p in positions) for k in range(3)]
    high = [max(p[k] for p in positions) for k in range(3)]
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.5, "zfar": 100.0}}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.5, 0.4, 1]}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "buffers": [{"uri": os.path.basename(path).replace(".gltf", ".bin"), "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": split},
                        {"buffer": 0, "byteOffset": split, "byteLength": len(data) - split}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3", "min": low, "max": high},
                      {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"}],
    }
    with open(path, "w", encoding="utf-8") as out:
        json.dump(document, out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peer", required=True)
    parser.add_argument("--build", default="build")
    parser.add_argument("--models", nargs="*", default=[])
    parser.add_argument("--rows", default="grid,fill,models,vertices,threads,msaa,shaded,share", help="which groups of rows")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--frames", type=int, default=15)
    arguments = parser.parse_args()
    rows = arguments.rows.split(",")
    peer = shlex.split(arguments.peer)
    flat = os.path.join(arguments.build, "bench", "flat_frames")
    product = os.path.join(arguments.build, "apps", "aluminate")
    folder = tempfile.TemporaryDirectory()
    front_to_back = os.path.join(folder.name, "layers.gltf")
    layers_file(front_to_back, 20)
    frames = ["--frames", str(arguments.frames)]

    def ours(scene, width=1280, height=720, threads=1, *more):
        return [flat, "--scene", scene, "--width", str(width), "--height", str(height), "--threads", str(threads), *frames, *more]

    def theirs(scene, width=1280, height=720, threads=0, *more):
        return [*peer, "--scene", scene, "--size", f"{width}x{height}", "--shade", "flat", "--threads", str(threads), *frames, *more]

    # (name, our command, the peer's command or None)
    plan = []
    if "grid" in rows:
        for legs in (1, 4, 8, 32):
            scene = f"synth:grid:{1024 // legs}"
            plan.append((f"grid {legs} px legs", ours(scene, 1024, 1024), theirs(scene, 1024, 1024)))
    if "fill" in rows:
        plan.append(("fill, 20 layers back to front", ours("synth:fill:20"), theirs("synth:fill:20")))
        plan.append(("fill, 20 layers front to back", ours(front_to_back, 1280, 720, 1, "--camera", "gltf"),
                     theirs(front_to_back, 1280, 720, 0, "--cam", "gltf")))
    if "models" in rows:
        for model in arguments.models:
            plan.append((f"{os.path.basename(model)} flat", ours(model), theirs(model)))
    if "threads" in rows:
        for scene in ("synth:grid:256", "synth:fill:20", *arguments.models):
            plan.append((f"{os.path.basename(scene)} flat, 2 threads", ours(scene, threads=2), theirs(scene, threads=2)))
            plan.append((f"{os.path.basename(scene)} flat, 1 thread", ours(scene), theirs(scene)))
    if "msaa" in rows:
        for scene in ("synth:grid:256", "synth:fill:20", *arguments.models):
            plan.append((f"{os.path.basename(scene)} flat, 4 samples", ours(scene, 1280, 720, 1, "--msaa", "4"), None))
            plan.append((f"{os.path.basename(scene)} flat, 1 sample", ours(scene), None))
    if "vertices" in rows:
        plan.append(("2M triangles on 64x64 pixels", ours("synth:grid:1024", 64, 64), theirs("synth:grid:1024", 64, 64)))
    if "shaded" in rows:
        quad = os.path.join(folder.name, "quad.gltf")
        textured_file(quad)
        for model in (quad, *arguments.models):
            camera = "gltf" if model == quad else "outside"
            for name, lights, shade in (("textured", "none", ["--shade", "tex"]), ("lit, 4 lights", "rig:4", ["--shade", "full", "--lights", "4"])):
                out = os.path.join(folder.name, "out.png")
                plan.append((f"{os.path.basename(model)} shaded, {name}",
                             [product, "--quiet", "render", model, "-o", out, "--camera", camera, "--lights", lights, "--threads", "1",
                              "--frames", "3", "--json", "-"],
                             [*peer, "--scene", model, "--size", "1280x720", "--cam", camera, *shade, "--threads", "0", *frames]))

    def measure(command):
        if command[0] != product:
            return run(command)
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            sys.exit(f"{shlex.join(command)} failed:\n{done.stderr}")
        timing = json.loads(done.stdout)["timing"]
        return {"ms_median": timing["frame_ms_median"], "ms_min": timing["frame_ms_min"], "cpu_ms_median": float("nan")}

    if "share" in rows:
        for scene in ("synth:grid:1024", "synth:grid:256", "synth:grid:32", "synth:fill:20", *arguments.models):
            done = subprocess.run([flat, "--scene", scene, "--width", "1024", "--height", "1024", *frames, "--tasks"], capture_output=True, text=True, check=True)
            tasks = json.loads(done.stdout)
            times = {name: value if isinstance(value, float) else sum(value) for name, value in tasks.items()}
            print(f"{os.path.basename(scene):44} " + ", ".join(f"{name.removesuffix('_us')} {100 * t / sum(times.values()):.1f} %" for name, t in times.items()))

    print(f"{'':44} {'ours, ms':>24} {'peer, ms':>24} {'peer / ours':>20}")
    print(f"{'':44} {'median':>8}{'min':>8}{'cpu':>8} {'median':>8}{'min':>8}{'cpu':>8} {'median':>7}{'min':>7}{'cpu':>6}")
    for name, our_command, peer_command in plan:
        a, b = [], []
        for _ in range(arguments.repeat):
            a.append(measure(our_command))
            if peer_command:
                b.append(run(peer_command))

        def figures(runs):
            return (statistics.median(r["ms_median"] for r in runs), min(r["ms_min"] for r in runs),
                    statistics.median(r["cpu_ms_median"] for r in runs))

        mine = figures(a)
        text = f"{name:44} " + "".join(f"{v:8.2f}" for v in mine) + " "
        if b:
            other = figures(b)
            text += "".join(f"{v:8.2f}" for v in other) + " "
            text += f"{other[0] / mine[0]:7.2f}{other[1] / mine[1]:7.2f}{other[2] / mine[2]:6.2f}"
        print(text, flush=True)


if __name__ == "__main__":
    main()
