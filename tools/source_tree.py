"""The files of the project and their text, for the check_* programs. Reads only; skips what is built or hidden."""

import argparse
import pathlib
import re
import sys

SKIPPED_FOLDERS = {".git", "build", "out", "__pycache__", ".cache", ".vscode", ".idea"}
CODE_SUFFIXES = {".hpp", ".cpp", ".def", ".inc", ".hlsl", ".hlsli", ".glsl"}
C_FAMILY = {".hpp", ".cpp", ".def", ".inc"}


def parse_root(description):
    """The --root argument every check takes; the default is the project this file is part of."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent,
                        help="folder to check (default: this project)")
    return parser.parse_args().root.resolve()


def files(root):
    """Every file below root as (name relative to root with '/', path), sorted by name."""
    found = []
    pending = [root]
    while pending:
        for path in pending.pop().iterdir():
            if path.is_symlink():
                continue
            if path.is_dir():
                if path.name not in SKIPPED_FOLDERS:
                    pending.append(path)
            elif path.is_file() and path.name != ".git":  # of a linked work tree: a file that names the real one
                found.append((path.relative_to(root).as_posix(), path))
    return sorted(found)


def text_of(path):
    """The text of a file, or None when it is not text."""
    data = path.read_bytes()
    if b"\0" in data:
        return None
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return None


_TOKENS = re.compile(
    r'(?P<comment>//[^\n]*|/\*.*?\*/)'
    r'|(?P<string>R"(?P<tag>[^(\s]*)\(.*?\)(?P=tag)"|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])\'(?:\\.|[^\'\\\n])+\')',
    re.DOTALL)


def _blank(text):
    return re.sub(r"[^\n]", " ", text)


def code_only(text):
    """C-family text with comments and string contents blanked; line numbers stay. Include lines keep their names."""
    def replace(match):
        token = match.group(0)
        if match.group("comment"):
            return _blank(token)
        line_start = text.rfind("\n", 0, match.start()) + 1
        if re.match(r"\s*#\s*include\b", text[line_start:match.start()]):
            return token
        return token[0] + _blank(token[1:-1]) + token[-1]
    return _TOKENS.sub(replace, text)


def comments_only(text):
    """C-family text with everything but comments blanked; line numbers stay."""
    kept = []
    end = 0
    for match in _TOKENS.finditer(text):
        if not match.group("comment"):
            continue
        kept.append(_blank(text[end:match.start()]))
        kept.append(match.group("comment"))
        end = match.end()
    kept.append(_blank(text[end:]))
    return "".join(kept)


def line_of(text, offset):
    return text.count("\n", 0, offset) + 1


def report(check, problems, warnings=()):
    """Prints one line a problem and ends the program: 0 = clean, 1 = problems."""
    for line in warnings:
        print(f"{check}: warning: {line}")
    for line in problems:
        print(f"{check}: {line}")
    print(f"{check}: {len(problems)} problems" if problems else f"{check}: clean")
    sys.exit(1 if problems else 0)
