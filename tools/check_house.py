#!/usr/bin/env python3
"""Checks the house rules a compiler does not see: file lengths, folder names, words, machine paths, functions and
headers that would make results differ or talk to the wrong stream."""

import re

import source_tree

SOFT_LINES, HARD_LINES = 500, 800
MEASURED_SUFFIXES = source_tree.CODE_SUFFIXES | {".py", ".cmake", ".sh"}

# A folder is a thing of the domain; these are drawers.
BANNED_FOLDERS = {"util", "utils", "common", "misc", "helper", "helpers", "core", "include", "lib", "shared", "stuff"}

# Written in pieces so that this file does not find itself.
BANNED_WORDS = re.compile(r"\b(" + "|".join(["TO" "DO", "FIX" "ME", "XX" "X", "HA" "CK"]) + r")\b")
MACHINE_PATHS = re.compile(r"(?<![\w./*}-])/(" + "|".join(["wor" "k", "roo" "t", "tm" "p", "hom" "e"]) + r")(?![\w-])")

# Same input, same output: no generator without a seed of ours, no distribution (the standard leaves them open).
RANDOM = re.compile(r"(?<![\w.>])(?:std::|::)?(s?rand\s*\(|random_device\b)|std::\w+_distribution\b")
DISTRIBUTION_FREE = ("tests/", "bench/")

# <cmath> where pixels and counters are made: only what IEEE 754 rounds correctly or what moves bits.
EXACT_FOLDERS = ("rasterizer/", "shading/vm/", "platform/number/")
EXACT_CMATH = {"abs", "fabs", "fma", "sqrt", "floor", "ceil", "trunc", "nearbyint", "rint", "copysign", "signbit",
               "isfinite", "isinf", "isnan", "ldexp", "frexp", "scalbn", "ilogb", "logb", "fmin", "fmax"}
CMATH = set("""
acos acosh asin asinh atan atan2 atanh cbrt cos cosh erf erfc exp exp2 expm1 fdim fmod hypot lgamma llrint llround log
log10 log1p log2 lrint lround modf nan nextafter nexttoward pow remainder remquo round sin sinh tan tanh tgamma
beta legendre hermite laguerre assoc_legendre assoc_laguerre riemann_zeta expint lerp
""".split()) | EXACT_CMATH
CMATH_USE = re.compile(r"(?:\bstd|(?<![\w>:]))::(" + "|".join(sorted(CMATH)) + r")(?:f|l)?\b")

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^>"\n]+)[>"]', re.MULTILINE)
BANNED_INCLUDES = {
    "iostream": "stdout is written by apps/, talk goes through platform/host/log.hpp",
    "math.h": "use <cmath> and std::",
    "stdio.h": "use <cstdio>",
    "bits/stdc++.h": "name the headers",
    "immintrin.h": "use Highway, which keeps other machines alive",
}


def folder_problems(names):
    folders = {part for name in names for part in _prefixes(name)}
    return [f"{folder}/: '{folder.rsplit('/', 1)[-1]}' is no name for a folder: say what lives in it"
            for folder in sorted(folders) if folder.rsplit("/", 1)[-1] in BANNED_FOLDERS]


def _prefixes(name):
    parts = name.split("/")[:-1]
    return ["/".join(parts[:i + 1]) for i in range(len(parts))]


def length_findings(name, text):
    """(problems, warnings) about the number of lines."""
    lines = text.count("\n")
    if "generated" in name or lines <= SOFT_LINES:
        return [], []
    if lines > HARD_LINES:
        return [f"{name}: {lines} lines, the limit is {HARD_LINES}"], []
    return [], [f"{name}: {lines} lines, more than {SOFT_LINES}"]


def text_problems(name, text):
    problems = []
    for match in BANNED_WORDS.finditer(text):
        problems.append(f"{name}:{source_tree.line_of(text, match.start())}: '{match.group(1)}': do it or drop it")
    for match in MACHINE_PATHS.finditer(text):
        problems.append(f"{name}:{source_tree.line_of(text, match.start())}: the path '{match.group(0)}' exists on one "
                        "machine only")
    return problems


def code_problems(name, text):
    code = source_tree.code_only(text)
    problems = []

    def add(match, what):
        problems.append(f"{name}:{source_tree.line_of(code, match.start())}: {what}")

    for match in INCLUDE.finditer(code):
        if match.group(1) in BANNED_INCLUDES:
            add(match, f"<{match.group(1)}>: {BANNED_INCLUDES[match.group(1)]}")
    for match in RANDOM.finditer(code):
        if match.group(1) or not name.startswith(DISTRIBUTION_FREE):
            add(match, f"'{match.group(0).strip()}' gives other numbers on another run or library")
    if name.startswith(EXACT_FOLDERS):
        for match in CMATH_USE.finditer(code):
            if match.group(1) not in EXACT_CMATH:
                add(match, f"'{match.group(0)}' is not correctly rounded everywhere: use the number system")
    for match in re.finditer(r"\busing\s+namespace\s+std\s*;", code):
        add(match, "'using namespace std' hides where a name comes from")
    # Highway compiles its -inl.hpp files once for each target.
    if name.endswith(".hpp") and not name.endswith("-inl.hpp") and "#pragma once" not in code:
        problems.append(f"{name}: a header begins with #pragma once")
    return problems


# Packages are looked up in one place, which names the Debian package of what is missing and keeps tools/deps true.
PACKAGES = "cmake/packages.cmake"
ALWAYS_THERE = {"Threads", "Python3"}
FIND_PACKAGE = re.compile(r"^[^#\n]*\bfind_package\s*\(\s*(\w[\w-]*)", re.MULTILINE)


def cmake_problems(name, text, packages):
    if name == PACKAGES:
        return []
    return [f"{name}:{source_tree.line_of(text, match.start(1))}: {match.group(1)} is not looked for in {PACKAGES}"
            for match in FIND_PACKAGE.finditer(text)
            if match.group(1) not in ALWAYS_THERE and not re.search(rf"\b{re.escape(match.group(1))}\b", packages)]


def check(root):
    tree = source_tree.files(root)
    problems, warnings = folder_problems([name for name, _ in tree]), []
    packages = (root / PACKAGES).read_text() if (root / PACKAGES).is_file() else ""
    for name, path in tree:
        text = source_tree.text_of(path)
        if text is None:
            continue
        if path.name == "CMakeLists.txt" or path.suffix == ".cmake":
            problems += cmake_problems(name, text, packages)
        if path.suffix in MEASURED_SUFFIXES:
            found, soft = length_findings(name, text)
            problems += found
            warnings += soft
        problems += text_problems(name, text)
        if path.suffix in source_tree.C_FAMILY:
            problems += code_problems(name, text)
    return problems, warnings


if __name__ == "__main__":
    source_tree.report("check_house", *check(source_tree.parse_root(__doc__)))
