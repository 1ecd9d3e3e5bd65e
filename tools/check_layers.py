#!/usr/bin/env python3
"""Checks that includes go down only: rooms see the rooms listed for them, third-party headers appear where they are
allowed, no file includes itself through others."""

import fnmatch
import posixpath
import re
import sys

import source_tree

PLATFORM = ["platform/host", "platform/number", "platform/console"]
BELOW_PASSES = PLATFORM + ["rasterizer", "scenes", "calibration", "shading/vm", "shading/compiler", "shading/cost",
                           "shading/brdf", "shading/sky", "shading/light", "shading/filter", "shading/programs"]
ALL_ROOMS = BELOW_PASSES + ["shading/passes", "shading/report"]

# What each room may include besides itself. A folder belongs to the room with the longest matching name.
ROOMS = {
    "platform/number": [],
    "platform/host": [],
    "platform/console": ["platform/host", "platform/number"],
    "rasterizer": PLATFORM,                  # knows no material
    "shading/vm": PLATFORM,                  # runs a quad without a triangle
    "shading/compiler": PLATFORM + ["shading/vm"],
    "shading/cost": PLATFORM + ["shading/vm", "shading/compiler"],
    "shading/programs": PLATFORM + ["shading/vm", "shading/compiler"],
    "shading/brdf": [],                      # the reference shares no code with what it judges
    "shading/sky": PLATFORM + ["shading/brdf"],
    "shading/light": PLATFORM + ["shading/brdf", "shading/sky"],
    "shading/filter": PLATFORM + ["shading/brdf", "shading/vm"],
    "scenes": PLATFORM,
    "calibration": PLATFORM,
    "shading/passes": BELOW_PASSES,
    "shading/report": BELOW_PASSES + ["shading/passes"],
    "apps": ALL_ROOMS,
    "tests": ALL_ROOMS,
    "bench": ALL_ROOMS + ["tests"],          # times what the tests build
    "tools": ALL_ROOMS,
}

# Header prefix -> files that may include it. '*' also spans '/'.
OUTSIDE = ["apps/*", "bench/*", "tests/*"]
THIRD_PARTY = {
    "OpenImageIO/": ["platform/host/image_module.cpp"],
    "tbb/": ["platform/host/parallel.cpp"],
    "oneapi/": ["platform/host/parallel.cpp"],
    "sanitizer/": ["platform/host/parallel.cpp"],
    "spdlog/": ["platform/host/log.cpp"],
    "zlib.h": ["platform/host/png_writer.cpp"],
    "isa-l/": ["platform/host/png_writer.cpp"],
    "png.h": ["platform/host/png_reader.cpp"],
    "jpeglib.h": ["platform/host/jpeg_reader.cpp"],
    "xxhash.h": ["platform/host/hash.cpp"],
    "fmt/": ["*.cpp", "platform/host/error.hpp"],
    "tiny_gltf.h": ["scenes/gltf/tinygltf.*"],
    "nlohmann/json_fwd.hpp": ["scenes/*", "shading/report/*", "apps/*"],
    "nlohmann/": ["scenes/*.cpp", "scenes/generator/*", "shading/report/*.cpp", "shading/cost/*.cpp", "calibration/*.cpp", *OUTSIDE],
    "toml++/": ["platform/host/toml_text.*", *OUTSIDE],
    "CLI/": ["apps/*", "bench/*", "tests/*"],
    "glm/": ["scenes/*", "shading/brdf/*", "shading/sky/*", "shading/filter/*", "shading/passes/*", "shading/report/*",
             "calibration/*", *OUTSIDE],
    "hwy/": ["rasterizer/*.cpp", "shading/vm/*.cpp", "calibration/power.cpp", "rasterizer/*-inl.hpp", "shading/vm/*-inl.hpp"],
    # The compiler module: everything else must start without LLVM.
    "llvm/": ["shading/vm/jit/definitions.*", "shading/vm/jit/flat_code.*", "shading/vm/jit/generator.*", "shading/vm/jit/module.cpp"],
    "glslang/": ["shading/compiler/*.cpp"],
    "spirv-tools/": ["shading/compiler/*.cpp", "tests/compiler/*.cpp"],
    "spirv/": ["shading/compiler/*"],
    "Eigen/": ["calibration/*.cpp", "tests/calibration/*.cpp"],
    "opencv2/": ["calibration/*.cpp"],
    "libraw/": ["calibration/*.cpp"],
    "lensfun/": ["calibration/*.cpp"],
    "libgimp/": ["tools/gimp/*"],
    "squish.h": ["shading/filter/*.cpp", "bench/*"],
    "meshoptimizer.h": ["scenes/*.cpp", "shading/passes/*.cpp", "bench/*"],
    "gtest/": ["tests/*"],
    "gmock/": ["tests/*"],
    "rapidcheck": ["tests/*"],
    "mpfr.h": ["tests/*", "tools/*", "platform/number/*_generator.cpp"],
    "gmp.h": ["tests/*", "tools/*", "platform/number/*_generator.cpp"],
    "benchmark/": ["bench/*"],
    "vulkan/": ["bench/*"],
}

# The operating system is part of the machine we run on.
SYSTEM = {"dlfcn.h", "elf.h", "link.h", "fcntl.h", "cpuid.h", "fnmatch.h", "pthread.h", "pty.h", "sched.h", "signal.h", "stdlib.h", "termios.h", "unistd.h"}
SYSTEM_FILES = ["platform/host/*", *OUTSIDE]

STANDARD = set("""
algorithm any array atomic barrier bit bitset cassert cctype cerrno cfenv cfloat charconv chrono cinttypes climits
clocale cmath codecvt compare complex concepts condition_variable coroutine csetjmp csignal cstdarg cstddef cstdint
cstdio cstdlib cstring ctime cwchar deque exception execution filesystem forward_list fstream functional future
initializer_list iomanip ios iosfwd istream iterator latch limits list locale map memory memory_resource mutex new
numbers numeric optional ostream queue random ranges ratio regex scoped_allocator semaphore set shared_mutex
source_location span sstream stack stdexcept stop_token streambuf string string_view syncstream system_error thread
tuple type_traits typeindex typeinfo unordered_map unordered_set utility valarray variant vector version
""".split())

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(<([^>\n]+)>|"([^"\n]+)"|(\w+))', re.MULTILINE)


def room_of(name):
    folder = posixpath.dirname(name)
    while folder:
        if folder in ROOMS:
            return folder
        folder = posixpath.dirname(folder)
    return None


def matches(name, patterns):
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def outside_problem(name, header):
    """Why this file may not include a header that is not ours, or None."""
    if header in STANDARD:
        return None
    if header in SYSTEM or header.startswith("sys/"):
        return None if matches(name, SYSTEM_FILES) else f"<{header}> belongs in platform/host"
    for prefix in sorted(THIRD_PARTY, key=len, reverse=True):
        if header.startswith(prefix):
            if matches(name, THIRD_PARTY[prefix]):
                return None
            return f"<{header}> is allowed only in {', '.join(THIRD_PARTY[prefix])}"
    return f"<{header}> is in no table of tools/check_layers.py"


def table_problems():
    """The table itself must be free of cycles, else 'down' has no meaning."""
    done, active = set(), []

    def visit(room):
        if room in active:
            return [f"the table of rooms has a cycle: {' -> '.join(active[active.index(room):] + [room])}"]
        if room in done:
            return []
        active.append(room)
        found = [problem for below in ROOMS[room] for problem in visit(below)]
        active.pop()
        done.add(room)
        return found

    return [problem for room in ROOMS for problem in visit(room)]


def cycle_problems(graph):
    """Cycles among files, each reported once."""
    problems, done = [], set()
    for start in sorted(graph):
        path, on_path = [], set()
        stack = [(start, iter(graph.get(start, ())))] if start not in done else []
        if stack:
            path.append(start)
            on_path.add(start)
        while stack:
            name, below = stack[-1]
            target = next(below, None)
            if target is None:
                stack.pop()
                path.pop()
                on_path.discard(name)
                done.add(name)
            elif target in on_path:
                problems.append("include cycle: " + " -> ".join(path[path.index(target):] + [target]))
            elif target not in done:
                stack.append((target, iter(graph.get(target, ()))))
                path.append(target)
                on_path.add(target)
    return problems


def check(root):
    problems = table_problems()
    names = dict(source_tree.files(root))
    graph = {}
    for name, path in names.items():
        if path.suffix not in source_tree.C_FAMILY:
            continue
        text = source_tree.text_of(path)
        if text is None:
            problems.append(f"{name}: not UTF-8 text")
            continue
        room = room_of(name)
        if room is None:
            problems.append(f"{name}: no room of tools/check_layers.py holds this folder")
            continue
        targets = graph.setdefault(name, [])
        code = source_tree.code_only(text)
        for match in INCLUDE.finditer(code):
            place = f"{name}:{source_tree.line_of(code, match.start())}"
            system, own, macro = match.group(2), match.group(3), match.group(4)
            if system:
                problem = outside_problem(name, system)
                if problem:
                    problems.append(f"{place}: {problem}")
                continue
            if macro:
                if macro != "HWY_TARGET_INCLUDE":
                    problems.append(f"{place}: an include must name its file")
                continue
            if own not in names:
                # A header that the build makes beside nothing in the tree: it belongs to the folder it is named in.
                if "generated" not in posixpath.basename(own):
                    problems.append(f'{place}: "{own}" is not in the tree; includes are written from the root')
            elif own != name or "hwy/foreach_target.h" not in code:  # Highway compiles a file again for each target
                targets.append(own)
            target_room = room_of(own)
            if target_room not in (room, None) and target_room not in ROOMS[room]:
                problems.append(f'{place}: {room} must not include {target_room} ("{own}")')
    return problems + cycle_problems(graph)


if __name__ == "__main__":
    tree = source_tree.parse_root(__doc__)
    sys.setrecursionlimit(10000)
    source_tree.report("check_layers", check(tree))
